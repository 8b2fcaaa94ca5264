"""Figures: functions that take data and an axes and return the axes."""

from cfmpm.plotting.deformed import draw_deformed
from cfmpm.plotting.film import animate_growth
from cfmpm.plotting.growth import (
    draw_angles,
    draw_cycles,
    draw_energy,
    draw_factors,
    draw_load,
    draw_load_displacement,
    draw_steps,
)
from cfmpm.plotting.mesh import Mesh, draw_cracks, draw_grid
from cfmpm.plotting.paths import draw_paths, draw_tip_cf
from cfmpm.plotting.scene import draw_scene
from cfmpm.plotting.style import picture
from cfmpm.plotting.tip import draw_radii, draw_tip_forces, draw_tip_points

__all__ = [
    "Mesh",
    "animate_growth",
    "draw_angles",
    "draw_cracks",
    "draw_cycles",
    "draw_deformed",
    "draw_energy",
    "draw_factors",
    "draw_grid",
    "draw_load",
    "draw_load_displacement",
    "draw_paths",
    "draw_radii",
    "draw_scene",
    "draw_steps",
    "draw_tip_cf",
    "draw_tip_forces",
    "draw_tip_points",
    "picture",
]
