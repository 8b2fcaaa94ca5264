"""T10: ten nodes and six material points. Displacement of degree 3, strain of degree 2."""

from __future__ import annotations

import numpy as np

from cfmpm.elements.record import Element

# Of degree 4 (Strang and Fix 1973, table 4.1): three points near the sides, three near the corners.
NEAR_SIDE, NEAR_CORNER = 0.445948490915965, 0.091576213509771
PARTS = 0.223381589678011, 0.109951743655322

# The domain of a point near a corner is the triangle cut off there; that of a point near a side is
# what is left between the side and the centroid.
CUT = np.sqrt(PARTS[1])
AT_SIDE = [
    [0, 1 - CUT, CUT],
    [0, CUT, 1 - CUT],
    [CUT / 2, CUT / 2, 1 - CUT],
    [1 / 3, 1 / 3, 1 / 3],
    [CUT / 2, 1 - CUT, CUT / 2],
]
AT_CORNER = [[1, 0, 0], [1 - CUT, CUT, 0], [1 - CUT, 0, CUT]]

T10 = Element(
    order=3,
    points=np.array(
        [np.roll([1 - 2 * a, a, a], k) for a in (NEAR_SIDE, NEAR_CORNER) for k in range(3)]
    ),
    weights=np.repeat(PARTS, 3),
    locks=False,
    domains=tuple(np.roll(part, k, axis=1) for part in (AT_SIDE, AT_CORNER) for k in range(3)),
)
