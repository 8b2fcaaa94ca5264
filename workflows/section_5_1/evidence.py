"""What the claims of section 5.1 are decided from, and how it is told."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from cfmpm.body.grid import Floats


@dataclass(frozen=True)
class Evidence:
    """What claims are decided from; forces in N/mm, lengths in mm.

    Attributes
    ----------
    T3, T6, graded : xarray.Dataset
        By MPM and FEM, from `datasets.write_datasets`.
    grids : xarray.Dataset
        The grids of the figures with the forces of their nodes, from the same.
    radius : float
        Of the domain.
    converged : float
        G of the plate of finite height.
    swept : tuple of int
        The two grids of Fig. 6.
    crack_length, height : float
    """

    T3: xr.Dataset
    T6: xr.Dataset
    graded: xr.Dataset
    grids: xr.Dataset
    radius: float
    converged: float
    swept: tuple[int, ...]
    crack_length: float
    height: float

    @property
    def handbook(self) -> float:
        """G of the handbook's polynomial."""
        return float(self.T3.handbook)

    def norm(self, series: xr.Dataset, scheme: str = "MPM") -> Floats:
        """Norm of CF on the domain, by grid."""
        values: Floats = series.cf_norm.sel(scheme=scheme, radius=self.radius).values
        return values

    def angle(self, series: xr.Dataset, scheme: str = "MPM") -> Floats:
        """Angle of CF on the domain, by grid [deg]."""
        values: Floats = series.cf_angle.sel(scheme=scheme, radius=self.radius).values
        return values

    def tip_norm(self, scheme: str = "MPM") -> Floats:
        """Norm of CF of the tip node on T3, by grid."""
        values: Floats = self.T3.cf_tip_norm.sel(scheme=scheme).values
        return values

    def tip_angle(self, scheme: str = "MPM") -> Floats:
        """Angle of CF of the tip node on T3, by grid [deg]."""
        values: Floats = self.T3.cf_tip_angle.sel(scheme=scheme).values
        return values

    def error(self, norms: Floats) -> Floats:
        """Signed error of norms against the plate's own G."""
        return norms / self.converged - 1.0

    def line_error(self, norms: Floats) -> Floats:
        """Signed error of norms against the paper's line."""
        return norms / self.handbook - 1.0

    @property
    def best(self) -> float:
        """J of the finest graded grid."""
        return float(self.graded.J.sel(scheme="MPM").isel(grid=-1, radius=-1))

    def points(self, wanted: int) -> int:
        """Points of a grid of T3, by the paper's number."""
        return int(self.T3.n_points.sel(grid=wanted))


def settled(values: xr.DataArray, allowed: float, *, relative: bool) -> float:
    """Smallest radius from which on values stay near that at the largest [mm]."""
    last = values.isel(radius=-1)
    off = abs(values / last - 1.0) if relative else abs(values - last)
    away = np.flatnonzero(off.values > allowed)
    return float(values.radius[away[-1] + 1 if away.size else 0])


def of_nodes(grid: xr.Dataset) -> tuple[Floats, Floats, Floats]:
    """Distance of the nodes from the tip [mm], norm of their force over the tip's, and its x."""
    there = grid.node_x.notnull().values
    x, y, fx, fy = (
        grid[name].values[there] for name in ("node_x", "node_y", "cf_node_x", "cf_node_y")
    )
    tip = int(grid.tip_node)
    norm = np.hypot(fx, fy)
    return np.hypot(x - x[tip], y - y[tip]), norm / norm[tip], fx[tip : tip + 1]


def largest_difference(series: xr.Dataset) -> float:
    """Between MPM and FEM, of all that was compared."""
    ratios = [
        abs(series[name].sel(scheme="MPM") / series[name].sel(scheme="FEM") - 1.0).max()
        for name in ("cf_norm", "cf_tip_norm", "J", "strain_energy")
    ]
    return float(max([*ratios, series.cf_difference.max()]))


def word(held: bool | np.bool, yes: str = "yes", no: str = "no") -> str:
    """One of two words."""
    return yes if held else no


def grade(*held: bool | np.bool) -> str:
    """How far a claim of several parts holds."""
    return "yes" if all(held) else "in part" if any(held) else "no"


def percent(value: float, digits: int = 1) -> str:
    """A part as a signed percentage."""
    return f"{100 * float(value):+.{digits}f} %"


def percents(values: Floats) -> str:
    """Parts as signed percentages."""
    return " ".join(f"{100 * float(v):+.1f}" for v in values) + " %"


def degrees(values: Floats) -> str:
    """Angles."""
    return " ".join(f"{v:.2f}" for v in values) + " deg"
