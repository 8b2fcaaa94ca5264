"""Patches of triangles with a common mean volume change, against volumetric locking.

Source: de Souza Neto, Pires and Owen 2005.
"""

from __future__ import annotations

import math

import numpy as np

from cfmpm._jit import kernel
from cfmpm.kernels.finite import patch_means
from cfmpm.kernels.laws import dispatch


@kernel
def neighbours_of(nodes, triangles, twins, regions):
    """Return the adjacent triangles with which each triangle may form a patch.

    Parameters
    ----------
    nodes, triangles, twins, regions
        As in `pair_triangles`.

    Returns
    -------
    neighbours : (m, 3) int
        Triangle of the same region across each side; -1 if there is none.
    length : (m, 3) float
        Length of each side with a neighbour, otherwise 0 [mm].
    """
    m = triangles.shape[0]
    neighbours = np.full((m, 3), -1)
    length = np.zeros((m, 3))
    for t in range(m):
        for k in range(3):
            other = twins[t, k] // 3
            if twins[t, k] >= 0 and regions[other] == regions[t]:
                a, b = nodes[triangles[t, k]], nodes[triangles[t, (k + 1) % 3]]
                neighbours[t, k] = other
                length[t, k] = math.hypot(b[0] - a[0], b[1] - a[1])
    return neighbours, length


@kernel
def join_left_over(neighbours, length, patch, n_patches):
    """Add each triangle without a patch to the smallest adjacent patch.

    Among equally small patches, the one across the longest side is taken. A triangle without a
    neighbour becomes a patch.

    Parameters
    ----------
    neighbours, length
        From `neighbours_of`.
    patch : (m,) int
        Patch of each triangle, -1 for none; changed in place.
    n_patches : int
        Number of patches so far.
    """
    size = np.zeros(len(patch), np.int64)
    for t in range(len(patch)):
        if patch[t] >= 0:
            size[patch[t]] += 1
    for t in range(len(patch)):
        if patch[t] >= 0:
            continue
        best = -1
        for k in range(3):
            other = neighbours[t, k]
            if other < 0:
                continue
            if best < 0 or (size[patch[other]], -length[t, k]) < (
                size[patch[neighbours[t, best]]],
                -length[t, best],
            ):
                best = k
        if best >= 0:
            patch[t] = patch[neighbours[t, best]]
            size[patch[t]] += 1
        else:
            patch[t] = n_patches
            size[n_patches] = 1
            n_patches += 1


@kernel
def pair_triangles(nodes, triangles, twins, regions, patch):
    """Form patches of two adjacent triangles; remaining triangles join an adjacent patch.

    Parameters
    ----------
    nodes : (n, 2) float
        [mm].
    triangles : (m, 3) int
        Corners of each triangle.
    twins : (m, 3) int
        Half-edge across each side, -1 on the boundary and on crack faces.
    regions : (m,) int
        Region of each triangle; a patch contains triangles of one region only.
    patch : (m,) int
        Patch of each triangle that has one, numbered without gaps, else -1; completed in place.

    Notes
    -----
    Triangles with only one neighbour without a patch are paired first, which leaves few triangles
    over (Karp and Sipser 1981). A triangle is paired with the neighbour that has the fewest such
    neighbours itself, and among these with the one across the longest side.
    """
    m = triangles.shape[0]
    neighbours, length = neighbours_of(nodes, triangles, twins, regions)
    choices = np.zeros(m, np.int64)
    waiting = np.empty(m, np.int64)
    n_waiting = 0
    for t in range(m):
        if patch[t] >= 0:
            continue
        for k in range(3):
            choices[t] += int(neighbours[t, k] >= 0 and patch[neighbours[t, k]] < 0)
        if choices[t] == 1:
            waiting[n_waiting] = t
            n_waiting += 1
    n_patches = patch.max() + 1
    following = 0
    while n_waiting > 0 or following < m:
        if n_waiting > 0:
            n_waiting -= 1
            t = waiting[n_waiting]
        else:
            t = following
            following += 1
        if patch[t] >= 0 or choices[t] == 0:
            continue
        best = -1
        for k in range(3):
            other = neighbours[t, k]
            if other < 0 or patch[other] >= 0:
                continue
            if best < 0 or (choices[other], -length[t, k]) < (
                choices[neighbours[t, best]],
                -length[t, best],
            ):
                best = k
        pair = (t, neighbours[t, best])
        for one in pair:
            patch[one] = n_patches
        n_patches += 1
        for one in pair:
            for k in range(3):
                other = neighbours[one, k]
                if other >= 0 and patch[other] < 0:
                    choices[other] -= 1
                    if choices[other] == 1:
                        waiting[n_waiting] = other
                        n_waiting += 1
    join_left_over(neighbours, length, patch, n_patches)


