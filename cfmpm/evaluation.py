"""Everything that a state of balance says about its crack tips."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cfmpm.body import Body
from cfmpm.equilibrium import Equilibrium
from cfmpm.fracture import cf, criteria
from cfmpm.fracture.interaction import intensity_factors
from cfmpm.fracture.opening import smallest_openings
from cfmpm.grid import Floats, region_of


def evaluate_tips(
    body: Body,
    gradients: Floats,
    lame: Floats,
    balance: Equilibrium,
    nodal: Floats,
    g_c: Sequence[float | None],
) -> dict[str, Any]:
    """Evaluate configurational force, J, K_I, K_II and T at every tip.

    Parameters
    ----------
    body : Body
        In balance.
    gradients : (p, k, 2) float
        Basis gradients at its quadrature points [1/mm].
    lame : (q, 2) float
        Lame's constants of each region [MPa].
    balance : Equilibrium
    nodal : (n, 2) float
        From `cf.nodal_force`.
    g_c : sequence of float or None
        Critical energy release rate of each region [N/mm].

    Returns
    -------
    dict of str to array
        By the names of `results.VARIABLES`, (tip,) or (tip, radius). Values without ``_radius``
        are those of the largest radius.
    """
    grid, points, body_force = body.grid, body.integration, body.loading.body_force
    openings = smallest_openings(grid, balance.displacement)
    rows: list[dict[str, Any]] = []
    for tip, domain in zip(grid.tips, body.tip_domains, strict=True):
        region = region_of(grid, tip)
        rings: list[dict[str, float]] = []
        for radius in domain.radii:
            q = cf.ring_weight(grid, tip, radius)
            force = cf.domain_force(grid, nodal, tip, radius)
            k = intensity_factors(
                grid,
                points,
                gradients,
                lame[region],
                tip,
                q,
                body_force,
                balance.contact_force,
            )
            rings.append(
                {
                    "domain_radius": radius,
                    "J_radius": cf.j_integral(nodal, q, tip),
                    "G_radius": k.G,
                    "K_I_radius": k.K_I,
                    "K_II_radius": k.K_II,
                    "T_stress_radius": k.T_stress,
                    "cf_norm_radius": float(np.hypot(*force)),
                    "cf_angle_radius": cf.angle(force, tip),
                }
            )
        largest = int(np.argmax(domain.radii))
        force = cf.domain_force(grid, nodal, tip, domain.radii[largest])
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
            "kink_angle": criteria.max_hoop_angle(row["K_I"], row["K_II"]),
        }
        toughness = g_c[region]
        if toughness is not None and row["K_I"] > -abs(row["K_II"]):
            row["critical_load_factor"] = criteria.critical_load_factor(row["G"], toughness)
        rows.append(row)
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
