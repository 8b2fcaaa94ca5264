"""Run time of each phase against the number of material points."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import cfmpm
from cfmpm.results import write_dataset
from workflows.settings import scene_with

# Smaller runs are governed by fixed costs, which have no exponent.
FITTED_FROM = 10_000
log = logging.getLogger(__name__)


def measure(
    path: str | Path,
    scene: str | Path,
    *,
    solver: str,
    repeats: int,
    series: Mapping[str, Sequence[Mapping[str, Any]]],
) -> None:
    """Measure grids of growing size.

    Parameters
    ----------
    path : Path
        Of the netCDF file; dimensions element, rank (from the smallest grid), phase.
    scene : str
        Scene file.
    solver : str
    repeats : int
        The fastest run counts; one run alone above half a million points.
    series : mapping
        Lists of grids by element, smallest first.
    """
    elements = []
    for element, meshes in series.items():
        rows, used = [], []
        for mesh in meshes:
            scenario = scene_with(scene, mesh, solver=solver)
            runs: list[xr.Dataset] = []
            while len(runs) < repeats and not (runs and runs[0].n_points > 500_000):
                history = cfmpm.run(scenario).history
                runs.append(
                    history.isel(step=0, drop=True)[["wall_time", "n_points", "n_unknowns"]]
                )
            fastest = min(runs, key=lambda run: float(run.wall_time.sum()))
            log.info("%s: %d points, %.2f s", element, fastest.n_points, fastest.wall_time.sum())
            rows.append(fastest)
            used.append(history.attrs["solver"])
        ranked = xr.concat(rows, "rank", combine_attrs="drop_conflicts")
        elements.append(
            ranked.assign(exponent=_exponents(ranked), solver_used=("rank", used)).assign_coords(
                rank=np.arange(len(rows))
            )
        )
    dataset = xr.concat(elements, "element", join="outer", combine_attrs="drop_conflicts")
    dataset = dataset[["wall_time", "n_points", "n_unknowns", "exponent", "solver_used"]]
    dataset = dataset.drop_vars("load_factor", errors="ignore").assign_coords(element=list(series))
    dataset.attrs |= {
        key: history.attrs[key] for key in ("Conventions", "source", "references", "versions")
    }
    dataset.attrs["title"] = "Run time against the number of material points"
    write_dataset(dataset, Path(path))


def _exponents(ranked: xr.Dataset) -> xr.DataArray:
    """Exponent of each phase in time ~ points^exponent, over the larger grids."""
    large = ranked.where(ranked.n_points >= FITTED_FROM, drop=True)
    if large.sizes["rank"] < 2:
        large = ranked
    values = [
        np.polyfit(np.log(large.n_points), np.log(large.wall_time.sel(phase=phase)), 1)[0]
        for phase in ranked.phase
    ]
    return xr.DataArray(
        values,
        {"phase": ranked.phase},
        attrs={
            "units": "1",
            "long_name": f"fitted exponent of the number of points, from {FITTED_FROM} points",
        },
    )
