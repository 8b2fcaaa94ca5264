"""Stress intensity factors and T-stress by interaction integrals."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.bends import turn
from cfmpm.body.grid import CrackTip, Floats, Grid
from cfmpm.body.materials import Materials, plane_modulus
from cfmpm.body.points import DeformedPoints
from cfmpm.fracture.pressed_faces import ABSCISSAE, WEIGHTS, PressedFaces
from cfmpm.fracture.uniform_state import Uniform
from cfmpm.kernels import constitutive, eshelby

# Sine of the angle to the tangent below which a face is parallel to it up to round-off.
STRAIGHT = 1e-6
# Part of the stress along a crack times sqrt(pi R) of a ring below which a uniform state is taken
# away before K of an open tip is summed: its error of quadrature is up to 2e-3.
UNIFORM = 1e-2
# Parts of the stress that is left then, times sqrt(pi R). A tip makes K of 0.4 to 0.8 of it. Uneven
# pressure leaves an error of up to 0.01 in K, and in J times E' of up to 0.16 squared (both on
# grids of three to six linear elements a crack length). K below the second needs J to confirm it.
NOISE, FAINT, LEAST_J = 0.02, 0.1, 0.2
# The same of the uniform state, by round-off: 1e-14 in K, and in J 1e-7 squared, are found.
ROUND_OFF = 1e-6
# Relative difference of J and G of a faint K that makes it an error.
CONTRADICTED = 0.5
# Part of the pressure and of K_II below which K_I of faces that press on each other is no opening
# of the tip, but the error of their pressure: up to 0.05 on grids of three elements a crack length.
# A short open kink on a crack that is pressed together has more than the pressure. Where they do
# so farther away only, the second is the limit: contact leaves no K_I below zero.
PULLS, PULLS_FAR = 0.1, 0.01


@dataclass(frozen=True)
class IntensityFactors:
    """Stress intensity factors [MPa sqrt(mm)], T-stress [MPa] and G [N/mm] of a tip.

    Attributes
    ----------
    K_I, K_II, T_stress, G : float
    pressure : float
        Mean of that of the faces on each other in the ring, of a tip that is closed; else 0 [MPa].
    G_floor : float
        Below which J and G of this tip are not told from zero; 0 of a loaded open tip [N/mm].
    faint, noise : bool
        Whether K is so small against the stress around the tip that J is to confirm it, and that it
        may be an error of the grid.
    """

    K_I: float
    K_II: float
    T_stress: float
    G: float
    pressure: float = 0.0
    G_floor: float = 0.0
    faint: bool = False
    noise: bool = False

    def confirmed(self, j: float) -> Self:
        """Return the factors, without K where it is faint and J is not its G.

        Parameters
        ----------
        j : float
            J of the ring [N/mm].

        Notes
        -----
        Of a closed tip, K of the size of noise is none whatever J is.
        """
        known = abs(j - self.G) <= CONTRADICTED * self.G
        if (self.faint and not known) or (self.noise and self.pressure > 0.0):
            return replace(self, K_I=0.0, K_II=0.0, G=0.0)
        return self


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
        1986), G = (K_I^2 + K_II^2) / E' (Irwin 1957). K_I is zero where the faces press on each
        other up to the tip, which has no opening then. What is less than round-off is zero too;
        `IntensityFactors.confirmed` tells what is less than the error of the grid.
    """
    ring = _Ring(grid, points, gradients, material.lame[0], tip, q, body_force, faces)
    pressed = None
    if contact_force is not None and contact_force.any():
        pressed = PressedFaces.behind(grid, contact_force, tip)
    root = math.sqrt(np.pi * ring.radius)
    closed, pressure = False, 0.0 if pressed is None else pressed.mean(q)
    if pressed is not None and pressure > 0.0:
        uniform = ring.uniform(pressure)
        k_1, k_2, t_stress = ring.factors(uniform, pressed)
        limit = PULLS if pressed.closed else PULLS_FAR
        closed = bool(k_1 <= limit * (pressure * root + abs(k_2)))
        k_1 = 0.0
    weak = False
    if not closed:
        pressure, uniform = 0.0, Uniform.none(tip)
        pressed = None if pressed is None else pressed.opened()
        k_1, k_2, t_stress = ring.factors(uniform, pressed)
        weak = bool(np.hypot(k_1, k_2) < UNIFORM * abs(t_stress) * root)
        if weak:
            uniform = ring.uniform(0.0)
            k_1, k_2, t_stress = ring.factors(uniform, pressed)
    modulus = plane_modulus(*material.lame[0])
    left, floor = 0.0, 0.0
    if closed or weak:
        left = uniform.left_of(ring.stress, ring.volume)
        floor = least_energy_release_rate(left, uniform.size, ring.radius, modulus)
        if np.hypot(k_1, k_2) < ROUND_OFF * uniform.size * root:
            k_1 = k_2 = 0.0
    k = float(np.hypot(k_1, k_2))
    faint = k < FAINT * left * root
    return IntensityFactors(
        K_I=float(k_1),
        K_II=float(k_2),
        T_stress=float(t_stress),
        G=float((k_1**2 + k_2**2) / modulus),
        pressure=pressure,
        G_floor=floor if closed or faint or k == 0.0 else 0.0,
        faint=faint,
        noise=k < NOISE * left * root,
    )


