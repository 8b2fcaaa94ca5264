"""Grids of growing cracks, which histories do not hold: the run is made again."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import cfmpm
from cfmpm.body.grid import Grid
from cfmpm.output.record import Record
from cfmpm.scene import Scene, load_scene
from cfmpm.state import State


@dataclass(frozen=True)
class Grown:
    """A scene whose cracks have grown.

    Attributes
    ----------
    scene : Scene
    first, last : Grid
        Before growth, and of the last state in balance.
    after : dict of int to Grid
        After so many increments, of those that were asked for.
    points : int
        Number of material points in the beginning.
    """

    scene: Scene
    first: Grid
    last: Grid
    after: Mapping[int, Grid]
    points: int


def grow(scene_file: str, replaced: Mapping[str, Any], increments: Collection[int] = ()) -> Grown:
    """Let the cracks of a scene grow, and keep grids.

    Parameters
    ----------
    scene_file : str
    replaced : mapping
        Values of the scene, by dotted keys.
    increments : collection of int
        After how many increments grids are kept.
    """
    scene = load_scene(scene_file, replaced)
    kept: dict[int, Grid] = {}
    grids: list[Grid] = []
    points: list[int] = []

    def keep(state: State, record: Record) -> None:
        grids[1:] = []
        grids.append(state.grid)
        points.append(len(state.body.points))
        done = len(record.steps) - 1
        if done in increments:
            kept[done] = state.grid

    cfmpm.run(scene, observe=keep)
    return Grown(scene, grids[0], grids[-1], kept, points[0])
