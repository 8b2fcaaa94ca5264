"""T6: six nodes and three material points. Quadratic displacement, linear strain.

The points are the centroids of the corner sub-triangles (paper section 2.3, Fig. 2(b)). They are
also the three-point Gauss rule of degree 2, which is exact for the stiffness.
"""

from __future__ import annotations

import numpy as np

from cfmpm.elements.record import Element

T6 = Element(
    order=2,
    points=np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3),
    weights=np.ones(3),
    locks=False,
    # Quadrilaterals of equal area: corner, midpoint of a side, centroid, midpoint of a side.
    domains=tuple(
        np.roll([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]], k, axis=1)
        for k in range(3)
    ),
)
