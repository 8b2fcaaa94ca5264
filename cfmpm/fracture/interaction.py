"""Stress intensity factors and T-stress by interaction integrals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.grid import CrackTip, Floats, Grid, Ints, lengths_of
from cfmpm.body.materials import Materials, plane_modulus
from cfmpm.body.points import DeformedPoints
from cfmpm.kernels import constitutive, eshelby

# Within the first number of element sizes from a closed tip the contact pressure is taken from a
# straight line through that up to the second. The pressure is smooth there, but its nodal forces
# carry the error of the singular stress in the tip elements, which falls with the square of the
# distance: K_I of a closed crack comes out as 1 % of K_II, and up to 4 % with the forces as found.
NEAR, FAR = 3.0, 9.0
# Sine of the angle from the tangent below which a face lies along it, but for round-off.
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
    """Evaluate K_I, K_II and T in a ring around a tip.

    Parameters
    ----------
    grid : Grid
    points : DeformedPoints
    gradients : (p, k, 2) float
        Basis gradients at the points [1/mm].
    material : Materials
        That in the ring.
    tip : CrackTip
    q : (n,) float
        From `cf.ring_weight`. The ring lies in one material. The crack in it may be bent: the
        angle of the auxiliary fields then jumps at the real faces.
    body_force : (2,) float
        [N/mm^3].
    contact_force : (n, 2) float, optional
        That crack faces exert on each other [N/mm].
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
    # Only points with a node inside the ring can add anything.
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
    """The faces in a ring that do not lie along the tangent of the tip, at Gauss points.

    All in the frame of the tip.

    Attributes
    ----------
    at : (g, 2) float
        Distance from the tip [mm] and angle [rad].
    other_side : (g,) bool
        Whether the faces are those that lie one turn away from that angle.
    normal : (g, 2) float
        Out of the body, times the weight q and the length of the point [mm].
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
        """What the interaction integrals lack: int q (sigma_ij a_i,j n_1 - s_ij n_j u_i,1) ds.

        The traction of contact on the auxiliary fields a is `_work_of_contact`.

        Parameters
        ----------
        lame : (2,) float
        spin : float
            That is taken out of the displacement.

        Returns
        -------
        (3,) float
            Of modes I and II and of the point force [N/mm].
        """
        lam, mu = lame
        moved = self.displacement_gradient[:, :, 0] - [0.0, spin]
        found = np.zeros(3)
        for mode in range(3):
            a = np.array(
                [eshelby.auxiliary_gradient(mode, r, theta, lam, mu) for r, theta in self.at]
            ).reshape(-1, 2, 2)
            if mode < 2:
                # One turn away the fields of K_I and K_II have the other sign.
                a[self.other_side] *= -1.0
            trace = np.einsum("gii->g", a)[:, None, None]
            s = lam * trace * np.eye(2) + mu * (a + a.transpose(0, 2, 1))
            mutual = np.einsum("gij,gij->g", self.stress, a) * self.normal[:, 0]
            found[mode] = np.sum(mutual - np.einsum("gij,gj,gi->g", s, self.normal, moved))
        return found


def bent_faces(
    grid: Grid, displacement: Floats, tip: CrackTip, radius: float, material: Materials
) -> BentFaces | None:
    """Find what the faces of a bent crack add to the integrals over a ring.

    An energy-momentum P_1j that is free of sources has the same flow through every ring around a
    tip, but for what leaves through the faces, P_1j n_j: nothing where these lie along the tangent
    and are free. J has no use for them: quadratic in the solution, what leaves through faces that
    are bent a little is less than the error of the stress in the elements at the tip.

    Parameters
    ----------
    grid : Grid
        The whole one, of a linear elastic body.
    displacement : (n, 2) float
        Of its nodes [mm].
    tip : CrackTip
    radius : float
        Of `cf.ring_weight` [mm].
    material : Materials
        That in the ring.

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
    # Out of the body on the left of the crack.
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
    """Integrate t_i [a_i,1] q, contact traction times jump of the auxiliary fields, over the faces.

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
        Of modes I and II, per auxiliary unit [N/mm]. The point force of the T-stress has no jump,
        nor has the solution itself where its faces are closed, so that J needs no such term.
    """
    links, start, end, traction = _contact_traction(grid, contact_force, tip)
    # Gauss points in the root of the distance from the tip, in which the fields are smooth.
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
    # On the other face, one turn away, the fields have the other sign.
    jump = 2.0 * slope if tip.end == -1 else -2.0 * slope
    t = np.einsum("gj,ij->gi", (shape @ traction).reshape(-1, 2), frame)
    return np.einsum("mgi,gi,g->m", jump, t, q_ds.ravel())


def _contact_traction(
    grid: Grid, contact_force: Floats, tip: CrackTip
) -> tuple[Ints, Floats, Floats, Floats]:
    """Turn the contact forces on the left face of a crack into a traction, linear between nodes.

    Returns
    -------
    links : (k, 2) int
        Neighbouring nodes, from the tip on.
    start, end : (k,) float
        Their distances from the tip along the crack [mm].
    traction : (k, 2, 2) float
        At both nodes of each link [MPa].
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
    """Return distance from the tip and angle from its tangent, continuous up to the crack's faces.

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
    # Which side of the crack a point is on is that of the segment nearest to it.
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
