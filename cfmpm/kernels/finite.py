"""Sums over material points at finite strain: update, forces, stiffness, configurational force.

All integrals are over the reference configuration: F = I + H, reference gradients G = dS/dX and
reference volumes V. On a grid that was reset at a state F_n the same kernels hold with that state
as `base` and G = F_n^T dS/dx, the pull-back of the gradient on the grid.
"""

from __future__ import annotations

import math

import numpy as np

from cfmpm._jit import kernel
from cfmpm.kernels.laws import respond


@kernel
def patch_means(volume, displacement_gradient, patch):
    """Average J - 1 over patches of points.

    Parameters
    ----------
    volume : (p,) float
    displacement_gradient : (p, 2, 2) float
    patch : (p,) or (0,) int
        Patch of each point, numbered without gaps; empty where points stand alone.

    Returns
    -------
    (n_patches,) float
    """
    n_patches = patch.max() + 1 if len(patch) else 0
    whole = np.zeros(n_patches)
    mean = np.zeros(n_patches)
    for p in range(len(patch)):
        h = displacement_gradient[p]
        whole[patch[p]] += volume[p]
        mean[patch[p]] += volume[p] * (h[0, 0] + h[1, 1] + (h[0, 0] * h[1, 1] - h[0, 1] * h[1, 0]))
    return mean / whole


@kernel
def update_points(
    elements,
    point_element,
    gradients,
    base,
    volume,
    material,
    law,
    parameters,
    history,
    displacement,
    patch,
):
    """Update points from the displacement of the grid.

    Parameters
    ----------
    elements : (m, k) int
    point_element : (p,) int
    gradients : (p, k, 2) float
        Reference gradients dS_I/dX_j [1/mm].
    base : (p, 2, 2) float
        Displacement gradient where the grid's displacement is zero.
    volume : (p,) float
        Reference volume [mm^3 per mm of thickness].
    material : (p,) int
        Row of `law` and `parameters`.
    law : (q,) int
        One of the constants of `laws`.
    parameters : (q, 4) float
        lambda, mu, yield stress, hardening modulus [MPa].
    history : (p, 6) or, without `J2`, (p, 0) float
        State at the start of the step.
    displacement : (n, 2) float
        Of the nodes [mm].
    patch : (p,) or (0,) int
        As in `patch_means`.

    Returns
    -------
    displacement_gradient : (p, 2, 2) float
        H = base + sum_I u_I (x) dS_I/dX.
    stress : (p, 3) float
        Cauchy stress xx, yy, xy [MPa]; nan where det F <= 0.
    energy : (p,) float
        Stored energy per reference volume [N mm/mm^3]; inf where det F <= 0.
    new_history : like `history`
    det_F : (p,) float
    """
    n, k = gradients.shape[:2]
    displacement_gradient = np.empty((n, 2, 2))
    stress = np.empty((n, 3))
    energy = np.empty(n)
    new_history = np.zeros_like(history)
    det_F = np.empty(n)
    for p in range(n):
        e = point_element[p]
        hxx, hxy = base[p, 0, 0], base[p, 0, 1]
        hyx, hyy = base[p, 1, 0], base[p, 1, 1]
        for a in range(k):
            node = elements[e, a]
            ux, uy = displacement[node, 0], displacement[node, 1]
            gx, gy = gradients[p, a, 0], gradients[p, a, 1]
            hxx += ux * gx
            hxy += ux * gy
            hyx += uy * gx
            hyy += uy * gy
        displacement_gradient[p, 0, 0] = hxx
        displacement_gradient[p, 0, 1] = hxy
        displacement_gradient[p, 1, 0] = hyx
        displacement_gradient[p, 1, 1] = hyy
    means = patch_means(volume, displacement_gradient, patch)
    patched = len(patch) > 0
    for p in range(n):
        hxx, hxy = displacement_gradient[p, 0, 0], displacement_gradient[p, 0, 1]
        hyx, hyy = displacement_gradient[p, 1, 0], displacement_gradient[p, 1, 1]
        y = hxx + hyy + (hxx * hyy - hxy * hyx)
        J = 1.0 + y
        det_F[p] = J
        if not J > 0.0:
            stress[p] = math.nan
            energy[p] = math.inf
            new_history[p] = history[p]
            continue
        m = material[p]
        tau, energy[p], _, state = respond(
            law[m],
            parameters[m, 0],
            parameters[m, 1],
            parameters[m, 2],
            parameters[m, 3],
            (hxx, hxy, hyx, hyy),
            means[patch[p]] if patched else y,
            patched,
            history,
            p,
        )
        for i in range(3):
            stress[p, i] = tau[i] / J
        for i in range(history.shape[1]):
            new_history[p, i] = state[i]
    return displacement_gradient, stress, energy, new_history, det_F


