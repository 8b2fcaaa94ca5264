"""Figures of a crack tip: material points, configurational forces, results of the domains."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from cfmpm.body.grid import CrackTip, Floats, Grid
from cfmpm.body.points import MaterialPoints
from cfmpm.plotting.curves import draw_curve
from cfmpm.plotting.mesh import Mesh, draw_grid
from cfmpm.plotting.style import BLUE, GREEN, GREY, VERMILLION

# Length of the longest arrow, relative to the domain radius.
LONGEST = 0.6
# How many times the differences of G and J |CF| may be from J to be drawn on their scale.
APART = 5.0


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
        Radius of the domain [mm].

    Returns
    -------
    Axes
        With the forces of all nodes in the domain, and their sum as an arrow from the tip, all on
        the same scale.
    """
    node = tip if isinstance(tip, int) else tip.node
    x = grid.nodes[node]
    near = np.flatnonzero(np.hypot(*(grid.nodes - x).T) <= radius)
    total = nodal_cf[near].sum(axis=0)
    # Scale in force per length, so that arrows have lengths in data units.
    scale = max(np.hypot(*nodal_cf[near].T).max(), np.hypot(*total)) / (LONGEST * radius) or 1.0

    draw_grid(axes, grid)
    # Forces at other nodes than the tip are small: without a minimum length they would be dots.
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
    axes.add_patch(_circle(x, radius, label=label))
    _look_at(axes, x, radius)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    return axes


def draw_tip_points(
    axes: Axes, grid: Grid, points: MaterialPoints, tip: CrackTip, radii: Sequence[float]
) -> Axes:
    """Draw grid and material points in the smallest domain around a tip.

    Parameters
    ----------
    axes : Axes
    grid : Grid
    points : MaterialPoints
    tip : CrackTip
    radii : sequence of float
        Radii of the domains [mm].

    Returns
    -------
    Axes
    """
    x, radius = grid.nodes[tip.node], min(radii)
    near = (np.abs(points.position - x) <= 1.15 * radius).all(axis=1)
    draw_grid(axes, grid, colour=GREY)
    label = f"material points, {len(points)} in all"
    axes.plot(*points.position[near].T, "o", color=BLUE, ms=2.0, mew=0.0, zorder=2, label=label)
    label = f"domain, radius {radius:.4g} mm, {radius / tip.h:.3g} elements at the tip"
    axes.add_patch(_circle(x, radius, label=label))
    _look_at(axes, x, radius)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    return axes


def draw_radii(axes: Axes, history: xr.Dataset, *, norm: bool = True) -> Axes:
    """Draw G, J and the norm of CF at a tip against the radius of their domain.

    Parameters
    ----------
    axes : Axes
    history : xarray.Dataset
        At one step and one tip.
    norm : bool
        Whether the norm of CF is drawn too. In mixed mode it is far from G and J, whose differences
        are then too small to be seen on one scale.

    Returns
    -------
    Axes
        G and J do not depend on the domain in theory, CF in mixed mode does: how far they do here
        is the uncertainty of the evaluation. J has large open markers: where it is equal to G both
        are seen.
    """
    at = _by_radius(history)
    if not np.isnan(at["K_I_radius"]).all():  # else G is J, at finite deformation
        draw_curve(axes, at["domain_radius"], at["G_radius"], "G from K_I and K_II", 0)
    draw_curve(axes, at["domain_radius"], at["J_radius"], "J", 1, line="--", hollow=True)
    if norm:
        draw_curve(axes, at["domain_radius"], at["cf_norm_radius"], "|CF|", 2)
    axes.set_title(f"step {int(at['step'])}, load factor {float(at['load_factor']):.4g}")
    return _finished(axes, "energy release rate" + (", force" if norm else ""))


def draw_norm(axes: Axes, history: xr.Dataset) -> Axes:
    """Draw the norm of CF at a tip against the radius of its domain; see `draw_radii`."""
    at = _by_radius(history)
    draw_curve(axes, at["domain_radius"], at["cf_norm_radius"], "|CF|", 2)
    return _finished(axes, "configurational force")


def norm_is_apart(history: xr.Dataset) -> bool:
    """Whether the norm of CF is so far from J that one scale cannot show both."""
    j, norm = history["J_radius"].values, history["cf_norm_radius"].values
    spread = np.ptp([j, history["G_radius"].values])
    return bool(np.abs(norm - j).max() > APART * spread)


def _by_radius(history: xr.Dataset) -> xr.Dataset:
    return history.isel(radius=np.argsort(history["domain_radius"].values))


def _finished(axes: Axes, what: str) -> Axes:
    axes.set_xlabel("radius of the domain [mm]")
    axes.set_ylabel(f"{what} [N/mm]")
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.legend()
    return axes


def _circle(x: Floats, radius: float, label: str) -> Circle:
    circle = Circle((x[0], x[1]), radius, fill=False, color=GREEN, lw=1.2, ls="--", label=label)
    circle.set_zorder(4)
    return circle


def _look_at(axes: Axes, x: Floats, radius: float) -> None:
    axes.set_xlim(x[0] - 1.15 * radius, x[0] + 1.15 * radius)
    axes.set_ylim(x[1] - 1.15 * radius, x[1] + 1.15 * radius)


def _degrees(force: Floats) -> float:
    """Angle of a vector from the x axis [deg]."""
    return float(np.degrees(np.arctan2(force[1], force[0])))
