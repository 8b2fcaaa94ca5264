"""Pictures: functions that take data and an axes and return the axes, and writers of files."""

from cfmpm.plotting.mesh import Mesh, draw_cracks, draw_grid
from cfmpm.plotting.tip import draw_tip_forces

__all__ = ["Mesh", "draw_cracks", "draw_grid", "draw_tip_forces"]
