"""Stress intensity factors and T-stress by interaction integrals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import CrackTip, Floats, Grid, Ints, lengths_of
from cfmpm.body.materials import Materials, plane_modulus
from cfmpm.body.points import DeformedPoints
from cfmpm.kernels import constitutive, eshelby

# Within NEAR element sizes of a closed tip the contact pressure is extrapolated linearly from the
# values between there and FAR element sizes. The pressure is smooth there, but its nodal forces
# contain the error of the singular stress in the tip elements, which falls with the square of the
# distance. With extrapolation K_I of a closed crack is 1 % of K_II, without it up to 4 %.
NEAR, FAR = 3.0, 9.0
# Sine of the angle to the tangent below which a face is parallel to it up to round-off.
STRAIGHT = 1e-6


@dataclass(frozen=True)
class IntensityFactors:
    """Stress intensity factors [MPa sqrt(mm)], T-stress [MPa] and G [N/mm] of a tip."""

    K_I: float
    K_II: float
    T_stress: float
    G: float


def intensity_factors(
    grid: Grid,
    points: DeformedPoints,
    gradients: Floats,
    material: Materials,
    tip: CrackTip,
    q: Floats,
    body_force: Floats,
    contact_force: Floats | None = None,
    faces: BentFaces | None = None,
) -> IntensityFactors:
    """Evaluate K_I, K_II and T by interaction integrals over a ring around a tip.

    Parameters
    ----------
    grid : Grid
    points : DeformedPoints
    gradients : (p, k, 2) float
        Basis gradients at the points [1/mm].
    material : Materials
        The material in the ring.
    tip : CrackTip
    q : (n,) float
        From `cf.ring_weight`. The ring lies in one material. The crack may be kinked or curved in
        it: the angle of the auxiliary fields then jumps at the actual crack faces.
    body_force : (2,) float
        [N/mm^3].
    contact_force : (n, 2) float, optional
        Contact forces of the crack faces [N/mm].
    faces : BentFaces, optional
        From `bent_faces`.

    Returns
    -------
    IntensityFactors
        K = E' I / 2 (Stern, Becker and Dunham 1976), T = E' I of the unit point force (Kfouri
        1986), G = (K_I^2 + K_II^2) / E' (Irwin 1957).
    """
    lame = material.lame[0]
    modulus = plane_modulus(*lame)
    # Only points in elements with a node inside the ring contribute.
    inside = np.flatnonzero(np.any(q[grid.elements[:, :3]] > 0.0, axis=1)[points.element])
    r, theta = polar_coordinates(tip, points.position[inside])
    spin = eshelby.mean_spin(points.displacement_gradient[inside], points.volume[inside])
    integrals = eshelby.interaction_integrals(
        grid.nodes,
        grid.elements,
        points.element[inside],
        points.position[inside],
        gradients[inside],
        points.volume[inside],
        points.displacement_gradient[inside],
        points.stress[inside],
        q,
        r,
        theta,
        tip.tangent,
        lame[0],
        lame[1],
        body_force,
        spin,
    )
    if contact_force is not None and contact_force.any():
        integrals[:2] -= _work_of_contact(grid, contact_force, tip, q, lame)
    if faces is not None:
        integrals += faces.interaction(lame, spin)
    k_1, k_2 = 0.5 * modulus * integrals[:2]
    return IntensityFactors(
        K_I=float(k_1),
        K_II=float(k_2),
        T_stress=float(modulus * integrals[2]),
        G=float((k_1**2 + k_2**2) / modulus),
    )


@dataclass(frozen=True)
class BentFaces:
    """Crack faces in a ring that are not parallel to the tangent of the tip, at Gauss points.

    All quantities are in the frame of the tip.

    Attributes
    ----------
    at : (g, 2) float
        Distance from the tip [mm] and angle [rad].
    other_side : (g,) bool
        Whether the angle of the face differs from the given one by a full turn.
    normal : (g, 2) float
        Outward normal times the weight q and the length of the point [mm].
    displacement_gradient : (g, 2, 2) float
    stress : (g, 2, 2) float
        [MPa].
    """

    at: Floats
    other_side: NDArray[np.bool_]
    normal: Floats
    displacement_gradient: Floats
    stress: Floats

    def interaction(self, lame: Floats, spin: float) -> Floats:
        """Face terms of the interaction integrals: int q (sigma_ij a_i,j n_1 - s_ij n_j u_i,1) ds.

        The work of contact tractions on the auxiliary fields a is in `_work_of_contact`.

        Parameters
        ----------
        lame : (2,) float
        spin : float
            Mean rotation that is subtracted from the displacement gradient.

        Returns
        -------
        (3,) float
            For modes I and II and for the point force [N/mm].
        """
        lam, mu = lame
        moved = self.displacement_gradient[:, :, 0] - [0.0, spin]
        found = np.zeros(3)
        for mode in range(3):
            a = np.array(
                [eshelby.auxiliary_gradient(mode, r, theta, lam, mu) for r, theta in self.at]
            ).reshape(-1, 2, 2)
            if mode < 2:
                # After a full turn the fields of K_I and K_II change sign.
                a[self.other_side] *= -1.0
            trace = np.einsum("gii->g", a)[:, None, None]
            s = lam * trace * np.eye(2) + mu * (a + a.transpose(0, 2, 1))
            mutual = np.einsum("gij,gij->g", self.stress, a) * self.normal[:, 0]
            found[mode] = np.sum(mutual - np.einsum("gij,gj,gi->g", s, self.normal, moved))
        return found


def bent_faces(
    grid: Grid, displacement: Floats, tip: CrackTip, radius: float, material: Materials
) -> BentFaces | None:
    """Find the contribution of the faces of a bent crack to the integrals over a ring.

    The flux of a divergence-free energy-momentum tensor P_1j is the same through every ring around
    a tip, up to the flux P_1j n_j through the crack faces. It vanishes on traction-free faces
    parallel to the tangent. J does not need this term: it is quadratic in the solution, and the
    flux through slightly bent faces is below the error of the stress in the elements at the tip.

    Parameters
    ----------
    grid : Grid
        The whole grid of a linear elastic body.
    displacement : (n, 2) float
        Displacement of its nodes [mm].
    tip : CrackTip
    radius : float
        Outer radius of the ring as in `cf.ring_weight` [mm].
    material : Materials
        The material in the ring.

    Returns
    -------
    BentFaces or None
        None where the crack is straight in the ring.
    """
    t = tip.tangent
    frame = np.array([t, [-t[1], t[0]]])
    left, right = grid.crack_faces[tip.crack].T
    ends = grid.nodes[grid.edge_nodes(left)[:, :2]] - tip.path[0]
    weight = np.clip(2.0 - 2.0 * np.hypot(ends[..., 0], ends[..., 1]) / radius, 0.0, 1.0)
    along = ends[:, 1] - ends[:, 0]
    aside = np.abs(t[0] * along[:, 1] - t[1] * along[:, 0])
    bent = (weight > 0.0).any(axis=1) & (aside > STRAIGHT * np.hypot(*along.T))
    if not bent.any():
        return None
    abscissae, weights = np.polynomial.legendre.leggauss(4)
    part = 0.5 + 0.5 * abscissae
    shape = np.stack([1.0 - part, part], axis=1)
    q = 0.5 * weights * np.einsum("ge,ke->kg", shape, weight[bent])
    away = np.einsum("ge,kei->kgi", shape, ends[bent]).reshape(-1, 2)
    # Outward normal of the left face.
    out = np.column_stack([along[bent, 1], -along[bent, 0]])
    out = (q[:, :, None] * out[:, None, :]).reshape(-1, 2)
    element = np.concatenate([np.repeat(face[bent] // 3, len(part)) for face in (left, right)])
    position = np.tile(away + tip.path[0], (2, 1))
    gradients = grid.basis_gradients(element, position)
    h, stress, _ = constitutive.linear_elastic(
        grid.elements,
        element,
        gradients,
        np.zeros(len(element), np.int64),
        material.elastic,
        displacement,
    )
    tensor = stress[:, [[0, 2], [2, 1]]]
    along_tip, across = np.einsum("ij,gj->ig", frame, away)
    at = np.column_stack(
        [np.hypot(along_tip, across), np.mod(np.arctan2(across, along_tip), 2.0 * np.pi)]
    )
    on_left = np.arange(len(element)) < len(away)
    return BentFaces(
        at=np.tile(at, (2, 1)),
        other_side=on_left != (tip.end == -1),
        normal=np.einsum("ij,gj->gi", frame, np.concatenate([out, -out])),
        displacement_gradient=np.einsum("ij,gjk,lk->gil", frame, h, frame),
        stress=np.einsum("ij,gjk,lk->gil", frame, tensor, frame),
    )


def _work_of_contact(
    grid: Grid, contact_force: Floats, tip: CrackTip, q: Floats, lame: Floats
) -> Floats:
    """Integrate t_i [a_i,1] q over the faces: contact traction times jump of the auxiliary fields.

    Parameters
    ----------
    grid : Grid
    contact_force : (n, 2) float
        [N/mm].
    tip : CrackTip
    q : (n,) float
    lame : (2,) float

    Returns
    -------
    (2,) float
        For modes I and II, per auxiliary unit [N/mm]. The point force of the T-stress has no jump.
        Nor has the solution itself on closed faces, so that J needs no such term.
    """
    links, start, end, traction = _contact_traction(grid, contact_force, tip)
    # Gauss points in the square root of the distance from the tip, in which the fields are smooth.
    abscissae, weights = np.polynomial.legendre.leggauss(4)
    low, high = np.sqrt(start)[:, None], np.sqrt(end)[:, None]
    root = 0.5 * (low + high) + 0.5 * (high - low) * abscissae
    part = (root**2 - start[:, None]) / (end - start)[:, None]
    shape = np.stack([1.0 - part, part], axis=2)
    q_ds = np.einsum("lgn,ln->lg", shape, q[links]) * root * (high - low) * weights
    frame = np.array([tip.tangent, [-tip.tangent[1], tip.tangent[0]]])
    away = (shape @ grid.nodes[links] - tip.path[0]).reshape(-1, 2)
    along, across = np.einsum("ij,gj->ig", frame, away)
    r, theta = np.hypot(along, across), np.mod(np.arctan2(across, along), 2.0 * np.pi)
    slope = np.array(
        [
            [eshelby.auxiliary_gradient(mode, *at, *lame)[::2] for at in zip(r, theta, strict=True)]
            for mode in (0, 1)
        ]
    )
    # On the other face, after a full turn, the fields have the opposite sign.
    jump = 2.0 * slope if tip.end == -1 else -2.0 * slope
    t = np.einsum("gj,ij->gi", (shape @ traction).reshape(-1, 2), frame)
    return np.einsum("mgi,gi,g->m", jump, t, q_ds.ravel())


def _contact_traction(
    grid: Grid, contact_force: Floats, tip: CrackTip
) -> tuple[Ints, Floats, Floats, Floats]:
    """Convert the contact forces on the left crack face to a traction, linear between nodes.

    Returns
    -------
    links : (k, 2) int
        Neighbouring nodes, in order from the tip.
    start, end : (k,) float
        Distances of these nodes from the tip along the crack [mm].
    traction : (k, 2, 2) float
        Traction at both nodes of each link [MPa].
    """
    left = grid.edge_nodes(grid.crack_faces[tip.crack][:, 0])
    rule, along = grid.element.side_weights, left[:, grid.element.along]
    links = np.stack([along[:, :-1], along[:, 1:]], axis=2).reshape(-1, 2)
    if tip.end == -1:
        links = links[::-1, ::-1]
    lengths = lengths_of(grid.nodes, left)
    share = np.bincount(left.ravel(), np.outer(lengths, rule).ravel(), len(grid.nodes))
    traction = contact_force[links] / share[links][:, :, None]
    length = lengths_of(grid.nodes, links)
    end = np.cumsum(length)
    start = end - length
    near = end <= min(NEAR * tip.h, 0.5 * end[-1])
    if traction[near].any():
        beyond = ~near & (start < FAR * tip.h)
        place = np.stack([start, end], axis=1)
        by_length = np.repeat(np.sqrt(length[beyond]), 2)
        slope, value = np.polyfit(
            place[beyond].ravel(), traction[beyond].reshape(-1, 2), 1, w=by_length
        )
        traction[near] = place[near][:, :, None] * slope + value
    return links, start, end, traction


def polar_coordinates(tip: CrackTip, x: Floats) -> tuple[Floats, Floats]:
    """Return distance from the tip and angle from its tangent, continuous up to the crack faces.

    Parameters
    ----------
    tip : CrackTip
    x : (k, 2) float
        [mm].

    Returns
    -------
    r : (k,) float
        [mm].
    theta : (k,) float
        [rad]; beyond +-pi between the faces of a kinked crack and the extension of its end.
    """
    away = x - tip.path[0]
    t = tip.tangent
    theta = np.arctan2(t[0] * away[:, 1] - t[1] * away[:, 0], np.einsum("ki,i->k", away, t))
    starts, ahead = tip.path[1:], tip.path[:-1] - tip.path[1:]
    # The side of the crack on which a point lies is taken from the nearest segment.
    nearest = np.full(len(x), np.inf)
    side = np.zeros(len(x))
    for start, along in zip(starts, ahead, strict=True):
        to = x - start
        part = np.clip(np.einsum("ki,i->k", to, along) / (along @ along), 0.0, 1.0)
        gap = np.hypot(*(to - part[:, None] * along).T)
        closer = gap < nearest
        nearest[closer] = gap[closer]
        side[closer] = np.sign(along[0] * to[closer, 1] - along[1] * to[closer, 0])
    behind = np.abs(theta) > 0.5 * np.pi
    theta = theta + 2.0 * np.pi * behind * ((side > 0) & (theta < 0))
    theta = theta - 2.0 * np.pi * behind * ((side < 0) & (theta > 0))
    return np.hypot(*away.T), theta
