"""Evaluation of the crack tips in a state of equilibrium."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.crack_faces import Turning, smallest_openings, turning_of
from cfmpm.body.grid import CrackTip, Floats, Grid, regions_ahead
from cfmpm.body.materials import Materials, plane_modulus
from cfmpm.body.points import DeformedPoints
from cfmpm.body.tip_domains import FILL, TipDomain, sharp_bend
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture import cf
from cfmpm.fracture.corotation import corotated_factors
from cfmpm.fracture.criteria.max_hoop import max_hoop_angle
from cfmpm.fracture.criteria.protocols import (
    Direction,
    direction_by,
    is_closed,
    load_factor_at_fracture,
)
from cfmpm.fracture.interaction import (
    ROUND_OFF,
    bent_faces,
    intensity_factors,
    least_energy_release_rate,
)
from cfmpm.fracture.pressed_faces import PressedFaces
from cfmpm.fracture.relieved import relieved_nodes
from cfmpm.fracture.uniform_state import Uniform
from cfmpm.registry.criteria import DEFAULT_DIRECTION

# Round-off of J, as a part of the energy in its ring over the radius.
ROUND_OFF_J = 1e-9
# Values of a tip that hold in a part that carries nothing too.
_OF_PLACE = {"domain_radius", "min_opening"}


def evaluate_tips(
    body: Body,
    gradients: Floats,
    balance: Equilibrium,
    nodal: Floats,
    plastic: Floats | None = None,
    direction: str = DEFAULT_DIRECTION,
    *,
    stationary: bool = False,
) -> dict[str, Any]:
    """Evaluate configurational force, J, K_I, K_II and T at every tip.

    At finite deformation G is J, and stationary tips have K and T where strain around them is small
    (`corotation`). A tip on the interface of two materials has no K and no T; its G is J.
    A tip in a part that has come off and carries nothing has no values.

    Parameters
    ----------
    body : Body
    gradients : (p, k, 2) float
        Basis gradients at its quadrature points [1/mm].
    balance : Equilibrium
        Equilibrium of the body.
    nodal : (n, 2) float
        From `cf.nodal_force`.
    plastic : (n, 2) float, optional
        From `mechanics.plastic_nodal_force`.
    direction : str
        Criterion for the direction of growth, a word of `registry.criteria`.
    stationary : bool
        Whether no crack grows: else K at finite deformation is left out, since nothing needs it.

    Returns
    -------
    dict of str to array
        By the names of a history's variables, (tip,) or (tip, radius). Values without
        ``_radius`` are those of the largest radius.
    """
    grid = body.grid
    openings = smallest_openings(grid, balance.displacement, balance.finite)
    if not grid.tips:
        return {}
    rows: list[dict[str, Any]] = []
    for tip, domain in zip(grid.tips, body.tip_domains, strict=True):
        material = body.materials.row(regions_ahead(grid, tip, tip.tangent)[0])
        near = _Neighbourhood.of(body, gradients, balance, nodal, tip, max(domain.radii))
        rings = [_forces_of_ring(near, radius) for radius in domain.radii]
        has_k = not (balance.finite or domain.on_border)
        if has_k:
            rings = [
                ring | _factors_of_ring(near, body, balance, tip, ring, material) for ring in rings
            ]
        elif stationary and _may_be_small(near, body, balance, tip, domain, material):
            rings = _with_corotated_factors(rings, near, body, balance, material)
        if plastic is not None:
            rings = [
                ring | {"J_plastic_radius": _j_plastic(grid, plastic, tip, radius)}
                for ring, radius in zip(rings, domain.radii, strict=True)
            ]
        row = _of_rings(rings, int(np.argmax(domain.radii)))
        largest = max(domain.radii)
        row["cf_x"], row["cf_y"] = cf.domain_force(near.grid, near.nodal, near.tip, largest)
        row["cf_tip_x"], row["cf_tip_y"] = nodal[tip.node]
        row["min_opening"] = openings[tip.crack]
        if plastic is not None:
            row["cf_plastic_x"], row["cf_plastic_y"] = cf.domain_force(grid, plastic, tip, largest)
        if "K_I" in row:
            row |= kink(row, direction_by(direction))
            if balance.proportional:
                row |= _critical_load(row, float(material.g_c[0]))
        if not has_k:
            row |= _pressed(near, largest, material)
        rows.append(row)
    empty = {name: np.full(np.shape(value), np.nan) for row in rows for name, value in row.items()}
    values = {name: np.array([row.get(name, nan) for row in rows]) for name, nan in empty.items()}
    relieved = relieved_nodes(body, balance)[[tip.node for tip in grid.tips]]
    for name in values.keys() - _OF_PLACE:
        values[name][relieved] = np.nan
    return values


def j_of_tips(body: Body, balance: Equilibrium, nodal: Floats) -> Floats:
    """Return J over the largest radius at every tip alone [N/mm], (tip,).

    Parameters
    ----------
    body, balance, nodal
        As of `evaluate_tips`.
    """
    grid, u = body.grid, balance.displacement
    found = []
    for tip, domain in zip(grid.tips, body.tip_domains, strict=True):
        radius = _within_bend(max(domain.radii), tip)
        J = cf.j_integral(nodal, cf.virtual_extension(grid, tip, radius))
        if balance.contact_pairs:
            turning = turning_of(grid, tip.crack, u) if balance.finite else None
            J += cf.j_of_sliding(grid, tip, radius, balance.contact_force, u, turning)
        found.append(J)
    return np.array(found)


def _forces_of_ring(near: _Neighbourhood, radius: float) -> dict[str, float]:
    """Configurational force over a disc and J of a ring."""
    force = cf.domain_force(near.grid, near.nodal, near.tip, radius)
    j = _j_integral(near, radius)
    return {
        "domain_radius": radius,
        "J_radius": j,
        # Of a tip that contact closes, J can be below zero: no energy release rate is.
        "G_radius": max(j, 0.0) if j >= -_round_off_of_j(near, radius) else math.nan,
        "cf_norm_radius": float(np.hypot(*force)),
        "cf_angle_radius": cf.angle(force, near.tip),
    }


def _round_off_of_j(near: _Neighbourhood, radius: float) -> float:
    """What J of a ring has by round-off of the energy in it [N/mm]."""
    inside = np.any(cf.ring_weight(near.grid, near.tip, radius)[near.grid.elements] > 0.0, axis=1)
    points = near.points
    energy = (points.energy * points.volume)[inside[points.element]].sum()
    return ROUND_OFF_J * float(energy) / radius


def _factors_of_ring(
    near: _Neighbourhood,
    body: Body,
    balance: Equilibrium,
    tip: CrackTip,
    ring: Mapping[str, float],
    material: Materials,
) -> dict[str, float]:
    """Stress intensity factors, G from them, and T-stress by interaction integrals over a ring."""
    radius = ring["domain_radius"]
    k = intensity_factors(
        near.grid,
        near.points,
        near.gradients,
        material,
        near.tip,
        cf.ring_weight(near.grid, near.tip, radius),
        body.loading.at(balance.load_factor).body_force,
        near.contact_force,
        bent_faces(body.grid, balance.displacement, tip, radius, material),
    ).confirmed(ring["J_radius"])
    return {
        "G_radius": k.G,
        "K_I_radius": k.K_I,
        "K_II_radius": k.K_II,
        "T_stress_radius": k.T_stress,
        "contact_pressure": k.pressure,
        "G_floor": k.G_floor,
    }


def _pressed(near: _Neighbourhood, radius: float, material: Materials) -> dict[str, float]:
    """Pressure of the faces of a closed tip on each other, and what J can tell, without K."""
    if near.contact_force is None:
        return {"contact_pressure": 0.0, "G_floor": 0.0}
    faces = PressedFaces.behind(near.grid, near.contact_force, near.tip, near.turning)
    q = cf.ring_weight(near.grid, near.tip, radius)
    if not faces.closed:
        return {"contact_pressure": 0.0, "G_floor": 0.0}
    pressure = faces.mean(q)
    inside = np.any(q[near.grid.elements[:, :3]] > 0.0, axis=1)[near.points.element]
    state = near.points.stress[inside], near.points.volume[inside]
    uniform = Uniform.around(near.tip, pressure, *state, material.lame[0])
    modulus = plane_modulus(*material.lame[0])
    # The rotation of the faces along the crack is neglected, which is of the order of the strain.
    strain = max(uniform.size / modulus, ROUND_OFF)
    left = uniform.left_of(*state)
    floor = least_energy_release_rate(left, uniform.size, radius, modulus, strain)
    return {"contact_pressure": pressure, "G_floor": floor}


def _may_be_small(
    near: _Neighbourhood,
    body: Body,
    balance: Equilibrium,
    tip: CrackTip,
    domain: TipDomain,
    material: Materials,
) -> bool:
    """Whether a tip at finite deformation may have stress intensity factors.

    Not on an interface, with plastic flow, and where its faces are in contact or the crack bends
    within the domain.
    """
    within = np.hypot(*(body.grid.nodes - tip.path[0]).T) <= 1.1 * max(domain.radii)
    pressed = near.contact_force is not None and near.contact_force[within].any()
    return not (
        domain.on_border
        or pressed
        or material.plastic.any()
        or body.motion is not None
        or bent_faces(body.grid, balance.displacement, tip, max(domain.radii), material)
    )


def _with_corotated_factors(
    rings: Sequence[dict[str, float]],
    near: _Neighbourhood,
    body: Body,
    balance: Equilibrium,
    material: Materials,
) -> list[dict[str, float]]:
    """Add K_I, K_II and T at finite deformation where strain is small in all rings; G stays J."""
    found = [
        corotated_factors(
            near.grid,
            near.points,
            near.gradients,
            material,
            near.tip,
            cf.ring_weight(near.grid, near.tip, ring["domain_radius"]),
            body.loading.at(balance.load_factor).body_force,
            ring["J_radius"],
        )
        for ring in rings
    ]
    return [
        ring
        | ({"K_I_radius": k.K_I, "K_II_radius": k.K_II, "T_stress_radius": k.T_stress} if k else {})
        for ring, k in zip(rings, found if all(found) else [None] * len(found), strict=True)
    ]


def _of_rings(rings: Sequence[dict[str, float]], largest: int) -> dict[str, Any]:
    """Values for each radius, and those of the largest radius under names without ``_radius``."""
    row: dict[str, Any] = {name: [ring[name] for ring in rings] for name in rings[0]}
    return row | {
        name.removesuffix("_radius"): value
        for name, value in rings[largest].items()
        if name != "domain_radius"
    }


def kink(row: Mapping[str, Any], direction: Direction) -> dict[str, float]:
    """Return kink angle [deg] and energy release rate `G_kink` of a kink [N/mm].

    Parameters
    ----------
    row : mapping of str to float
        Values of a tip that has stress intensity factors.
    direction : Direction
    """
    k_1, k_2 = row["K_I"], row["K_II"]
    loaded = k_1 != 0.0 or k_2 != 0.0
    driving = row["G"] * (direction.kink_factor(row) if loaded else 1.0)
    return {"kink_angle": max_hoop_angle(k_1, k_2), "G_kink": driving}


def values_of_tip(values: Mapping[str, Any], i: int) -> dict[str, Any]:
    """Return the row of one tip from the values of all, (tip,) or (tip, radius)."""
    return {name: value[i] for name, value in values.items()}


def _critical_load(row: Mapping[str, Any], toughness: float) -> dict[str, float]:
    """The load factor at which the driving force of the kink is g_c, under proportional loads."""
    if math.isnan(toughness) or is_closed(row["K_I"], row["K_II"]):
        return {}
    return {"critical_load_factor": load_factor_at_fracture(row["G_kink"], toughness)}


def _j_plastic(grid: Grid, plastic: Floats, tip: CrackTip, radius: float) -> float:
    """Contribution of plastic work to J over a ring [N/mm]."""
    return cf.j_integral(plastic, cf.virtual_extension(grid, tip, radius))


def _within_bend(radius: float, tip: CrackTip) -> float:
    """The radius of a ring for J, limited by the nearest sharp bend of the crack [mm]."""
    return min(radius, FILL * sharp_bend(tip))


def _j_integral(near: _Neighbourhood, radius: float) -> float:
    """J over a ring [N/mm]."""
    radius = _within_bend(radius, near.tip)
    J = cf.j_integral(near.nodal, cf.virtual_extension(near.grid, near.tip, radius))
    if near.contact_force is None:
        return J
    slid = near.contact_force, near.displacement, near.turning
    return J + cf.j_of_sliding(near.grid, near.tip, radius, *slid)


@dataclass(frozen=True)
class _Neighbourhood:
    """Part of the body around a tip, so that the cost of a ring depends on its size only."""

    grid: Grid
    points: DeformedPoints
    gradients: Floats
    nodal: Floats
    contact_force: Floats | None
    displacement: Floats
    tip: CrackTip
    turning: Turning | None = None

    @classmethod
    def of(
        cls,
        body: Body,
        gradients: Floats,
        balance: Equilibrium,
        nodal: Floats,
        tip: CrackTip,
        radius: float,
    ) -> _Neighbourhood:
        """Extract the triangles with a node within a radius [mm]."""
        grid, points = body.grid, balance.points
        if balance.contact_pairs:
            # The contact integral uses crack faces, which have the numbers of the whole grid.
            forces, u = (nodal, balance.contact_force), balance.displacement
            turning = turning_of(grid, tip.crack, u) if balance.finite else None
            return cls(grid, points, gradients, *forces, u, tip, turning)
        inside = np.hypot(*(grid.nodes - grid.nodes[tip.node]).T) <= radius
        is_near = inside[grid.elements].any(axis=1)
        nodes, local = np.unique(grid.elements[is_near], return_inverse=True)
        number = np.cumsum(is_near) - 1
        rows = np.flatnonzero(is_near[points.element])
        cut = {field.name: getattr(points, field.name)[rows] for field in fields(points)}
        cut["element"] = number[cut["element"]]
        return cls(
            grid=replace(
                grid,
                nodes=grid.nodes[nodes],
                elements=local.reshape(-1, grid.elements.shape[1]),
            ),
            points=DeformedPoints(**cut),
            gradients=gradients[rows],
            nodal=nodal[nodes],
            contact_force=None,
            displacement=balance.displacement[nodes],
            tip=replace(tip, node=int(np.searchsorted(nodes, tip.node))),
        )
