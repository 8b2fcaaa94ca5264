"""Update of material points at small strain."""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel


@kernel
def linear_elastic(elements, point_element, gradients, material, elastic, displacement):
    """Compute displacement gradient, stress and energy of linear elastic points.

    Parameters
    ----------
    elements : (m, k) int
        Nodes of each element.
    point_element : (p,) int
        Element of each point.
    gradients : (p, k, 2) float
        dS_I/dX_j [1/mm].
    material : (p,) int
        Row of `elastic`.
    elastic : (q, 3, 3) float
        Elastic matrix of the plane problem [MPa]: stress xx, yy, xy from strain xx, yy, 2 xy.
    displacement : (n, 2) float
        Nodal displacement [mm].

    Returns
    -------
    displacement_gradient : (p, 2, 2) float
        u_i,j = sum_I u_I,i dS_I/dX_j.
    stress : (p, 3) float
        sigma_xx, sigma_yy, sigma_xy [MPa].
    energy : (p,) float
        psi = sigma_ij u_i,j / 2 [N mm/mm^3] (paper eq 20, indices corrected).
    """
    n, k = gradients.shape[:2]
    displacement_gradient = np.empty((n, 2, 2))
    stress = np.empty((n, 3))
    energy = np.empty(n)
    for p in range(n):
        e = point_element[p]
        hxx = hxy = hyx = hyy = 0.0
        for a in range(k):
            node = elements[e, a]
            ux, uy = displacement[node, 0], displacement[node, 1]
            gx, gy = gradients[p, a, 0], gradients[p, a, 1]
            hxx += ux * gx
            hxy += ux * gy
            hyx += uy * gx
            hyy += uy * gy
        m, shear = material[p], hxy + hyx
        sxx = elastic[m, 0, 0] * hxx + elastic[m, 0, 1] * hyy + elastic[m, 0, 2] * shear
        syy = elastic[m, 0, 1] * hxx + elastic[m, 1, 1] * hyy + elastic[m, 1, 2] * shear
        sxy = elastic[m, 0, 2] * hxx + elastic[m, 1, 2] * hyy + elastic[m, 2, 2] * shear
        displacement_gradient[p, 0, 0] = hxx
        displacement_gradient[p, 0, 1] = hxy
        displacement_gradient[p, 1, 0] = hyx
        displacement_gradient[p, 1, 1] = hyy
        stress[p, 0] = sxx
        stress[p, 1] = syy
        stress[p, 2] = sxy
        energy[p] = 0.5 * (sxx * hxx + syy * hyy + sxy * shear)
    return displacement_gradient, stress, energy
