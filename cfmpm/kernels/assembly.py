"""Stiffness and nodal forces at small strain, as sums over material points."""

from __future__ import annotations

import numpy as np

from cfmpm._jit import kernel


@kernel
def element_stars(elements, n_nodes):
    """List the elements at each node.

    Parameters
    ----------
    elements : (m, k) int
        Nodes of each element.
    n_nodes : int

    Returns
    -------
    offsets : (n_nodes + 1,) int
    star : (m k,) int
        The elements at node i are ``star[offsets[i]:offsets[i + 1]]``, in ascending order.
    """
    m, k = elements.shape
    offsets = np.zeros(n_nodes + 1, np.int64)
    for e in range(m):
        for a in range(k):
            offsets[elements[e, a] + 1] += 1
    for i in range(n_nodes):
        offsets[i + 1] += offsets[i]
    fill = offsets[:-1].copy()
    star = np.empty(m * k, np.int64)
    for e in range(m):
        for a in range(k):
            node = elements[e, a]
            star[fill[node]] = e
            fill[node] += 1
    return offsets, star


@kernel
def sparsity(elements, free):
    """Return the sparsity pattern of the stiffness matrix of the free degrees of freedom.

    Parameters
    ----------
    elements : (m, k) int
        Nodes of each element.
    free : (n, 2) int
        Row of each degree of freedom in the reduced system, ascending; -1 where prescribed.

    Returns
    -------
    indptr : (n_free + 1,) int64
        Start of each row of the CSR matrix.
    indices : (entries,) int32
        Columns, ascending in each row.
    """
    n_nodes = free.shape[0]
    k = elements.shape[1]
    offsets, star = element_stars(elements, n_nodes)
    seen = np.full(n_nodes, -1, np.int64)
    n_free = 0
    entries = 0
    for i in range(n_nodes):
        own = int(free[i, 0] >= 0) + int(free[i, 1] >= 0)
        n_free += own
        if own == 0:
            continue
        width = 0
        for j in range(offsets[i], offsets[i + 1]):
            for b in range(k):
                node = elements[star[j], b]
                if seen[node] != i:
                    seen[node] = i
                    width += int(free[node, 0] >= 0) + int(free[node, 1] >= 0)
        entries += own * width

    indptr = np.zeros(n_free + 1, np.int64)
    indices = np.empty(entries, np.int32)
    seen[:] = -1
    around = np.empty(n_nodes, np.int64)
    at = 0
    row = 0
    for i in range(n_nodes):
        own = int(free[i, 0] >= 0) + int(free[i, 1] >= 0)
        if own == 0:
            continue
        count = 0
        for j in range(offsets[i], offsets[i + 1]):
            for b in range(k):
                node = elements[star[j], b]
                if seen[node] != i:
                    seen[node] = i
                    # Insertion sort: a node has few neighbours.
                    c = count
                    while c > 0 and around[c - 1] > node:
                        around[c] = around[c - 1]
                        c -= 1
                    around[c] = node
                    count += 1
        for _ in range(own):
            for c in range(count):
                for component in range(2):
                    column = free[around[c], component]
                    if column >= 0:
                        indices[at] = column
                        at += 1
            row += 1
            indptr[row] = at
    return indptr, indices


@kernel
def add_stiffness(block, gradients, p, elastic, m, volume):
    """Add one point to the upper triangle of the stiffness of its element.

    Parameters
    ----------
    block : (2k, 2k) float
        Element stiffness, changed in place [N/mm^2].
    gradients : (p, k, 2) float
        dS_I/dX_j [1/mm].
    p : int
        The point.
    elastic : (q, 3, 3) float
        Elastic matrices [MPa].
    m : int
        Material of the point.
    volume : float
        Volume of the point [mm^3 per mm of thickness].
    """
    c11, c22, c12 = volume * elastic[m, 0, 0], volume * elastic[m, 1, 1], volume * elastic[m, 0, 1]
    c13, c23, c33 = volume * elastic[m, 0, 2], volume * elastic[m, 1, 2], volume * elastic[m, 2, 2]
    k = gradients.shape[1]
    for a in range(k):
        ax, ay = gradients[p, a, 0], gradients[p, a, 1]
        # Rows of node a: c : sym(e_i (x) g_a).
        xxx, xyy, xxy = c11 * ax + c13 * ay, c12 * ax + c23 * ay, c13 * ax + c33 * ay
        yxx, yyy, yxy = c12 * ay + c13 * ax, c22 * ay + c23 * ax, c23 * ay + c33 * ax
        for b in range(a, k):
            bx, by = gradients[p, b, 0], gradients[p, b, 1]
            block[2 * a, 2 * b] += xxx * bx + xxy * by
            block[2 * a, 2 * b + 1] += xxy * bx + xyy * by
            block[2 * a + 1, 2 * b] += yxx * bx + yxy * by
            block[2 * a + 1, 2 * b + 1] += yxy * bx + yyy * by