@kernel
def nominal_stress(displacement_gradient, stress, p):
    """Return the first Piola-Kirchhoff stress P = J sigma F^-T of a point: xx, xy, yx, yy."""
    fxx, fxy = 1.0 + displacement_gradient[p, 0, 0], displacement_gradient[p, 0, 1]
    fyx, fyy = displacement_gradient[p, 1, 0], 1.0 + displacement_gradient[p, 1, 1]
    sxx, syy, sxy = stress[p, 0], stress[p, 1], stress[p, 2]
    return (
        sxx * fyy - sxy * fxy,
        sxy * fxx - sxx * fyx,
        sxy * fyy - syy * fxy,
        syy * fxx - sxy * fyx,
    )


@kernel
def internal_force(
    elements, n_nodes, point_element, gradients, volume, displacement_gradient, stress
):
    """Sum the internal force f_I,i = sum_p P_ij dS_I/dX_j V_p (paper eq 13, pulled back).

    Parameters
    ----------
    elements : (m, k) int
    n_nodes : int
    point_element : (p,) int
    gradients : (p, k, 2) float
    volume : (p,) float
    displacement_gradient : (p, 2, 2) float
    stress : (p, 3) float
        Cauchy stress [MPa].

    Returns
    -------
    (n, 2) float
        [N/mm].
    """
    force = np.zeros((n_nodes, 2))
    for p in range(len(point_element)):
        e = point_element[p]
        pxx, pxy, pyx, pyy = nominal_stress(displacement_gradient, stress, p)
        for a in range(elements.shape[1]):
            node = elements[e, a]
            gx, gy = gradients[p, a, 0] * volume[p], gradients[p, a, 1] * volume[p]
            force[node, 0] += pxx * gx + pxy * gy
            force[node, 1] += pyx * gx + pyy * gy
    return force


