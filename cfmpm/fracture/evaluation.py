"""Everything that a state of balance says about its crack tips."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.crack_faces import smallest_openings
from cfmpm.body.grid import CrackTip, Floats, Grid, regions_ahead
from cfmpm.body.points import DeformedPoints
from cfmpm.body.tip_domains import FILL, sharp_bend
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture import cf
from cfmpm.fracture.criteria.max_hoop import max_hoop_angle
from cfmpm.fracture.criteria.protocols import direction_by, is_closed, load_factor_at_fracture
from cfmpm.fracture.interaction import bent_faces, intensity_factors


def evaluate_tips(
    body: Body,
    gradients: Floats,
    balance: Equilibrium,
    nodal: Floats,
    plastic: Floats | None = None,
) -> dict[str, Any]:
    """Evaluate configurational force, J, K_I, K_II and T at every tip.

    Finite deformation has no K and no T, nor has a tip on the border of two materials; there G is
    J.

    Parameters
    ----------
    body : Body
    gradients : (p, k, 2) float
        Basis gradients at its quadrature points [1/mm].
    balance : Equilibrium
        Of the body.
    nodal : (n, 2) float
        From `cf.nodal_force`.
    plastic : (n, 2) float, optional
        From `mechanics.plastic_nodal_force`.

    Returns
    -------
    dict of str to array
        By the names of a history's variables, (tip,) or (tip, radius). Values without
        ``_radius`` are those of the largest radius.
    """
    grid, body_force = body.grid, body.loading.at(balance.load_factor).body_force
    growth = body.scene.growth
    direction = direction_by("max_hoop" if growth is None else growth.direction)
    openings = smallest_openings(grid, balance.displacement, balance.finite)
    rows: list[dict[str, Any]] = []
    for tip, domain in zip(grid.tips, body.tip_domains, strict=True):
        ahead = regions_ahead(grid, tip, tip.tangent)
        material = body.materials.row(ahead[0])
        has_k = not (balance.finite or domain.on_border)
        near = _Neighbourhood.of(body, gradients, balance, nodal, tip, max(domain.radii))
        rings: list[dict[str, float]] = []
        for radius in domain.radii:
            q = cf.ring_weight(near.grid, near.tip, radius)
            force = cf.domain_force(near.grid, near.nodal, near.tip, radius)
            j = _j_integral(near, radius)
            ring = {
                "domain_radius": radius,
                "J_radius": j,
                "G_radius": j,
                "cf_norm_radius": float(np.hypot(*force)),
                "cf_angle_radius": cf.angle(force, tip),
            }
            if plastic is not None:
                weight = cf.ring_weight(grid, tip, radius)
                ring["J_plastic_radius"] = cf.j_integral(plastic, weight, tip)
            if has_k:
                faces = bent_faces(grid, balance.displacement, tip, radius, material)
                k = intensity_factors(
                    near.grid,
                    near.points,
                    near.gradients,
                    material,
                    near.tip,
                    q,
                    body_force,
                    near.contact_force,
                    faces,
                )
                ring |= {
                    "G_radius": k.G,
                    "K_I_radius": k.K_I,
                    "K_II_radius": k.K_II,
                    "T_stress_radius": k.T_stress,
                }
            rings.append(ring)
        largest = int(np.argmax(domain.radii))
        force = cf.domain_force(near.grid, near.nodal, near.tip, domain.radii[largest])
        row: dict[str, Any] = {name: [ring[name] for ring in rings] for name in rings[0]}
        row |= {
            name.removesuffix("_radius"): value
            for name, value in rings[largest].items()
            if name != "domain_radius"
        }
        row |= {
            "cf_x": force[0],
            "cf_y": force[1],
            "cf_tip_x": nodal[tip.node, 0],
            "cf_tip_y": nodal[tip.node, 1],
            "min_opening": openings[tip.crack],
        }
        if plastic is not None:
            radius = domain.radii[largest]
            row["cf_plastic_x"], row["cf_plastic_y"] = cf.domain_force(grid, plastic, tip, radius)
        if has_k:
            k_1, k_2 = row["K_I"], row["K_II"]
            row["kink_angle"] = max_hoop_angle(k_1, k_2)
            loaded = k_1 != 0.0 or k_2 != 0.0
            row["G_kink"] = row["G"] * (direction.kink_factor(row) if loaded else 1.0)
            toughness = float(material.g_c[0])
            if not math.isnan(toughness) and not is_closed(k_1, k_2):
                row["critical_load_factor"] = load_factor_at_fracture(row["G_kink"], toughness)
        rows.append(row)
    empty = {name: np.full(np.shape(value), np.nan) for row in rows for name, value in row.items()}
    return {name: np.array([row.get(name, nan) for row in rows]) for name, nan in empty.items()}


def _j_integral(near: _Neighbourhood, radius: float) -> float:
    """J of a ring [N/mm], which ends at a sharp bend of the crack."""
    radius = min(radius, FILL * sharp_bend(near.tip))
    return cf.j_integral(near.nodal, cf.ring_weight(near.grid, near.tip, radius), near.tip)


@dataclass(frozen=True)
class _Neighbourhood:
    """What lies around one tip, cut out once: rings cost what they hold, not the whole body."""

    grid: Grid
    points: DeformedPoints
    gradients: Floats
    nodal: Floats
    contact_force: Floats | None
    tip: CrackTip

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
        """Cut out the triangles with a node within a radius [mm]."""
        grid, points = body.grid, balance.points
        if balance.contact_pairs:
            # Contact is summed over crack faces, which are numbered with the whole grid.
            return cls(grid, points, gradients, nodal, balance.contact_force, tip)
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
            tip=replace(tip, node=int(np.searchsorted(nodes, tip.node))),
        )
