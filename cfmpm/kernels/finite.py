"""Finite deformation: update of points, nodal forces, stiffness, configurational force.

All integrals are over the reference configuration, with F = I + H, reference gradients dS/dX and
reference volumes V. For a grid that was reset at a state F_n = I + H_n the same kernels apply with
`base` = H_n and dS/dX = F_n^T dS/dx, the pull-back of the gradient on the grid.
"""

from __future__ import annotations

import math

import numpy as np

from cfmpm._jit import kernel
from cfmpm.kernels.laws.dispatch import respond, stress_across


@kernel
def patch_means(volume, displacement_gradient, patch):
    """Average J - 1 over patches of points (de Souza Neto, Pires and Owen 2005).

    Parameters
    ----------
    volume : (p,) float
        Reference volume [mm^3 per mm of thickness].
    displacement_gradient : (p, 2, 2) float
        H = F - I.
    patch : (p,) or (0,) int
        Patch of each point, numbered without gaps; empty if there are no patches.

    Returns
    -------
    (n_patches,) float
        Mean weighted by volume.
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
def displacement_gradients(elements, point_element, gradients, base, displacement):
    """Compute the displacement gradient of each point.

    Parameters
    ----------
    elements, point_element, gradients, base, displacement
        As in `update_points`.

    Returns
    -------
    (p, 2, 2) float
        H = base + sum_I u_I (x) dS_I/dX (total Lagrangian form of paper eq 8).
    """
    n, k = gradients.shape[:2]
    displacement_gradient = np.empty((n, 2, 2))
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
    return displacement_gradient


@kernel
def update_points(
    elements,
    point_element,
    gradients,
    base,
    volume,
    material,
    law,
    constants,
    internal,
    displacement,
    patch,
):
    """Compute the state of points from the nodal displacement.

    Parameters
    ----------
    elements : (m, k) int
        Nodes of each element.
    point_element : (p,) int
        Element of each point.
    gradients : (p, k, 2) float
        Reference gradients dS_I/dX_j [1/mm].
    base : (p, 2, 2) float
        Displacement gradient at zero nodal displacement: that at the last reset of the grid.
    volume : (p,) float
        Reference volume [mm^3 per mm of thickness].
    material : (p,) int
        Row of `law` and `constants`.
    law : (q,) int
        Number of the law, from `laws.dispatch.NUMBERS`.
    constants : (q, c) float
        lambda, mu [MPa] and the constants of the laws.
    internal : (p, h) float
        Internal variables at the start of the step; h = 0 if no law has any.
    displacement : (n, 2) float
        Nodal displacement [mm].
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
    new_internal : (p, h) float
        Internal variables at the end of the step.
    det_F : (p,) float
        J of each point, not averaged over patches.
    """
    H = displacement_gradients(elements, point_element, gradients, base, displacement)
    n = len(point_element)
    stress, energy, det_F = np.empty((n, 3)), np.empty(n), np.empty(n)
    new_internal = np.zeros_like(internal)
    means = patch_means(volume, H, patch)
    patched = len(patch) > 0
    for p in range(n):
        h = (H[p, 0, 0], H[p, 0, 1], H[p, 1, 0], H[p, 1, 1])
        y = h[0] + h[3] + (h[0] * h[3] - h[1] * h[2])
        J = 1.0 + y
        det_F[p] = J
        if not J > 0.0:
            stress[p] = math.nan
            energy[p] = math.inf
            new_internal[p] = internal[p]
            continue
        m = material[p]
        mean = means[patch[p]] if patched else y
        tau, energy[p], _, state = respond(law[m], constants, m, h, mean, patched, internal, p)
        for i in range(3):
            stress[p, i] = tau[i] / J
        for i in range(internal.shape[1]):
            new_internal[p, i] = state[i]
    return H, stress, energy, new_internal, det_F


@kernel
def stresses_across(volume, material, law, constants, displacement_gradient, stress, patch):
    """Return the out-of-plane stress of points in plane strain.

    Parameters
    ----------
    volume, material, law, constants, patch
        As in `update_points`.
    displacement_gradient : (p, 2, 2) float
        H = F - I with det F > 0.
    stress : (p, 3) float
        In-plane Cauchy stress xx, yy, xy [MPa].

    Returns
    -------
    (p,) float
        sigma_zz [MPa].
    """
    H = displacement_gradient
    n = len(material)
    result = np.empty(n)
    means = patch_means(volume, H, patch)
    for p in range(n):
        h = (H[p, 0, 0], H[p, 0, 1], H[p, 1, 0], H[p, 1, 1])
        y = h[0] + h[3] + (h[0] * h[3] - h[1] * h[2])
        mean = means[patch[p]] if len(patch) else y
        in_plane = (stress[p, 0], stress[p, 1], stress[p, 2])
        m = material[p]
        result[p] = stress_across(law[m], constants, m, h, mean, in_plane)
    return result


@kernel
def nominal_stress(displacement_gradient, stress, p):
    """Return the first Piola-Kirchhoff stress P = J sigma F^-T of point p: xx, xy, yx, yy [MPa]."""
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
    """Return the internal force f_I,i = sum_p P_ij dS_I/dX_j V_p (pull-back of paper eq 6).

    Parameters
    ----------
    elements : (m, k) int
        Nodes of each element.
    n_nodes : int
    point_element : (p,) int
        Element of each point.
    gradients : (p, k, 2) float
        Reference gradients dS_I/dX_j [1/mm].
    volume : (p,) float
        Reference volume [mm^3 per mm of thickness].
    displacement_gradient : (p, 2, 2) float
        H = F - I.
    stress : (p, 3) float
        Cauchy stress xx, yy, xy [MPa].

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
def add_stiffness(block, spatial, tau, c, volume):
    """Add one point to the upper triangle of the stiffness of its element.

    Parameters
    ----------
    block : (2k, 2k) float
        Element stiffness, changed in place [N/mm^2].
    spatial : (k, 2) float
        Spatial gradients F^-T dS/dX [1/mm].
    tau, c : tuples of three and six floats
        Kirchhoff stress and spatial tangent, from `laws.dispatch.respond` [MPa].
    volume : float
        Reference volume [mm^3 per mm of thickness].
    """
    txx, tyy, txy = volume * tau[0], volume * tau[1], volume * tau[2]
    c11, c22, c12 = volume * c[0], volume * c[1], volume * c[2]
    c13, c23, c33 = volume * c[3], volume * c[4], volume * c[5]
    k = len(spatial)
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


