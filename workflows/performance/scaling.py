"""Run time of each phase, and memory, against the number of material points and of threads."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cfmpm.output.files import write_dataset
from cfmpm.output.provenance import provenance
from cfmpm.scene import load_scene
from workflows.performance.alone import run_alone

# Smaller runs are governed by fixed costs, which have no exponent.
FITTED_FROM = 10_000
log = logging.getLogger(__name__)


def measure(
    path: str | Path,
    scene: str | Path,
    *,
    solver: str,
    repeats: int,
    threads: Sequence[int],
    series: Mapping[str, Sequence[Mapping[str, Any]]],
) -> None:
    """Measure grids of growing size.

    Parameters
    ----------
    path : Path
        Of the netCDF file; dimensions element, threads, rank (from the smallest grid), phase.
    scene : str
        Scene file.
    solver : str
    repeats : int
        The fastest run counts.
    threads : sequence of int
        Each number in processes of its own.
    series : mapping
        Lists of grids by element, smallest first.
    """
    elements = []
    for meshes in series.values():
        of_threads = []
        for n in threads:
            rows = []
            for mesh in meshes:
                replaced = {"mesh": dict(mesh), "solver": solver}
                rows.append(_row(run_alone(scene, replaced, threads=n, repeats=repeats)))
                told = float(rows[-1].wall_time.sum()), float(rows[-1].memory)
                log.info("%s, %d threads: %.2f s, %.0f MB", mesh, n, *told)
            ranked = xr.concat(rows, "rank").assign_coords(rank=np.arange(len(rows)))
            of_threads.append(ranked.assign(exponent=_exponents(ranked)))
        elements.append(xr.concat(of_threads, xr.Variable("threads", list(threads))))
    dataset = xr.concat(elements, xr.Variable("element", list(series)), join="outer")
    # How large a grid is does not depend on the threads.
    for name in ("n_points", "n_unknowns"):
        dataset[name] = dataset[name].isel(threads=0, drop=True)
    told = provenance(load_scene(scene))
    dataset.attrs = {key: told[key] for key in ("Conventions", "source", "references", "versions")}
    dataset.attrs["title"] = "Run time and memory against the number of material points"
    write_dataset(dataset, Path(path))


def _row(found: Mapping[str, Any]) -> xr.Dataset:
    """One grid."""
    said = {
        "wall_time": ("s", "wall time of the fastest run"),
        "memory": ("MB", "peak of the process, libraries included"),
        "n_points": ("1", "material points"),
        "n_unknowns": ("1", "free degrees of freedom"),
    }
    row = xr.Dataset(
        {
            "wall_time": ("phase", list(found["seconds"].values())),
            "memory": found["memory"],
            "n_points": float(found["n_points"]),
            "n_unknowns": float(found["n_unknowns"]),
            "solver_used": found["solver"],
        },
        {"phase": list(found["seconds"])},
    )
    for name, (units, long_name) in said.items():
        row[name].attrs = {"units": units, "long_name": long_name}
    return row


def _exponents(ranked: xr.Dataset) -> xr.DataArray:
    """Exponent of each phase in time ~ points^exponent, over the larger grids."""
    large = ranked.isel(rank=np.flatnonzero(ranked.n_points >= FITTED_FROM))
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
