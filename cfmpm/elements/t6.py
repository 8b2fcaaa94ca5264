"""Six nodes and three material points: quadratic displacement, linear strain.

The points are the centroids of the paper's corner sub-triangles (section 2.3), and the three-point
rule of degree 2, which the stiffness needs.
"""

from __future__ import annotations

import numpy as np

from cfmpm.elements.record import Element

T6 = Element(
    order=2,
    points=np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3),
    weights=np.ones(3),
    locks=False,
    # Quadrilaterals of equal area, from a corner over the middles of its two sides to the centroid.
    domains=tuple(
        np.roll([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]], k, axis=1)
        for k in range(3)
    ),
)
