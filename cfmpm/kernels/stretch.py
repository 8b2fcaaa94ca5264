"""Principal stretches of material points."""

from __future__ import annotations

import math

from cfmpm._jit import kernel


@kernel
def extent(h):
    """Return the largest principal stretch, or the inverse of the smallest if that is larger.

    Parameters
    ----------
    h : (2, 2) float
        H = F - I with det F > 0.

    Returns
    -------
    float
        max(lambda_1, 1 / lambda_2) of the principal stretches lambda_1 >= lambda_2; at least 1.
    """
    # Singular values of F: sum and difference of the magnitudes of its conformal and anticonformal
    # parts.
    conformal = 0.5 * math.hypot(2.0 + h[0, 0] + h[1, 1], h[1, 0] - h[0, 1])
    other = 0.5 * math.hypot(h[0, 0] - h[1, 1], h[1, 0] + h[0, 1])
    return max(conformal + other, 1.0 / (conformal - other))


@kernel
def largest_jump(before, after):
    """Return the largest ratio of `extent` after and before a load step, over all points.

    Parameters
    ----------
    before, after : (p, 2, 2) float
        H = F - I with det F > 0.

    Returns
    -------
    float
    """
    largest = 0.0
    for p in range(len(before)):
        largest = max(largest, extent(after[p]) / extent(before[p]))
    return largest