@kernel
def entry_slots(elements, free, indptr, indices):
    """Find where the stiffness of each element goes in the matrix.

    Parameters
    ----------
    elements, free, indptr, indices
        As in `assembly.sparsity`; fewer than 2^31 entries.

    Returns
    -------
    (m, 2k, 2k) int32
        Position in the data of the CSR matrix; -1 where a degree of freedom is prescribed.
    """
    m, k = elements.shape
    slots = np.full((m, 2 * k, 2 * k), -1, np.int32)
    for e in range(m):
        for i in range(2 * k):
            row = free[elements[e, i // 2], i % 2]
            if row < 0:
                continue
            for j in range(2 * k):
                column = free[elements[e, j // 2], j % 2]
                if column < 0:
                    continue
                low, high = indptr[row], indptr[row + 1]
                while high - low > 1:
                    middle = (low + high) // 2
                    if indices[middle] <= column:
                        low = middle
                    else:
                        high = middle
                slots[e, i, j] = low
    return slots


@kernel
def stiffness(
    slots,
    n_entries,
    point_element,
    gradients,
    volume,
    material,
    law,
    parameters,
    history,
    displacement_gradient,
    patch,
):
    """Assemble the tangent stiffness for the free degrees of freedom.

    K_aibk = sum_p V_p (g_a,j c_ijkl g_b,l + delta_ik g_a,j tau_jl g_b,l) with the spatial
    gradient g = F^-T dS/dX (paper eqs 9 to 12 with misprints put right; de Souza Neto, Peric and
    Owen 2008, section 4.3). With patches `patches.coupling` is to be added.

    Parameters
    ----------
    slots : (m, 2k, 2k) int
        From `entry_slots`.
    n_entries : int
        Entries of the matrix.
    point_element, gradients, volume, material, law, parameters, history, patch
        As in `update_points`; the state is that at the start of the step.
    displacement_gradient : (p, 2, 2) float
        Of the present displacement; det F > 0.

    Returns
    -------
    (n_entries,) float
        Values of the CSR matrix [N/mm^2: N/mm per mm of thickness], symmetric to the bit.
    """
    data = np.zeros(n_entries)
    n, k = gradients.shape[:2]
    means = patch_means(volume, displacement_gradient, patch)
    patched = len(patch) > 0
    block = np.zeros((2 * k, 2 * k))
    spatial = np.empty((k, 2))
    for p in range(n):
        hxx, hxy = displacement_gradient[p, 0, 0], displacement_gradient[p, 0, 1]
        hyx, hyy = displacement_gradient[p, 1, 0], displacement_gradient[p, 1, 1]
        y = hxx + hyy + (hxx * hyy - hxy * hyx)
        m = material[p]
        tau, _, c, _ = respond(
            law[m],
            parameters[m, 0],
            parameters[m, 1],
            parameters[m, 2],
            parameters[m, 3],
            (hxx, hxy, hyx, hyy),
            means[patch[p]] if patched else y,
            patched,
            history,
            p,
        )
        J = 1.0 + y
        v = volume[p]
        txx, tyy, txy = v * tau[0], v * tau[1], v * tau[2]
        c11, c22, c12 = v * c[0], v * c[1], v * c[2]
        c13, c23, c33 = v * c[3], v * c[4], v * c[5]
        for a in range(k):
            gx, gy = gradients[p, a, 0], gradients[p, a, 1]
            spatial[a, 0] = ((1.0 + hyy) * gx - hyx * gy) / J
            spatial[a, 1] = ((1.0 + hxx) * gy - hxy * gx) / J
        for a in range(k):
            ax, ay = spatial[a, 0], spatial[a, 1]
            # Rows of node a: c : sym(e_i (x) g_a), and tau g_a.
            xxx, xyy, xxy = c11 * ax + c13 * ay, c12 * ax + c23 * ay, c13 * ax + c33 * ay
            yxx, yyy, yxy = c12 * ay + c13 * ax, c22 * ay + c23 * ax, c23 * ay + c33 * ax
            sx, sy = txx * ax + txy * ay, txy * ax + tyy * ay
            for b in range(a, k):
                bx, by = spatial[b, 0], spatial[b, 1]
                initial = sx * bx + sy * by
                block[2 * a, 2 * b] += xxx * bx + xxy * by + initial
                block[2 * a, 2 * b + 1] += xxy * bx + xyy * by
                block[2 * a + 1, 2 * b] += yxx * bx + yxy * by
                block[2 * a + 1, 2 * b + 1] += yxy * bx + yyy * by + initial
        e = point_element[p]
        if p + 1 < n and point_element[p + 1] == e:
            continue
        # Points of one element follow each other: their sum is scattered once.
        for i in range(2 * k):
            for j in range(i, 2 * k):
                if slots[e, i, j] >= 0:
                    data[slots[e, i, j]] += block[i, j]
                    if j > i:
                        data[slots[e, j, i]] += block[i, j]
        block[:] = 0.0
    return data


@kernel
def eshelby_stress(displacement_gradient, stress, energy):
    """Return the Eshelby stress Sigma = W I - F^T P of each point.

    Parameters
    ----------
    displacement_gradient : (p, 2, 2) float
    stress : (p, 3) float
        Cauchy stress [MPa].
    energy : (p,) float
        Per reference volume [N mm/mm^3].

    Returns
    -------
    (p, 2, 2) float
        [MPa]; F^T P is symmetric for isotropic laws (Eshelby 1975; Maugin 1993, ch. 4).
    """
    n = len(energy)
    result = np.empty((n, 2, 2))
    for p in range(n):
        fxx, fxy = 1.0 + displacement_gradient[p, 0, 0], displacement_gradient[p, 0, 1]
        fyx, fyy = displacement_gradient[p, 1, 0], 1.0 + displacement_gradient[p, 1, 1]
        pxx, pxy, pyx, pyy = nominal_stress(displacement_gradient, stress, p)
        result[p, 0, 0] = energy[p] - fxx * pxx - fyx * pyx
        result[p, 0, 1] = -fxx * pxy - fyx * pyy
        result[p, 1, 0] = -fxy * pxx - fyy * pyx
        result[p, 1, 1] = energy[p] - fxy * pxy - fyy * pyy
    return result


@kernel
def configurational_force(
    elements, n_nodes, point_element, gradients, volume, displacement_gradient, stress, energy
):
    """Sum the configurational force at every node.

    CF_I,i = - sum_p (W delta_ij - H_ki P_kj) dS_I/dX_j V_p. With H in place of F the sum differs
    by the internal force at the node, which is zero in balance, and round-off of P does not
    swamp the energy at small strain.

    Parameters
    ----------
    elements, n_nodes, point_element, gradients, volume, displacement_gradient, stress
        As in `internal_force`.
    energy : (p,) float
        Per reference volume [N mm/mm^3].

    Returns
    -------
    (n, 2) float
        [N/mm].
    """
    force = np.zeros((n_nodes, 2))
    for p in range(len(point_element)):
        h = displacement_gradient[p]
        pxx, pxy, pyx, pyy = nominal_stress(displacement_gradient, stress, p)
        exx = energy[p] - h[0, 0] * pxx - h[1, 0] * pyx
        exy = -h[0, 0] * pxy - h[1, 0] * pyy
        eyx = -h[0, 1] * pxx - h[1, 1] * pyx
        eyy = energy[p] - h[0, 1] * pxy - h[1, 1] * pyy
        e = point_element[p]
        for a in range(elements.shape[1]):
            node = elements[e, a]
            gx, gy = gradients[p, a, 0] * volume[p], gradients[p, a, 1] * volume[p]
            force[node, 0] -= exx * gx + exy * gy
            force[node, 1] -= eyx * gx + eyy * gy
    return force
