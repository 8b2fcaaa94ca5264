"""Configurational force of nodes and interaction integrals of a tip, at small strain."""

from __future__ import annotations

import math

import numpy as np

from cfmpm._jit import kernel


@kernel
def configurational_force(
    elements, n_nodes, point_element, gradients, volume, displacement_gradient, stress, energy
):
    """Return the configurational force of every node.

    CF_I,i = - sum_p Sigma_ij dS_I/dX_j V_p with the Eshelby stress
    Sigma_ij = psi delta_ij - u_k,i sigma_kj (paper eqs 19 and 26, indices and sign corrected: the
    force points in the direction of crack growth).

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
    displacement_gradient : (p, 2, 2) float
        u_i,j.
    stress : (p, 3) float
        sigma_xx, sigma_yy, sigma_xy [MPa].
    energy : (p,) float
        psi [N mm/mm^3].

    Returns
    -------
    (n, 2) float
        [N/mm].
    """
    force = np.zeros((n_nodes, 2))
    for p in range(len(point_element)):
        h = displacement_gradient[p]
        sxx, syy, sxy = stress[p, 0], stress[p, 1], stress[p, 2]
        exx = (energy[p] - h[0, 0] * sxx - h[1, 0] * sxy) * volume[p]
        exy = -(h[0, 0] * sxy + h[1, 0] * syy) * volume[p]
        eyx = -(h[0, 1] * sxx + h[1, 1] * sxy) * volume[p]
        eyy = (energy[p] - h[0, 1] * sxy - h[1, 1] * syy) * volume[p]
        e = point_element[p]
        for a in range(elements.shape[1]):
            node = elements[e, a]
            gx, gy = gradients[p, a, 0], gradients[p, a, 1]
            force[node, 0] -= exx * gx + exy * gy
            force[node, 1] -= eyx * gx + eyy * gy
    return force


@kernel
def body_configurational_force(
    elements, n_nodes, point_element, values, volume, displacement_gradient, density
):
    """Return the contribution of a uniform body force to the configurational force.

    CF_I,i = - sum_p u_k,i b_k S_I V_p. The divergence of the Eshelby stress is u_k,i b_k; without
    this term the sum of the configurational force over a domain depends on the domain (Maugin
    1993, ch. 4).

    Parameters
    ----------
    elements, n_nodes, point_element, values, volume, density
        As in `assembly.body_force`.
    displacement_gradient : (p, 2, 2) float
        u_i,j.

    Returns
    -------
    (n, 2) float
        [N/mm].
    """
    force = np.zeros((n_nodes, 2))
    for p in range(len(point_element)):
        h = displacement_gradient[p]
        fx = (h[0, 0] * density[0] + h[1, 0] * density[1]) * volume[p]
        fy = (h[0, 1] * density[0] + h[1, 1] * density[1]) * volume[p]
        for a in range(elements.shape[1]):
            node = elements[point_element[p], a]
            force[node, 0] -= fx * values[p, a]
            force[node, 1] -= fy * values[p, a]
    return force


