"""Configurational forces of the nodes around a tip, those beside it on a scale of their own."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from cfmpm.body.grid import Floats
from cfmpm.plotting.mesh import Mesh, draw_grid
from cfmpm.plotting.style import BLUE, GREEN, VERMILLION

# Lengths of the arrow at the tip and of the longest one elsewhere, relative to the radius.
AT_TIP, ELSEWHERE = 0.75, 0.22


def draw_nodal_forces(
    axes: Axes, mesh: Mesh, force: Floats, tip: int, radius: float
) -> tuple[float, float]:
    """Draw the forces of all nodes in a domain (paper Fig. 6 b and d).

    Parameters
    ----------
    axes : Axes
    mesh : Mesh
    force : (n, 2) float
        Configurational force of each node [N/mm].
    tip : int
        The node of the tip.
    radius : float
        Of the domain [mm].

    Returns
    -------
    (float, float)
        Norms of the force at the tip, and of the largest one elsewhere, which has a scale of its
        own [N/mm].
    """
    x = mesh.nodes[tip]
    distance = np.hypot(*(mesh.nodes - x).T)
    others = np.flatnonzero((distance <= radius) & (np.arange(len(distance)) != tip))
    norms = np.hypot(*force.T)
    at_tip, largest = float(norms[tip]), float(norms[others].max())
    draw_grid(axes, mesh, width=0.3)
    style: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "minlength": 0.0}
    axes.quiver(
        *x,
        *force[tip],
        color=VERMILLION,
        width=0.014,
        scale=at_tip / (AT_TIP * radius),
        label=f"tip node: {at_tip:.3f} N/mm",
        zorder=5,
        **style,
    )
    axes.quiver(
        *mesh.nodes[others].T,
        *force[others].T,
        color=BLUE,
        width=0.007,
        scale=largest / (ELSEWHERE * radius),
        label=f"others, {_times(at_tip, largest):.2g} times as long: up to {largest:.4f} N/mm",
        zorder=6,
        **style,
    )
    label = f"domain, R = {radius:g} mm"
    circle = Circle((x[0], x[1]), radius, fill=False, color=GREEN, lw=1.1, ls="--", label=label)
    axes.add_patch(circle)
    axes.set_xlim(x[0] - 1.12 * radius, x[0] + 1.12 * radius)
    axes.set_ylim(x[1] - 1.12 * radius, x[1] + 1.12 * radius)
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.16), fontsize=7, borderaxespad=0.0)
    return at_tip, largest


def _times(at_tip: float, largest: float) -> float:
    """How many times longer arrows elsewhere are than on the scale of the tip."""
    return (ELSEWHERE / largest) / (AT_TIP / at_tip)
