"""Runs of a scene in a separate process, for its own threads and memory."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cfmpm
from cfmpm.scene import load_scene
from cfmpm.study.running import THREADS

ROOT = Path(__file__).parents[2]
SINGLE_ABOVE = 500_000


def run_alone(
    scene: str | Path, replaced: Mapping[str, Any], *, threads: int, repeats: int
) -> dict[str, Any]:
    """Run a scene several times in a new process.

    Parameters
    ----------
    scene : Path
    replaced : mapping
        Values of the scene by dotted keys.
    threads : int
        Threads of kernels and of linear algebra.
    repeats : int
        Above half a million points there is one run.

    Returns
    -------
    dict
        ``seconds`` (wall time by phase, of the fastest run), ``n_points``, ``n_unknowns``,
        ``solver``, and ``memory``, the peak of the process [MB].

    Raises
    ------
    RuntimeError
        If the process failed, with its error output.
    """
    asked = json.dumps([str(scene), dict(replaced), repeats])
    done = subprocess.run(
        [sys.executable, "-m", __spec__.name, asked],
        cwd=ROOT,
        env=os.environ | dict.fromkeys(THREADS, str(threads)),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(f"{scene} with {replaced} failed: {done.stderr}")
    return json.loads(done.stdout)


def _answer(scene: str, replaced: Mapping[str, Any], repeats: int) -> dict[str, Any]:
    # Loads the kernels and libraries; a coarse grid of the same element.
    cfmpm.run(load_scene(scene, {**replaced, "mesh.size": 80}))
    runs: list[dict[str, Any]] = []
    while len(runs) < repeats and not (runs and runs[0]["n_points"] > SINGLE_ABOVE):
        history = cfmpm.run(load_scene(scene, replaced)).history
        step = history.isel(step=0)
        runs.append(
            {
                "seconds": dict(
                    zip(history.phase.values.tolist(), step.wall_time.values.tolist(), strict=True)
                ),
                "n_points": int(step.n_points),
                "n_unknowns": int(step.n_unknowns),
                "solver": history.attrs["solver"],
            }
        )
    fastest = min(runs, key=lambda run: sum(run["seconds"].values()))
    return fastest | {"memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3}


if __name__ == "__main__":
    json.dump(_answer(*json.loads(sys.argv[1])), sys.stdout)
