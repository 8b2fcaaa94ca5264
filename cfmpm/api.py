"""What Python users call: ``cfmpm.run(scene)`` and what it returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import cfmpm.accessor  # noqa: F401  (registers the accessor of histories)
from cfmpm import simulation, state
from cfmpm.output.checkpoint import Start
from cfmpm.output.record import Record
from cfmpm.output.run_writer import write_result
from cfmpm.scene import Scene
from cfmpm.state import State


@dataclass(frozen=True, repr=False)
class Result(state.Result):
    """Result of `run`: the history and the last state of equilibrium, which it can write."""

    def write(self, folder: str | Path, *, overwrite: bool = False) -> list[Path]:
        """Write the files that ``cfmpm run`` writes at the end of a run.

        Parameters
        ----------
        folder : str or Path
            Made if needed. An earlier result there is replaced, with its figures and exports.
        overwrite : bool
            Whether to replace also an interrupted run that could be resumed.

        Returns
        -------
        list of Path
            history.nc and, where the scene has ``output.fields``, fields.nc. The fields of each
            step (``output.every``) are only written by the command, during a run.

        Raises
        ------
        SceneError
            If another run is writing there, or if there is a run that could be resumed.
        OSError
            If the folder cannot be written.
        """
        return write_result(self, Path(folder), overwrite=overwrite)


def run(
    scene: Scene,
    announce: Callable[[str], None] = lambda phase: None,
    observe: Callable[[State, Record], None] = lambda state, record: None,
    start: Start | None = None,
) -> Result:
    """Solve a scene.

    Parameters
    ----------
    scene : Scene
    announce : callable, optional
        Called with the name of each phase (`state.PHASES`) as it begins.
    observe : callable, optional
        Called with each state of equilibrium and the record so far.
    start : Start, optional
        Start from the checkpoint of an interrupted run of the same scene; default: the first step.

    Returns
    -------
    Result

    Raises
    ------
    TypeError
        If the scene is none, such as its file or a dictionary.
    SceneError
        If the scene is invalid on its grid.
    MeshError
        If no grid could be made.
    SolveError
        If no equilibrium is found.

    Notes
    -----
    Results are equal bit by bit for any number of threads: kernels run serially, and dense linear
    algebra uses one thread (`threads`).
    """
    if not isinstance(scene, Scene):
        way = "scene_from_dict" if isinstance(scene, Mapping) else "load_scene"
        raise TypeError(
            f"cfmpm.run needs a Scene, not {type(scene).__name__}: "
            f"cfmpm.run(cfmpm.{way}(...)) reads and checks one"
        )
    return Result(**vars(simulation.run(scene, announce, observe, start)))
