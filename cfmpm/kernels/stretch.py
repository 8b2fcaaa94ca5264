"""Stretches of material points."""

from __future__ import annotations

import math

from cfmpm._jit import kernel


@kernel
def extent(h):
    """Return the largest stretch of a point, or the smallest inverted where that is larger.

    Parameters
    ----------
    h : (2, 2) float
        H = F - I with det F > 0.

    Returns
    -------
    float
    """
    # Singular values of F: the lengths of its conformal and anticonformal parts, +-.
    conformal = 0.5 * math.hypot(2.0 + h[0, 0] + h[1, 1], h[1, 0] - h[0, 1])
    other = 0.5 * math.hypot(h[0, 0] - h[1, 1], h[1, 0] + h[0, 1])
    return max(conformal + other, 1.0 / (conformal - other))


@kernel
def largest_jump(before, after):
    """Find by how much the stretch of any point has grown.

    Parameters
    ----------
    before, after : (p, 2, 2) float
        H = F - I with det F > 0.

    Returns
    -------
    float
        Largest ratio of `extent`.
    """
    largest = 0.0
    for p in range(len(before)):
        largest = max(largest, extent(after[p]) / extent(before[p]))
    return largest
