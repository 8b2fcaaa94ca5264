"""What a study of many small members costs besides solving them."""

from __future__ import annotations

import json
import logging
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cfmpm.results import write_dataset
from cfmpm.study.store import DATASET

ROOT = Path(__file__).parents[2]
log = logging.getLogger(__name__)


def measure(
    path: str | Path,
    scene: str | Path,
    *,
    replaced: Mapping[str, Any],
    lengths: int,
    stiffnesses: int,
    workers: Sequence[int],
) -> None:
    """Run ``cfmpm study`` on stationary cracks, by processes.

    Parameters
    ----------
    path : Path
        Of the netCDF file; dimension workers.
    scene : Path
        Of the family ``single_edge``.
    replaced : mapping
        Values of the scene, by dotted keys.
    lengths, stiffnesses : int
        How many crack lengths and Young's moduli are combined.
    workers : sequence of int

    Notes
    -----
    The overhead is the processor time of the command and all its processes less the wall times of
    the members: other programs make it smaller, not larger. It holds the start of the processes.
    """
    study = {
        "name": "overhead",
        "base": str((ROOT / scene).resolve()),
        "replace": dict(replaced),
        "product": {
            "length": {"key": "family.crack_length", "linspace": [50, 250, lengths]},
            "E": {"key": "material.E", "geomspace": [70e3, 280e3, stiffnesses]},
        },
    }
    rows = [_row(study, count) for count in workers]
    dataset = xr.concat(rows, xr.DataArray(list(workers), dims="workers", name="workers"))
    for name, (units, long_name) in {
        "overhead": ("ms", "processor time per member besides its solution"),
        "member_time": ("ms", "mean wall time of a member"),
        "wall_time": ("s", "wall time of the whole command"),
        "file_size": ("kB", "what is kept per member"),
    }.items():
        dataset[name].attrs = {"units": units, "long_name": long_name}
    write_dataset(dataset, Path(path))


def _row(study: Mapping[str, Any], workers: int) -> xr.Dataset:
    """A study from nothing to its dataset."""
    with tempfile.TemporaryDirectory() as folder:
        file, result = Path(folder, "study.yaml"), Path(folder, "result")
        file.write_text(json.dumps(study), encoding="utf-8")
        before, begin = _processor_time(), os.times().elapsed
        subprocess.run(
            [
                *(sys.executable, "-m", "cfmpm", "study", str(file), "--quiet"),
                *(f"--workers={workers}", f"--output={result}"),
            ],
            cwd=ROOT,
            check=True,
        )
        wall, spent = os.times().elapsed - begin, _processor_time() - before
        dataset = xr.load_dataset(result / DATASET)
        kept = sum(path.stat().st_size for path in (result / "members").iterdir())
    members, solving = dataset["run_time"].size, float(dataset["run_time"].sum())
    overhead = 1e3 * (spent - solving) / members
    log.info("%d members, %d processes: %.3g ms each besides", members, workers, overhead)
    return xr.Dataset(
        {
            "overhead": overhead,
            "member_time": 1e3 * solving / members,
            "wall_time": wall,
            "file_size": 1e-3 * kept / members,
            "members": members,
            "n_points": float(np.mean(dataset["n_points"])),
        }
    )


def _processor_time() -> float:
    """Of all processes that have been started and have ended [s]."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime
