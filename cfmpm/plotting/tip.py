"""Pictures of the configurational force around a crack tip."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from cfmpm.grid import CrackTip, Floats, Grid
from cfmpm.plotting.mesh import Mesh, draw_grid
from cfmpm.plotting.style import BLUE, GREEN, VERMILLION

# Length of the longest arrow as a part of the domain radius.
LONGEST = 0.6


def draw_tip_forces(
    axes: Axes, grid: Grid | Mesh, nodal_cf: Floats, tip: CrackTip | int, radius: float
) -> Axes:
    """Draw the configurational force of the nodes in a domain around a tip (paper Fig. 6b).

    Parameters
    ----------
    axes : Axes
    grid : Grid or Mesh
    nodal_cf : (n, 2) float
        Configurational force of each node [N/mm].
    tip : CrackTip or int
        A tip of the grid, or its node.
    radius : float
        Of the domain [mm].

    Returns
    -------
    Axes
        With the arrows of all nodes in the domain, and their sum as an arrow from the tip. All
        arrows have one scale.
    """
    node = tip if isinstance(tip, int) else tip.node
    x = grid.nodes[node]
    near = np.flatnonzero(np.hypot(*(grid.nodes - x).T) <= radius)
    total = nodal_cf[near].sum(axis=0)
    # In units of force over length, so that arrows have data lengths.
    scale = max(np.hypot(*nodal_cf[near].T).max(), np.hypot(*total)) / (LONGEST * radius) or 1.0

    draw_grid(axes, grid)
    # Forces of nodes off the tip are small: without a least length their arrows would become dots.
    style: dict[str, Any] = {
        "angles": "xy",
        "scale_units": "xy",
        "scale": scale,
        "minlength": 0.0,
        "zorder": 5,
    }
    label = f"sum over the domain: {np.hypot(*total):.4g} N/mm at {_degrees(total):.2f}°"
    axes.quiver(*x, *total, color=VERMILLION, width=0.012, label=label, **style)
    label = f"at {len(near)} nodes; at the tip's: {np.hypot(*nodal_cf[node]):.4g} N/mm"
    arrows: dict[str, Any] = {"color": BLUE, "width": 0.004, "label": label}
    axes.quiver(*grid.nodes[near].T, *nodal_cf[near].T, **arrows, **style)
    label = f"domain, radius {radius:.4g} mm"
    circle = Circle((x[0], x[1]), radius, fill=False, color=GREEN, lw=1.2, ls="--", label=label)
    circle.set_zorder(4)
    axes.add_patch(circle)
    axes.set_xlim(x[0] - 1.15 * radius, x[0] + 1.15 * radius)
    axes.set_ylim(x[1] - 1.15 * radius, x[1] + 1.15 * radius)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    return axes


def _degrees(force: Floats) -> float:
    """Angle of a vector from the x axis [deg]."""
    return float(np.degrees(np.arctan2(force[1], force[0])))