@kernel
def auxiliary_gradient(mode, r, theta, lam, mu):
    """Return the displacement gradient of an auxiliary field in the frame of the tip.

    Parameters
    ----------
    mode : int
        0 and 1: Williams' fields of K_I = 1 and K_II = 1 MPa sqrt(mm) (Anderson 2005, table 2.2);
        2: field of a unit point force at the tip along the crack, for the T-stress (Michell 1900;
        Kfouri 1986).
    r, theta : float
        Distance from the tip [mm] and angle from the tangent of the crack [rad].
    lam, mu : float
        Lame constants of the plane problem [MPa].

    Returns
    -------
    h11, h12, h21, h22 : float
        a_i,j, with axis 1 along the tangent.
    """
    kappa = (lam + 3.0 * mu) / (lam + mu)
    c, s = math.cos(theta), math.sin(theta)
    if mode == 2:
        # u_1 = -a (kappa + 1) / 2 ln r - a sin^2; u_2 = -a (kappa - 1) / 2 theta + a sin cos
        a = 1.0 / (4.0 * math.pi * mu)
        radial = -0.5 * a * (kappa + 1.0) / r
        around_1 = -2.0 * a * s * c / r
        around_2 = a * (-0.5 * (kappa - 1.0) + c * c - s * s) / r
        return c * radial - s * around_1, s * radial + c * around_1, -s * around_2, c * around_2
    ch, sh = math.cos(0.5 * theta), math.sin(0.5 * theta)
    # u_i = scale sqrt(r) g_i(theta)
    scale = 1.0 / (2.0 * mu * math.sqrt(2.0 * math.pi * r))
    if mode == 0:
        g1 = ch * (kappa - c)
        g2 = sh * (kappa - c)
        d1 = -0.5 * sh * (kappa - c) + ch * s
        d2 = 0.5 * ch * (kappa - c) + sh * s
    else:
        g1 = sh * (kappa + 2.0 + c)
        g2 = -ch * (kappa - 2.0 + c)
        d1 = 0.5 * ch * (kappa + 2.0 + c) - sh * s
        d2 = 0.5 * sh * (kappa - 2.0 + c) + ch * s
    return (
        scale * (0.5 * c * g1 - s * d1),
        scale * (0.5 * s * g1 + c * d1),
        scale * (0.5 * c * g2 - s * d2),
        scale * (0.5 * s * g2 + c * d2),
    )


@kernel
def mean_spin(displacement_gradient, volume):
    """Return the mean rotation (u_2,1 - u_1,2) / 2 of points, weighted by volume.

    Parameters
    ----------
    displacement_gradient : (p, 2, 2) float
        u_i,j.
    volume : (p,) float
        [mm^3 per mm of thickness].

    Returns
    -------
    float
        [rad]; zero without points.
    """
    spin = 0.0
    for p in range(len(volume)):
        h = displacement_gradient[p]
        spin += 0.5 * (h[1, 0] - h[0, 1]) * volume[p]
    return spin / max(volume.sum(), 1e-300)


@kernel
def in_tip_frame(h, stress, t1, t2, spin):
    """Rotate a state to the frame of the tip, axis 1 along the tangent of the crack.

    Parameters
    ----------
    h : (2, 2) float
        Displacement gradient u_i,j.
    stress : (3,) float
        sigma_xx, sigma_yy, sigma_xy [MPa].
    t1, t2 : float
        Unit tangent of the crack at the tip.
    spin : float
        Rotation to subtract from the displacement gradient [rad].

    Returns
    -------
    u11, u21 : float
        u_1,1 and u_2,1.
    s11, s22, s12 : float
        Stress [MPa].
    """
    ux1 = h[0, 0] * t1 + (h[0, 1] + spin) * t2
    uy1 = (h[1, 0] - spin) * t1 + h[1, 1] * t2
    sxx, syy, sxy = stress[0], stress[1], stress[2]
    return (
        t1 * ux1 + t2 * uy1,
        -t2 * ux1 + t1 * uy1,
        t1 * t1 * sxx + 2.0 * t1 * t2 * sxy + t2 * t2 * syy,
        t2 * t2 * sxx - 2.0 * t1 * t2 * sxy + t1 * t1 * syy,
        t1 * t2 * (syy - sxx) + (t1 * t1 - t2 * t2) * sxy,
    )