class _Ring:
    """What a ring around a tip integrates over; the arguments are those of `intensity_factors`."""

    def __init__(
        self,
        grid: Grid,
        points: DeformedPoints,
        gradients: Floats,
        lame: Floats,
        tip: CrackTip,
        q: Floats,
        body_force: Floats,
        faces: BentFaces | None,
    ) -> None:
        # Only points with a node inside the ring can add anything.
        inside = np.flatnonzero(np.any(q[grid.elements[:, :3]] > 0.0, axis=1)[points.element])
        self.grid, self.tip, self.q, self.lame, self.faces = grid, tip, q, lame, faces
        self.body_force = body_force
        self.element, self.position = points.element[inside], points.position[inside]
        self.gradients, self.volume = gradients[inside], points.volume[inside]
        self.displacement_gradient = points.displacement_gradient[inside]
        self.stress = points.stress[inside]
        self.polar = polar_coordinates(tip, self.position)
        self.spin = eshelby.mean_spin(self.displacement_gradient, self.volume)

    @property
    def radius(self) -> float:
        """That of a circle of the same area [mm]."""
        return math.sqrt(self.volume.sum() / np.pi)

    def uniform(self, pressure: float) -> Uniform:
        """Return the uniform state of faces that bear a pressure [MPa]."""
        return Uniform.around(self.tip, pressure, self.stress, self.volume, self.lame)

    def factors(self, uniform: Uniform, pressed: PressedFaces | None) -> Floats:
        """Return K_I, K_II and T by what is left of the state without a uniform one, (3,)."""
        (r, theta), (lam, mu) = self.polar, self.lame
        integrals = eshelby.interaction_integrals(
            self.grid.nodes,
            self.grid.elements,
            self.element,
            self.position,
            self.gradients,
            self.volume,
            self.displacement_gradient - uniform.gradient,
            self.stress - uniform.voigt,
            self.q,
            r,
            theta,
            self.tip.tangent,
            lam,
            mu,
            self.body_force,
            self.spin,
        )
        if pressed is not None:
            integrals[:2] -= pressed.work(
                self.grid.nodes, self.tip, self.q, self.lame, uniform.stress
            )
        if self.faces is not None:
            integrals += self.faces.without(uniform).interaction(self.lame, self.spin)
        factors: Floats = plane_modulus(*self.lame) * integrals * [0.5, 0.5, 1.0]
        factors[2] += uniform.t_stress
        return factors


def least_energy_release_rate(
    left: float, uniform: float, radius: float, modulus: float, part: float = ROUND_OFF
) -> float:
    """Return what J and G are not told from zero below, of a closed or an unloaded tip [N/mm].

    Parameters
    ----------
    left : float
        Root mean square of the stress in the ring without the uniform one [MPa]. By equilibrium,
        the product of both is no part of J.
    uniform : float
        Size of the uniform stress [MPa].
    radius : float
        Of the ring [mm].
    modulus : float
        E' [MPa].
    part : float
        Error of the uniform stress, as a part of it.
    """
    error = (LEAST_J * left) ** 2 + (part * uniform) ** 2
    return error * math.pi * radius / modulus


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

    def without(self, uniform: Uniform) -> Self:
        """Return what is left of them if a uniform state is taken away."""
        return replace(
            self,
            displacement_gradient=self.displacement_gradient - uniform.strain,
            stress=self.stress - uniform.stress,
        )

    def interaction(self, lame: Floats, spin: float) -> Floats:
        """Face terms of the interaction integrals: int q (sigma_ij a_i,j n_1 - s_ij n_j u_i,1) ds.

        The traction of contact on the auxiliary fields a is in `PressedFaces.work`.

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
    part = 0.5 + 0.5 * ABSCISSAE
    shape = np.stack([1.0 - part, part], axis=1)
    q = 0.5 * WEIGHTS * np.einsum("ge,ke->kg", shape, weight[bent])
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
    theta = turn(tip.tangent, away)
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
