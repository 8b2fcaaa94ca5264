"""T15: fifteen nodes and twelve material points. Displacement of degree 4, strain of degree 3."""

from __future__ import annotations

import numpy as np

from cfmpm.elements.record import Element

# Of degree 6 (Strang and Fix 1973, table 4.1): three points around the centroid, three near the
# corners, six along the sides.
AROUND, NEAR_CORNER = 0.249286745170910, 0.063089014491502
ALONG = 0.310352451033784, 0.053145049844817
PARTS = 0.116786275726379, 0.050844906370207, 0.082851075618374

# The domain of a point near a corner is the triangle cut off there. The domains of the three points
# around the centroid are the kites of the inner triangle, whose area is theirs. What is left along
# a side is halved at its midpoint.
CUT = np.sqrt(PARTS[1])
RIM = (1 - np.sqrt(3 * PARTS[0])) / 3
AT_CORNER = [[1, 0, 0], [1 - CUT, CUT, 0], [1 - CUT, 0, CUT]]
MIDDLE = (1 - RIM) / 2
KITE = [
    [1 - 2 * RIM, RIM, RIM],
    [MIDDLE, MIDDLE, RIM],
    [1 / 3, 1 / 3, 1 / 3],
    [MIDDLE, RIM, MIDDLE],
]
# From corner 0 to the midpoint of side 01, and of side 20.
AFTER = [
    [1 - CUT, CUT, 0],
    [1 / 2, 1 / 2, 0],
    [MIDDLE, MIDDLE, RIM],
    [1 - 2 * RIM, RIM, RIM],
    [1 - CUT, CUT / 2, CUT / 2],
]
BEFORE = [[a, c, b] for a, b, c in reversed(AFTER)]


def _thrice(rows: list[list[float]]) -> list[np.ndarray]:
    return [np.roll(rows, k, axis=1) for k in range(3)]


T15 = Element(
    order=4,
    points=np.concatenate(
        [
            *_thrice([[1 - 2 * AROUND, AROUND, AROUND]]),
            *_thrice([[1 - 2 * NEAR_CORNER, NEAR_CORNER, NEAR_CORNER]]),
            *_thrice([[1 - sum(ALONG), *ALONG]]),
            *_thrice([[1 - sum(ALONG), *ALONG[::-1]]]),
        ]
    ),
    weights=np.repeat(PARTS, [3, 3, 6]),
    locks=False,
    domains=(*_thrice(KITE), *_thrice(AT_CORNER), *_thrice(AFTER), *_thrice(BEFORE)),
)