@kernel
def bulk_moduli(n_patches, volume, material, law, constants, displacement_gradient, patch):
    """Return lambda U'' at the mean J of each patch.

    Parameters
    ----------
    n_patches : int
    volume, material, law, constants
        As in `finite.update_points`. The material of the largest point of a patch is taken: points
        of another material are intersections of round-off size at an interface.
    displacement_gradient : (p, 2, 2) float
        H = F - I.
    patch : (p,) int
        Patch of each point.

    Returns
    -------
    (n_patches,) float
        [MPa].
    """
    means = patch_means(volume, displacement_gradient, patch)
    bulk = np.zeros(n_patches)
    largest = np.zeros(n_patches)
    for p in range(len(patch)):
        m, at = material[p], patch[p]
        if volume[p] < largest[at]:
            continue
        largest[at] = volume[p]
        bulk[at] = dispatch.volumetric(law[m], constants, m, means[at])[2]
    return bulk


@kernel
def coupling(
    slots,
    n_entries,
    patch_nodes,
    elements,
    point_element,
    gradients,
    volume,
    bulk,
    displacement_gradient,
    patch,
):
    """Assemble the stiffness of the mean volume change of patches.

    K = sum over patches of lambda U''(mean J) / V b b^T, where V is the volume of the patch and
    b_I = sum_p V_p J F^-T dS_I/dX the derivative of its deformed volume with respect to u_I. The
    result is added to `finite.stiffness` with patches. At zero displacement it is added to
    `assembly.stiffness` of the elastic matrix without the averaged volumetric part.

    Parameters
    ----------
    slots : (n_patches, 2w, 2w) int
        From `assembly.entry_slots` of `patch_nodes`.
    n_entries : int
        Number of entries of the matrix.
    patch_nodes : (n_patches, w) int
        Nodes of each patch; the last one is repeated if there are fewer than w.
    elements, point_element, gradients, volume
        As in `finite.update_points`.
    bulk : (n_patches,) float
        From `bulk_moduli` [MPa].
    displacement_gradient : (p, 2, 2) float
        H = F - I.
    patch : (p,) int
        Patch of each point.

    Returns
    -------
    (n_entries,) float
        Values of the CSR matrix [N/mm per mm of thickness], exactly symmetric.
    """
    n_patches, width = patch_nodes.shape
    whole = np.zeros(n_patches)
    change = np.zeros((n_patches, 2 * width))
    for p in range(len(patch)):
        at = patch[p]
        whole[at] += volume[p]
        hxx, hxy = displacement_gradient[p, 0, 0], displacement_gradient[p, 0, 1]
        hyx, hyy = displacement_gradient[p, 1, 0], displacement_gradient[p, 1, 1]
        for a in range(elements.shape[1]):
            node = elements[point_element[p], a]
            local = 0
            while patch_nodes[at, local] != node:
                local += 1
            gx, gy = gradients[p, a, 0] * volume[p], gradients[p, a, 1] * volume[p]
            change[at, 2 * local] += (1.0 + hyy) * gx - hyx * gy
            change[at, 2 * local + 1] += (1.0 + hxx) * gy - hxy * gx
    data = np.zeros(n_entries)
    for at in range(n_patches):
        if whole[at] == 0.0:
            continue
        factor = bulk[at] / whole[at]
        for i in range(2 * width):
            for j in range(2 * width):
                if slots[at, i, j] >= 0:
                    data[slots[at, i, j]] += factor * (change[at, i] * change[at, j])
    return data


@kernel
def mean_pressure(volume, material, volumetric, displacement_gradient, patch):
    """Return stress and energy of the mean volumetric strain of patches, at small strain.

    Parameters
    ----------
    volume : (p,) float
        [mm^3 per mm of thickness].
    material : (p,) int
        Row of `volumetric`.
    volumetric : (q,) float
        Modulus of the averaged volumetric strain: lambda [MPa].
    displacement_gradient : (p, 2, 2) float
        u_i,j.
    patch : (p,) or (0,) int
        Patch of each point.

    Returns
    -------
    stress : (p,) float
        `volumetric` times the mean of u_k,k, to be added to sigma_xx and sigma_yy of
        `constitutive.linear_elastic` without this modulus [MPa].
    energy : (p,) float
        `volumetric` times mean (u_k,k - mean / 2): linearised about the mean, as in
        `laws.dispatch.respond` [N mm/mm^3].
    """
    n_patches = patch.max() + 1 if len(patch) else 0
    whole = np.zeros(n_patches)
    mean = np.zeros(n_patches)
    for p in range(len(patch)):
        whole[patch[p]] += volume[p]
        mean[patch[p]] += volume[p] * (
            displacement_gradient[p, 0, 0] + displacement_gradient[p, 1, 1]
        )
    stress = np.empty(len(patch))
    energy = np.empty(len(patch))
    for p in range(len(patch)):
        trace = displacement_gradient[p, 0, 0] + displacement_gradient[p, 1, 1]
        average = mean[patch[p]] / whole[patch[p]]
        stress[p] = volumetric[material[p]] * average
        energy[p] = stress[p] * (trace - 0.5 * average)
    return stress, energy