@kernel
def scatter(data, slots, e, block):
    """Add an element stiffness, given by its upper triangle, to the entries of the matrix.

    Parameters
    ----------
    data : (entries,) float
        Values of the CSR matrix, changed in place [N/mm^2].
    slots : (m, 2k, 2k) int
        From `assembly.entry_slots`.
    e : int
        The element.
    block : (2k, 2k) float
        Its stiffness [N/mm^2].
    """
    for i in range(len(block)):
        for j in range(i, len(block)):
            if slots[e, i, j] >= 0:
                data[slots[e, i, j]] += block[i, j]
                if j > i:
                    data[slots[e, j, i]] += block[i, j]


@kernel
def stiffness(
    slots,
    n_entries,
    point_element,
    gradients,
    volume,
    material,
    law,
    constants,
    internal,
    displacement_gradient,
    patch,
):
    """Assemble the tangent stiffness for the free degrees of freedom.

    K_aibk = sum_p V_p (g_a,j c_ijkl g_b,l + delta_ik g_a,j tau_jl g_b,l) with the spatial
    gradient g = F^-T dS/dX (paper eqs 9 to 12, misprints corrected; de Souza Neto, Peric and Owen
    2008, section 4.3). With patches, the result of `patches.coupling` must be added.

    Parameters
    ----------
    slots : (m, 2k, 2k) int
        From `assembly.entry_slots`.
    n_entries : int
        Number of entries of the matrix.
    point_element, gradients, volume, material, law, constants, internal, patch
        As in `update_points`; the internal variables are those at the start of the step.
    displacement_gradient : (p, 2, 2) float
        H = F - I at the current displacement; det F > 0.

    Returns
    -------
    (n_entries,) float
        Values of the CSR matrix [N/mm per mm of thickness], exactly symmetric.
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
        H, mean = (hxx, hxy, hyx, hyy), means[patch[p]] if patched else y
        m = material[p]
        tau, _, c, _ = respond(law[m], constants, m, H, mean, patched, internal, p)
        J = 1.0 + y
        for a in range(k):
            gx, gy = gradients[p, a, 0], gradients[p, a, 1]
            spatial[a, 0] = ((1.0 + hyy) * gx - hyx * gy) / J
            spatial[a, 1] = ((1.0 + hxx) * gy - hxy * gx) / J
        add_stiffness(block, spatial, tau, c, volume[p])
        e = point_element[p]
        # Points of one element are consecutive: the element stiffness is scattered once.
        if p + 1 == n or point_element[p + 1] != e:
            scatter(data, slots, e, block)
            block[:] = 0.0
    return data


@kernel
def configurational_force(
    elements, n_nodes, point_element, gradients, volume, displacement_gradient, stress, energy
):
    """Return the configurational force of every node.

    CF_I,i = - sum_p (W delta_ij - H_ki P_kj) dS_I/dX_j V_p: paper eq 26 with the Eshelby stress of
    the reference configuration, W I - F^T P (Eshelby 1975). With H instead of F, the sum lacks the
    internal force of the node, which is zero in equilibrium; at small strain the round-off of P
    then does not exceed W.

    Parameters
    ----------
    elements, n_nodes, point_element, gradients, volume, displacement_gradient, stress
        As in `internal_force`.
    energy : (p,) float
        Stored energy W per reference volume [N mm/mm^3].

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
