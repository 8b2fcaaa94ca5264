"""What finite deformation adds to the work of a state of small strain."""

from __future__ import annotations

import math

from cfmpm._jit import kernel
from cfmpm.kernels.finite import patch_means
from cfmpm.kernels.laws.dispatch import respond


@kernel
def departure(volume, material, law, constants, internal, displacement_gradient, stress, patch):
    """Sum the stress work that small strain misses at a displacement gradient.

    Parameters
    ----------
    volume, material, law, constants, internal, patch
        As in `finite.update_points`.
    displacement_gradient : (p, 2, 2) float
    stress : (p, 3) float
        Stress of small strain at it: xx, yy, xy [MPa].

    Returns
    -------
    work : float
        sum_p (P_ij - sigma_ij) H_ij V_p [N]; nan where det F of a point is not positive.
    linear : float
        sum_p sigma_ij H_ij V_p [N].
    size : float
        The mean norm of H, weighted with that.
    """
    H = displacement_gradient
    means = patch_means(volume, H, patch)
    patched = len(patch) > 0
    work, linear, size = 0.0, 0.0, 0.0
    for p in range(len(volume)):
        h = (H[p, 0, 0], H[p, 0, 1], H[p, 1, 0], H[p, 1, 1])
        y = h[0] + h[3] + (h[0] * h[3] - h[1] * h[2])
        J = 1.0 + y
        if not J > 0.0:
            return math.nan, math.nan, math.nan
        m = material[p]
        mean = means[patch[p]] if patched else y
        tau = respond(law[m], constants, m, h, mean, patched, internal, p)[0]
        # P : H = tau : H F^-1
        lxx = (h[0] * (1.0 + h[3]) - h[1] * h[2]) / J
        lyy = (h[3] * (1.0 + h[0]) - h[1] * h[2]) / J
        lxy_yx = (h[1] + h[2]) / J
        found = tau[0] * lxx + tau[1] * lyy + tau[2] * lxy_yx
        at_small = stress[p, 0] * h[0] + stress[p, 1] * h[3] + stress[p, 2] * (h[1] + h[2])
        work += volume[p] * (found - at_small)
        linear += volume[p] * at_small
        norm = math.sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2] + h[3] * h[3])
        size += volume[p] * at_small * norm
    return work, linear, size / linear if linear > 0.0 else 0.0
