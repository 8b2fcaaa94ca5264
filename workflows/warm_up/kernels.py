"""Compile the kernels that every job needs, for Numba to find in its cache."""

from __future__ import annotations

from pathlib import Path

import cfmpm
from cfmpm._jit import cache_folder
from cfmpm.output.files import written_aside
from cfmpm.scene import scene_from_dict


def compile_kernels(stamp: str | Path) -> None:
    """Run a small scene with each element.

    Parameters
    ----------
    stamp : Path
        Written at the end; holds the name of the cache folder.
    """
    for element in ("T3", "T6"):
        scene = {
            "name": "warm_up",
            "family": {
                "kind": "single_edge",
                "width": 50,
                "height": 100,
                "crack_length": 10,
                "traction": 1,
            },
            "material": {"E": 210e3, "nu": 0.3},
            "mesh": {"element": element, "size": 10, "grading": "uniform"},
        }
        cfmpm.run(scene_from_dict(scene))
    with written_aside(Path(stamp)) as aside:
        aside.write_text(f"{cache_folder().name}\n", encoding="utf-8")
