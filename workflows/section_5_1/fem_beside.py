"""FEM on the grid of a member, and the grid itself, as the measure of the study of section 5.1."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.sparse.linalg import spsolve

from cfmpm.body.grid import Floats
from cfmpm.state import Result
from workflows.reference import plate_fem

FORCE = "N mm-1"


def fem_on_the_same_grid(result: Result) -> xr.Dataset:
    """What linear FEM finds on the grid of a result: `fem_` with the name of each quantity.

    Besides ``cf_difference``, of the nodal configurational force around the tip, ``n_elements``,
    and the grid itself with its points and with the configurational force of its corner nodes.
    """
    grid = result.grid
    history = result.history.isel(step=0, tip=0)
    tip = grid.nodes[grid.tips[0].node]
    radii = history.domain_radius.values
    plate = plate_fem.plate_of(result.scene, grid)
    system = plate_fem.assemble(plate, degree=grid.element.order)
    fem = plate_fem.solve(system, spsolve)
    place, force = plate_fem.nodal_force(fem)

    # Supports differ, and with them the rigid rotation, which moves CF at loaded nodes only.
    corners = np.hypot(*(plate.nodes - tip).T) <= radii.max()
    own = result.configurational_force[: grid.n_corners][corners]
    difference = np.abs(force[: grid.n_corners][corners] - own).max() / np.abs(own).max()

    distance = np.hypot(*(place - tip).T)
    sums = np.array([force[distance <= radius].sum(axis=0) for radius in radii])
    at_tip = force[grid.tips[0].node]
    found = xr.Dataset(
        {
            "fem_cf_norm": ("radius", np.hypot(*sums.T)),
            "fem_cf_angle": ("radius", angle(sums)),
            "fem_cf_tip_norm": np.hypot(*at_tip),
            "fem_cf_tip_angle": angle(at_tip),
            "fem_J": ("radius", [plate_fem.j_integral(fem, tip, radius) for radius in radii]),
            "fem_strain_energy": fem.energy,
            "cf_difference": difference,
            "n_elements": len(grid.elements),
        }
    )
    return found.assign(_grid(result))


def _grid(result: Result) -> xr.Dataset:
    """The grid of a result, its material points, and the force of its corner nodes."""
    grid = result.grid
    nodes = grid.nodes[: grid.n_corners]
    force = result.configurational_force[: grid.n_corners]
    points = result.body.points.position
    return xr.Dataset(
        {
            "node_x": ("node", nodes[:, 0], {"units": "mm"}),
            "node_y": ("node", nodes[:, 1], {"units": "mm"}),
            "cf_node_x": ("node", force[:, 0], {"units": FORCE}),
            "cf_node_y": ("node", force[:, 1], {"units": FORCE}),
            "triangle": (("face", "corner"), grid.triangles),
            "tip_node": grid.tips[0].node,
            "point_x": ("point", points[:, 0], {"units": "mm"}),
            "point_y": ("point", points[:, 1], {"units": "mm"}),
        }
    )


def angle(force: Floats) -> Floats:
    """Angle from the crack, which lies along x [deg]."""
    return np.degrees(np.arctan2(force[..., 1], force[..., 0]))
