"""Stretches of material points."""

from __future__ import annotations

import math

from cfmpm._jit import kernel


@kernel
def largest_stretch(displacement_gradient):
    """Find the largest stretch of all points, or the smallest inverted where that is larger.

    Parameters
    ----------
    displacement_gradient : (p, 2, 2) float
        H = F - I with det F > 0.

    Returns
    -------
    float
    """
    largest = 1.0
    for p in range(len(displacement_gradient)):
        h = displacement_gradient[p]
        # Singular values of F: the lengths of its conformal and anticonformal parts, +-.
        sum_ = 0.5 * math.hypot(2.0 + h[0, 0] + h[1, 1], h[1, 0] - h[0, 1])
        difference = 0.5 * math.hypot(h[0, 0] - h[1, 1], h[1, 0] + h[0, 1])
        largest = max(largest, sum_ + difference, 1.0 / (sum_ - difference))
    return largest
