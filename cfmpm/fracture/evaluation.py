"""Everything that a state of balance says about its crack tips."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cfmpm.fracture import cf, criteria
from cfmpm.fracture.domains import Domains
from cfmpm.fracture.interaction import intensity_factors
from cfmpm.fracture.opening import smallest_openings
from cfmpm.grid import Floats, Grid
from cfmpm.points import MaterialPoints


def evaluate_tips(
    grid: Grid,
    points: MaterialPoints,
    gradients: Floats,
    lame: Floats,
    displacement: Floats,
    nodal: Floats,
    domains: Sequence[Domains],
    body_force: Floats,
    g_c: Sequence[float | None],
) -> dict[str, Any]:
    """Evaluate configurational force, J, K_I, K_II and T at every tip.

    Parameters
    ----------
    grid : Grid
    points : MaterialPoints
    gradients : (p, k, 2) float
    lame : (q, 2) float
    displacement : (n, 2) float
        Of the nodes [mm].
    nodal : (n, 2) float
        From `cf.nodal_force`.
    domains : sequence of Domains
        One a tip, all with the same number of radii.
    body_force : (2,) float
    g_c : sequence of float or None
        Critical energy release rate of each region [N/mm].

    Returns
    -------
    dict of str to array
        By the names of `results.VARIABLES`, (tip,) or (tip, radius). Values without ``_radius``
        are those of the largest radius.
    """
    openings = smallest_openings(grid, displacement)
    rows: list[dict[str, Any]] = []
    for tip, domain in zip(grid.tips, domains, strict=True):
        # The three corners of any triangle at the tip lie in one region: rings do not leave it.
        region = grid.regions[np.argmax((grid.triangles == tip.node).any(axis=1))]
        rings: list[dict[str, float]] = []
        for radius in domain.radii:
            q = cf.ring_weight(grid, tip, radius)
            force = cf.domain_force(grid, nodal, tip, radius)
            k = intensity_factors(grid, points, gradients, lame[region], tip, q, body_force)
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
        faces = grid.crack_faces[tip.crack][:, 0]
        ends = grid.nodes[grid.edge_nodes(faces)[:, :2]]
        row |= {
            "tip_x": grid.nodes[tip.node, 0],
            "tip_y": grid.nodes[tip.node, 1],
            "crack_length": np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum(),
            "cf_x": force[0],
            "cf_y": force[1],
            "cf_tip_x": nodal[tip.node, 0],
            "cf_tip_y": nodal[tip.node, 1],
            "min_opening": openings[tip.crack],
            "kink_angle": criteria.max_hoop_angle(row["K_I"], row["K_II"]),
        }
        toughness = g_c[region]
        if toughness is not None:
            row["critical_load_factor"] = criteria.critical_load_factor(row["G"], toughness)
        rows.append(row)
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
