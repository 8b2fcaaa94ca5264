"""Figures of the deformed grid with its stress."""

from __future__ import annotations

import json
import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection

from cfmpm.body.grid import signed_areas
from cfmpm.plotting.mesh import Mesh
from cfmpm.plotting.style import BLACK, GREY, STRESS_MAP, length_axes

# Drawn size of the largest displacement, about, relative to the size of the body.
SHOWN = 0.05
# Part of the area within the range of the colours, since stress is singular at a tip.
COLOURED = 0.98


def draw_deformed(
    axes: Axes,
    fields: xr.Dataset,
    stress: str = "von_mises",
    *,
    factor: float | None = None,
    limits: tuple[float, float] | None = None,
    bar: Axes | None = None,
) -> Axes:
    """Draw the deformed grid with a stress as colour.

    Parameters
    ----------
    axes : Axes
    fields : xarray.Dataset
        From :func:`cfmpm.output.fields.build_fields`, or read back from its file.
    stress : str
        A variable on the faces.
    factor : float, optional
        Magnification of the displacements; default: such that they are visible.
    limits : (float, float), optional
        Lowest and highest stress of the colours; default: those of 98 % of the area.
    bar : Axes, optional
        Takes the colour bar, whose form then does not depend on the values, as in a film; default:
        made beside the grid.

    Returns
    -------
    Axes
        Its title has the magnification of the displacements and the lowest and highest stress, or
        says that there is none, as in a severed body. These lie outside the colour bar where it has
        a pointed end: its range is that of 98 % of the area, as in its label. Dotted lines are the
        undeformed boundary.
    """
    mesh, last = Mesh.of_fields(fields), fields.isel(time=-1)
    u = np.column_stack([last["u_x"], last["u_y"]])
    factor = factor or magnification(u, mesh.nodes)
    moved = mesh.nodes + factor * u
    values = last[stress].values
    free = np.abs(values).max() <= _round_off(fields, u, mesh)
    low, high = limits or ((0.0, 1.0) if free else _colour_limits(values, mesh))
    inner, outer = mesh.edges()

    faces = PolyCollection(list(moved[mesh.faces]), cmap=STRESS_MAP, edgecolors="face", lw=0.1)
    faces.set_array(values)
    faces.set_clim(low, high)
    axes.add_collection(faces)
    axes.add_collection(
        LineCollection(list(moved[inner]), colors="white", linewidths=0.25, alpha=0.35)
    )
    axes.add_collection(
        LineCollection(list(mesh.nodes[outer]), colors=GREY, linewidths=0.7, linestyles=":")
    )
    # Seen on the darkest colour too, where a crack is closed.
    axes.add_collection(LineCollection(list(moved[outer]), colors="white", linewidths=2.1))
    axes.add_collection(LineCollection(list(moved[outer]), colors=BLACK, linewidths=0.7))
    axes.autoscale_view()
    length_axes(axes)
    said = fields[stress].attrs
    below, above = values.min() < low, values.max() > high
    extend = {(False, False): "neither", (True, True): "both"}.get(
        (bool(below), bool(above)), "max" if above else "min"
    )
    label = f"{said['long_name']} [{said['units']}]"
    if limits is None and (below or above):
        label += f"\nthe bar spans {100 * COLOURED:.0f} % of the area"
    if bar is None:
        axes.figure.colorbar(faces, ax=axes, label=label, extend=extend, shrink=0.8)
    else:
        axes.figure.colorbar(faces, cax=bar, label=label, extend="both")
    found = f"{stress} in triangles: {values.min():.4g} to {values.max():.4g} {said['units']}"
    axes.set_title(
        f"displacement × {factor:g}, largest {np.hypot(*u.T).max():.3g} mm\n"
        + ("stress-free up to round-off" if free else found)
    )
    return axes


def magnification(displacement: np.ndarray, nodes: np.ndarray) -> float:
    """Return the magnification at which displacements are visible.

    Parameters
    ----------
    displacement : (n, 2) float
        [mm].
    nodes : (n, 2) float
        [mm].

    Returns
    -------
    float
        1, 2 or 5 times a power of ten, at least 1; 1 without displacements.
    """
    largest = float(np.hypot(*displacement.T).max())
    if largest == 0.0:
        return 1.0
    wanted = max(1.0, SHOWN * float(np.ptp(nodes, axis=0).max()) / largest)
    power = 10.0 ** math.floor(math.log10(wanted))
    return power * max(step for step in (1.0, 2.0, 5.0) if step * power <= wanted * (1 + 1e-9))


def _round_off(fields: xr.Dataset, displacement: np.ndarray, mesh: Mesh) -> float:
    """Stress by round-off of the displacement [MPa]; 0 if E is unknown."""
    if "config" not in fields.attrs:
        return 0.0
    modulus = float(json.loads(fields.attrs["config"])["material"]["E"])
    sides = mesh.nodes[mesh.faces] - mesh.nodes[np.roll(mesh.faces, 1, axis=1)]
    shortest = float(np.hypot(sides[..., 0], sides[..., 1]).min())
    eps = 1e3 * np.finfo(float).eps  # displacements lose some digits in the solve
    return eps * modulus * float(np.abs(displacement).max()) / shortest


def _colour_limits(values: np.ndarray, mesh: Mesh) -> tuple[float, float]:
    """The range of values without those on the most stressed part of the area."""
    area = np.abs(signed_areas(mesh.nodes[mesh.faces]))
    order = np.argsort(values)
    share = np.cumsum(area[order]) / area.sum()
    margin = 0.5 * (1.0 - COLOURED)
    low, high = np.searchsorted(share, [margin, 1.0 - margin])
    return float(values[order[low]]), float(values[order[min(high, len(values) - 1)]])
