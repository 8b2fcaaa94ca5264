"""Overhead of a study of many small members."""

from __future__ import annotations

import json
import logging
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cfmpm import simulation
from cfmpm.output.files import write_dataset
from cfmpm.study.reading import load_study
from cfmpm.study.running import THREADS
from cfmpm.study.store import DATASET, MEMBERS

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
    The overhead is the processor time of the command and all its processes, their start included,
    less that of solving the same scenes one after the other in one process that runs already.
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
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "study.yaml")
        file.write_text(json.dumps(study), encoding="utf-8")
        alone = _called("workflows.performance.study_overhead", file)
        solving = float(alone.stdout)
        rows = [_row(file, Path(folder, str(count)), count, solving) for count in workers]
    dataset = xr.concat(rows, xr.DataArray(list(workers), dims="workers", name="workers"))
    for name, (units, long_name) in {
        "overhead": ("ms", "processor time per member besides its solution"),
        "member_time": ("ms", "processor time of the solution of a member"),
        "wall_time": ("s", "wall time of the whole command"),
        "file_size": ("kB", "what is kept per member"),
    }.items():
        dataset[name].attrs = {"units": units, "long_name": long_name}
    write_dataset(dataset, Path(path))


def _row(file: Path, folder: Path, workers: int, solving: float) -> xr.Dataset:
    """A study from nothing to its dataset; `solving` is the time of all its scenes alone [s]."""
    before, begin = _processor_time(), time.monotonic()
    _called("cfmpm", "study", file, "--quiet", f"--workers={workers}", f"--output={folder}")
    wall, spent = time.monotonic() - begin, _processor_time() - before
    dataset = xr.load_dataset(folder / DATASET)
    kept = sum(path.stat().st_size for path in (folder / MEMBERS).iterdir())
    members = dataset["status"].size
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


def _called(module: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run a module on one thread."""
    return subprocess.run(
        [sys.executable, "-m", module, *map(str, arguments)],
        cwd=ROOT,
        env=os.environ | dict.fromkeys(THREADS, "1"),
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )


def _processor_time() -> float:
    """Of all processes that have been started and have ended [s]."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def _solve_alone(file: str) -> float:
    """Processor time of the scenes of a study [s]; the first is solved before, to load all."""
    scenes = [one.scene for one in load_study(file).members]
    simulation.run(scenes[0])
    begin = time.process_time()
    for scene in scenes:
        simulation.run(scene)
    return time.process_time() - begin


if __name__ == "__main__":
    sys.stdout.write(str(_solve_alone(sys.argv[1])))