@kernel
def find_entry(indptr, indices, row, column):
    """Return the position of an entry of a CSR matrix, by bisection.

    Parameters
    ----------
    indptr, indices
        As returned by `sparsity`.
    row, column : int
        An entry of the pattern.

    Returns
    -------
    int
        Position in the data of the CSR matrix.
    """
    low, high = indptr[row], indptr[row + 1]
    while high - low > 1:
        middle = (low + high) // 2
        if indices[middle] <= column:
            low = middle
        else:
            high = middle
    return low


@kernel
def entry_slots(elements, free, indptr, indices):
    """Return the positions of the entries of each element stiffness in the CSR matrix.

    Parameters
    ----------
    elements, free, indptr, indices
        As in `sparsity`; fewer than 2^31 entries.

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
                if column >= 0:
                    slots[e, i, j] = find_entry(indptr, indices, row, column)
    return slots


@kernel
def stiffness(elements, free, indptr, indices, point_element, gradients, volume, material, elastic):
    """Assemble the stiffness of linear elastic points for the free degrees of freedom.

    K_aibk = sum_p V_p g_a,j D_ijkl g_b,l with g = dS/dX: paper eq 10 at F = I.

    Parameters
    ----------
    elements : (m, k) int
        Nodes of each element.
    free, indptr, indices
        As in `sparsity`.
    point_element : (p,) int
        Element of each point.
    gradients : (p, k, 2) float
        dS_I/dX_j [1/mm].
    volume : (p,) float
        [mm^3 per mm of thickness].
    material : (p,) int
        Row of `elastic`.
    elastic : (q, 3, 3) float
        Elastic matrix D of the plane problem, in the order xx, yy, xy [MPa].

    Returns
    -------
    (entries,) float
        Values of the CSR matrix [N/mm per mm of thickness], exactly symmetric.
    """
    data = np.zeros(len(indices))
    k = elements.shape[1]
    n_points = len(point_element)
    block = np.zeros((2 * k, 2 * k))
    number = np.empty(2 * k, np.int64)
    for p in range(n_points):
        e = point_element[p]
        add_stiffness(block, gradients, p, elastic, material[p], volume[p])
        if p + 1 < n_points and point_element[p + 1] == e:
            continue
        # Points of one element are consecutive: the element stiffness is scattered once.
        for a in range(k):
            number[2 * a], number[2 * a + 1] = free[elements[e, a], 0], free[elements[e, a], 1]
        for i in range(2 * k):
            row = number[i]
            if row < 0:
                continue
            for j in range(2 * k):
                column = number[j]
                if column < 0:
                    continue
                low, high = indptr[row], indptr[row + 1]
                while high - low > 1:
                    middle = (low + high) // 2
                    if indices[middle] <= column:
                        low = middle
                    else:
                        high = middle
                data[low] += block[min(i, j), max(i, j)]
        block[:] = 0.0
    return data


@kernel
def internal_force(elements, n_nodes, point_element, gradients, volume, stress):
    """Return the internal force f_I,i = sum_p sigma_ij dS_I/dX_j V_p (paper eq 6, at F = I).

    Parameters
    ----------
    elements : (m, k) int
        Nodes of each element.
    n_nodes : int
    point_element : (p,) int
        Element of each point.
    gradients : (p, k, 2) float
        dS_I/dX_j [1/mm].
    volume : (p,) float
        [mm^3 per mm of thickness].
    stress : (p, 3) float
        sigma_xx, sigma_yy, sigma_xy [MPa].

    Returns
    -------
    (n, 2) float
        [N/mm].
    """
    force = np.zeros((n_nodes, 2))
    for p in range(len(point_element)):
        e = point_element[p]
        sxx = stress[p, 0] * volume[p]
        syy = stress[p, 1] * volume[p]
        sxy = stress[p, 2] * volume[p]
        for a in range(elements.shape[1]):
            node = elements[e, a]
            gx, gy = gradients[p, a, 0], gradients[p, a, 1]
            force[node, 0] += sxx * gx + sxy * gy
            force[node, 1] += sxy * gx + syy * gy
    return force


@kernel
def body_force(elements, n_nodes, point_element, values, volume, density):
    """Return the nodal force f_I = sum_p S_I b V_p of a uniform body force b (paper eq 6).

    Parameters
    ----------
    elements : (m, k) int
        Nodes of each element.
    n_nodes : int
    point_element : (p,) int
        Element of each point.
    values : (p, k) float
        Basis functions S_I at the points.
    volume : (p,) float
        [mm^3 per mm of thickness].
    density : (2,) float
        b [N/mm^3].

    Returns
    -------
    (n, 2) float
        [N/mm].
    """
    force = np.zeros((n_nodes, 2))
    for p in range(len(point_element)):
        for a in range(elements.shape[1]):
            weight = values[p, a] * volume[p]
            node = elements[point_element[p], a]
            force[node, 0] += weight * density[0]
            force[node, 1] += weight * density[1]
    return force
