"""What Python users call: ``cfmpm.run(scene)`` and what it returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cfmpm.accessor  # noqa: F401  (who has a history has its accessor)
from cfmpm import simulation, state
from cfmpm.output.checkpoint import Start
from cfmpm.output.record import Record
from cfmpm.output.run_writer import write_result
from cfmpm.scene import Scene
from cfmpm.state import State


@dataclass(frozen=True)
class Result(state.Result):
    """What `run` returns: the history of a run and its last state, which it can write."""

    def write(self, folder: str | Path, *, overwrite: bool = False) -> list[Path]:
        """Write the files that ``cfmpm run`` leaves in its folder at the end of a run.

        Parameters
        ----------
        folder : str or Path
            Made if needed. An earlier result there is replaced, with what was drawn and exported.
        overwrite : bool
            Whether also one that was broken off and could still go on.

        Returns
        -------
        list of Path
            history.nc and, where the scene has ``output.fields``, fields.nc. The fields of each
            step (``output.every``) are written only while the command runs.

        Raises
        ------
        SceneError
            Where a run is writing there, or one is that could still go on.
        OSError
            Where the folder cannot be written.
        """
        return write_result(self, Path(folder), overwrite=overwrite)


def run(
    scene: Scene,
    announce: Callable[[str], None] = lambda phase: None,
    observe: Callable[[State, Record], None] = lambda state, record: None,
    start: Start | None = None,
) -> Result:
    """Solve a scene; see `simulation.run`, whose parameters and errors these are.

    Parameters
    ----------
    scene : Scene
    announce : callable, optional
        Called with the name of each phase as it begins.
    observe : callable, optional
        Called with each state of balance and the record so far.
    start : Start, optional
        Of a run of the same scene that was broken off; default: the scene's beginning.

    Returns
    -------
    Result
    """
    return Result(**vars(simulation.run(scene, announce, observe, start)))
