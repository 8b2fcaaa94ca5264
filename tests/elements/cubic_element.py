"""An element of order 3 with ten nodes and six points, as another package would add it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cfmpm.elements.record import Element
from cfmpm.registry.elements import ElementEntry

# Of degree 4, which the stiffness needs: three points near the sides and three near the corners
# (Strang and Fix 1973, table 4.1).
NEAR_SIDE, NEAR_CORNER = 0.445948490915965, 0.091576213509771
PARTS = 0.223381589678011, 0.109951743655322

# A point near a corner stands for the triangle that is cut off there, one near a side for what is
# left between that side and the centroid.
CUT = np.sqrt(PARTS[1])
AT_SIDE = [
    [0, 1 - CUT, CUT],
    [0, CUT, 1 - CUT],
    [CUT / 2, CUT / 2, 1 - CUT],
    [1 / 3, 1 / 3, 1 / 3],
    [CUT / 2, 1 - CUT, CUT / 2],
]
AT_CORNER = [[1, 0, 0], [1 - CUT, CUT, 0], [1 - CUT, 0, CUT]]

CUBIC = Element(
    order=3,
    points=np.array(
        [np.roll([1 - 2 * a, a, a], k) for a in (NEAR_SIDE, NEAR_CORNER) for k in range(3)]
    ),
    weights=np.repeat(PARTS, 3),
    locks=False,
    domains=tuple(np.roll(part, k, axis=1) for part in (AT_SIDE, AT_CORNER) for k in range(3)),
)
ENTRY = ElementEntry("6 points", "cubic_element:CUBIC")

# The same without a word on what its points stand for, which growth asks for.
CUBIC_STATIONARY = replace(CUBIC, domains=None)
STATIONARY_ENTRY = ElementEntry("6 points", "cubic_element:CUBIC_STATIONARY")