@kernel
def mutual_flow(state, auxiliary, lam, mu, w1, w2):
    """Return (sigma_ij a_i,1 + s_ij u_i,1) q_,j - sigma_ik a_i,k q_,1 in the frame of the tip.

    Parameters
    ----------
    state : tuple of five floats
        As returned by `in_tip_frame`.
    auxiliary : tuple of four floats
        a_i,j, as returned by `auxiliary_gradient`; s is its stress.
    lam, mu : float
        Lame constants of the plane problem [MPa].
    w1, w2 : float
        Gradient q_,1, q_,2 of the weight [1/mm].

    Returns
    -------
    float
        Integrand of the interaction integral [N/mm^3 per auxiliary unit].
    """
    u11, u21, s11, s22, s12 = state
    a11, a12, a21, a22 = auxiliary
    trace = lam * (a11 + a22)
    z11 = trace + 2.0 * mu * a11
    z22 = trace + 2.0 * mu * a22
    z12 = mu * (a12 + a21)
    mutual = s11 * a11 + s22 * a22 + s12 * (a12 + a21)
    value = (s11 * a11 + s12 * a21 + z11 * u11 + z12 * u21 - mutual) * w1
    return value + (s12 * a11 + s22 * a21 + z12 * u11 + z22 * u21) * w2


@kernel
def interaction_integrals(
    nodes,
    elements,
    point_element,
    position,
    gradients,
    volume,
    displacement_gradient,
    stress,
    q,
    r,
    theta,
    tangent,
    lam,
    mu,
    density,
    spin,
):
    """Compute the interaction integrals of the solution with the three auxiliary fields.

    I = sum_p V_p [(sigma_ij a_i,1 + s_ij u_i,1) q_,j - sigma_ik a_i,k q_,1 - b_i a_i,1 q] in the
    frame of the tip, with the auxiliary displacement a and stress s (Stern, Becker and Dunham
    1976; Moran and Shih 1987). Elements with constant q are skipped if there is no body force.

    Parameters
    ----------
    nodes, position : (n, 2), (p, 2) float
        Of the nodes and of the points [mm].
    elements, point_element, gradients, volume, displacement_gradient, stress
        As in `configurational_force`; the three corners of an element first.
    q : (n,) float
        Weight of each node: 1 inside the ring, 0 outside; linear in each triangle.
    r, theta : (p,) float
        Distance from the tip [mm] and angle from the tangent of the crack [rad].
    tangent : (2,) float
        Unit tangent of the crack at the tip.
    lam, mu : float
        Lame constants in the ring [MPa].
    density : (2,) float
        Body force b [N/mm^3].
    spin : float
        Mean rotation of the ring, as returned by `mean_spin`. A rigid rotation does no work on the
        auxiliary stress, which is in equilibrium, but its quadrature is not exactly zero. It is
        subtracted because in slender bodies it is much larger than the strain.

    Returns
    -------
    (3,) float
        I for K_I, K_II and the point force [N/mm per auxiliary unit].
    """
    result = np.zeros(3)
    t1, t2 = tangent[0], tangent[1]
    loaded = density[0] != 0.0 or density[1] != 0.0
    b1 = t1 * density[0] + t2 * density[1]
    b2 = -t2 * density[0] + t1 * density[1]
    for p in range(len(point_element)):
        e = point_element[p]
        q0, q1, q2 = q[elements[e, 0]], q[elements[e, 1]], q[elements[e, 2]]
        if q0 == q1 and q1 == q2 and not (loaded and q0 > 0.0):
            continue
        qx = qy = 0.0
        for a in range(elements.shape[1]):
            qx += q[elements[e, a]] * gradients[p, a, 0]
            qy += q[elements[e, a]] * gradients[p, a, 1]
        w1, w2 = t1 * qx + t2 * qy, -t2 * qx + t1 * qy
        state = in_tip_frame(displacement_gradient[p], stress[p], t1, t2, spin)
        for mode in range(3):
            auxiliary = auxiliary_gradient(mode, r[p], theta[p], lam, mu)
            value = mutual_flow(state, auxiliary, lam, mu, w1, w2)
            if loaded:
                corner = nodes[elements[e, 0]]
                q_here = q0 + qx * (position[p, 0] - corner[0]) + qy * (position[p, 1] - corner[1])
                value -= (b1 * auxiliary[0] + b2 * auxiliary[2]) * q_here
            result[mode] += value * volume[p]
    return result
