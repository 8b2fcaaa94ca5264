"""A resumed run gives the same results as an uninterrupted one."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from histories import same
from scipy.sparse import issparse

from cfmpm import simulation, steps
from cfmpm.clock import Clock
from cfmpm.errors import SceneError
from cfmpm.output.checkpoint import Start, read_checkpoint, write_checkpoint
from cfmpm.output.files import written_aside
from cfmpm.output.record import Record
from cfmpm.output.run_folder import CHECKPOINT
from cfmpm.output.run_writer import SHARE, RunWriter
from cfmpm.scene import Scene, scene_from_dict
from cfmpm.state import Result, State


def beginning(scene: Scene) -> Start:
    stage = steps.begin(scene)
    return Start(stage, Record.of(scene, stage))


# Two cracks, of which the ends of one are both tips; a support that is a point; a region.
GROWTH = {"control": "crack", "increments": 9}
SCENE: dict[str, Any] = {
    "name": "plate",
    "geometry": {
        "outline": [[0, 0], [20, 0], [20, 12], [0, 12]],
        "holes": [{"name": "hole", "circle": {"centre": [13, 8], "radius": 1.5}}],
        "cracks": [
            {"name": "edge", "points": [[0, 6], [3, 6]], "uncounted": 1},
            {"name": "inner", "points": [[6, 4.5], [8, 5]]},
        ],
        "regions": [
            {
                "name": "inlay",
                "material": {"E": 70e3, "nu": 0.2, "g_c": 0.5},
                "circle": {"centre": [16, 3], "radius": 1},
            }
        ],
    },
    "material": {"E": 210e3, "nu": 0.3, "g_c": 1.0},
    "loads": [
        {"edge": "edge_1", "displacement": {"y": 0}},
        {"point": [0, 0], "displacement": {"x": 0}},
        {"edge": "edge_3", "traction": [0, 10]},
    ],
    "mesh": {"element": "T3", "size": 1.5},
    "growth": GROWTH,
}
VARIANTS: dict[str, dict[str, Any]] = {
    "T3": {},
    "patches": {"material": {"E": 210e3, "nu": 0.49, "g_c": 1.0}},
    "T6": {"mesh": {"element": "T6", "size": 3}},
    "paper": {"growth": {**GROWTH, "transfer": "paper", "order": 1}},
    "refined": {"fracture": {"refine": 0.4, "radii": 2}},
    "finite": {
        "kinematics": "finite",
        "load_steps": [0.5, 1.0, 1.5],
        "loads": [
            {"edge": "edge_1", "displacement": {"y": 0}},
            {"point": [0, 0], "displacement": {"x": 0}},
            {"edge": "edge_3", "displacement": {"y": 0.04}},
        ],
        "growth": {"direction": "cf", "increments": 7},
    },
    "fatigue": {
        "material": {"E": 210e3, "nu": 0.3},
        "growth": {"control": "fatigue", "increments": 9},
        "fatigue": {"C": 1e-12, "m": 3},
    },
}
# A grid that is reset; with pieces whose state is their own from the third step on.
RESET: dict[str, Any] = {
    "name": "plate",
    "family": {"kind": "single_edge", "width": 500, "height": 1000, "crack_length": 100},
    "material": {"E": 210e3, "nu": 0.3, "law": "ciarlet"},
    "kinematics": "finite",
    "formulation": "updated",
    "loads": [
        {"edge": "bottom", "displacement": {"y": -100}},
        {"edge": "top", "displacement": {"y": 100}},
        {"body_force": [0, -1]},
    ],
    "load_steps": [0.3, 0.6, 0.9, 1.0, 0.99, 0.95, 0.9],
    "mesh": {"element": "T3", "size": 60, "grading": {"tip_size": 12}},
}
MODES: dict[str, dict[str, Any]] = {
    "fixed": {"grid": "fixed", "integration": "domains", "ghost": 0.1},
    "points": {"grid": "following", "smooth_below": 1.0},
    "domains": {"grid": "following", "integration": "domains", "smooth_below": 0.7},
}
# The same with a crack that grows, after a load step without growth.
GROWING: dict[str, dict[str, Any]] = {
    "fixed, growing": {"grid": "fixed"},
    "following, growing": {"grid": "following", "smooth_below": 0.7},
    "domains, growing": MODES["domains"],
    "fixed, patches, growing": {"grid": "fixed"},
}
GROWN = {
    **RESET,
    "material": {**RESET["material"], "g_c": 6e4},
    "loads": [
        {"edge": "bottom", "displacement": {"y": -20}},
        {"edge": "top", "displacement": {"y": 20}},
    ],
    "load_steps": [0.5, 1.0],
    "mesh": {"element": "T3", "size": 60, "grading": "uniform"},
    "growth": {"direction": "cf", "criterion": "cf_norm", "increments": 7},
}


class StopHereError(Exception):
    """Interrupts a run."""


def scene_of(variant: str) -> Scene:
    if variant in GROWING:
        mode = GROWING[variant]
        transfer = "domains" if "integration" in mode else "paper"
        growth = GROWN["growth"] | {"transfer": transfer}
        nu = {"nu": 0.47} if "patches" in variant else {}
        material = {"material": GROWN["material"] | nu}
        return scene_from_dict(GROWN | material | {"updated": mode, "growth": growth})
    mode = MODES.get(variant)
    return scene_from_dict(RESET | {"updated": mode} if mode else SCENE | VARIANTS[variant])


@cache
def in_one_go(variant: str) -> Result:
    return simulation.run(scene_of(variant))


@pytest.mark.slow
@pytest.mark.parametrize("variant", [*VARIANTS, *MODES, *GROWING])
@pytest.mark.parametrize("steps", [1, 2, 6])
def test_the_end_is_that_of_a_run_in_one_go(tmp_path: Path, variant: str, steps: int) -> None:
    scene = scene_of(variant)
    writer = RunWriter(tmp_path)

    def observe(state: State, record: Record) -> None:
        writer.observe(state, record)
        if len(record.steps) == steps:
            raise StopHereError

    with pytest.raises(StopHereError):
        simulation.run(scene, observe=observe)
    writer.write("stopped")
    start = read_checkpoint(tmp_path / CHECKPOINT)
    assert len(start.record.steps) == steps - 1
    whole, resumed = in_one_go(variant), simulation.run(scene, start=start)
    assert whole.history.sizes["step"] > 6
    assert variant not in MODES or whole.history["grid_resets"][-1] > 1
    same(whole.history.copy(), resumed.history)
    np.testing.assert_array_equal(whole.displacement, resumed.displacement)
    np.testing.assert_array_equal(whole.points.stress, resumed.points.stress)
    np.testing.assert_array_equal(whole.points.element, resumed.points.element)


@pytest.mark.slow
def test_what_is_kept_does_not_depend_on_when(tmp_path: Path) -> None:
    """A checkpoint of a resumed run is that of the first run."""
    scene = scene_from_dict(SCENE)
    files = []

    def keep(state: State, record: Record) -> None:
        writer.observe(state, record)
        if len(record.steps) in (4, 7):
            writer.write("")
            files.append((tmp_path / CHECKPOINT).read_bytes())

    writer = RunWriter(tmp_path)
    simulation.run(scene, observe=keep)
    (tmp_path / CHECKPOINT).write_bytes(files[0])
    start = read_checkpoint(tmp_path / CHECKPOINT)
    writer = RunWriter(tmp_path, start)
    simulation.run(scene, observe=keep, start=start)
    first, second = (np.load(_saved(tmp_path, content)) for content in files[1::2])
    assert sorted(first) == sorted(second)
    for name in first:
        if name != "texts":  # which holds wall times
            np.testing.assert_array_equal(first[name], second[name], err_msg=name)


def _saved(folder: Path, content: bytes) -> Path:
    path = folder / f"{len(list(folder.iterdir()))}.npz"
    path.write_bytes(content)
    return path


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / CHECKPOINT
    for content in (b"", b"PK\x03\x04 no archive"):
        path.write_bytes(content)
        with pytest.raises(SceneError, match="checkpoint"):
            read_checkpoint(path)
    np.savez(path, nothing=np.zeros(1))
    with pytest.raises(SceneError, match="is not a checkpoint"):
        read_checkpoint(path)


def test_another_format_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / CHECKPOINT
    start = beginning(scene_from_dict(SCENE))
    monkeypatch.setattr("cfmpm.output.checkpoint.FORMAT", 0)
    write_checkpoint(start, path)
    monkeypatch.undo()
    with pytest.raises(SceneError, match="format 0"):
        read_checkpoint(path)


def test_the_effect_of_finite_deformation_is_kept_with_its_tips(tmp_path: Path) -> None:
    """Of a run for which `auto` chose finite deformation; other tips than the grid has are none."""
    path, clock = tmp_path / CHECKPOINT, Clock(lambda phase: None)
    pulled = [{"edge": "edge_1", "displacement": {"y": 0}}]
    pulled += [{"point": [0, 0], "displacement": {"x": 0}}]
    pulled += [{"edge": "edge_3", "traction": [0, 3000]}]
    scene = scene_from_dict(SCENE | {"growth": None, "load_steps": 2, "loads": pulled})
    start = beginning(scene)
    at = steps.locate(start.stage, clock)
    balance = steps.solve(at, None, clock)
    state = steps.evaluate(at, balance, clock)
    start.record.add(state, clock.lap())
    following = steps.advance(steps.reset(at, balance, clock), state)
    write_checkpoint(Start(following, start.record), path)
    read = read_checkpoint(path).stage.balance
    assert read is not None
    assert read.finite
    effect = balance.finite_effect
    assert effect is not None
    assert read.finite_effect == effect
    assert len(effect.J) == len(at.body.grid.tips) == 3
    fewer = replace(balance, finite_effect=replace(effect, J=effect.J[:2]))
    write_checkpoint(Start(replace(following, balance=fewer), start.record), path)
    with pytest.raises(SceneError, match="finite_effect"):
        read_checkpoint(path)


def test_a_half_written_checkpoint_leaves_the_last_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / CHECKPOINT
    start = beginning(scene_from_dict(SCENE))
    write_checkpoint(start, path)
    before = path.read_bytes()

    def fail(file: Any, **arrays: Any) -> None:
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", fail)
    with pytest.raises(OSError, match="No space") as caught, written_aside(path) as aside:
        write_checkpoint(start, aside)
    assert caught.value.filename == str(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
def test_writing_takes_a_stated_part_of_the_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a clock that advances by one second per write and two per step."""
    now, written = [0.0], []

    def write(*arguments: object) -> None:
        now[0] += 1.0
        written.append(now[0])

    monkeypatch.setattr("cfmpm.output.run_writer.write_checkpoint", write)
    monkeypatch.setattr("cfmpm.output.run_writer.time.monotonic", lambda: now[0])
    writer = RunWriter(tmp_path)

    def observe(state: State, record: Record) -> None:
        now[0] += 2.0
        writer.observe(state, record)

    simulation.run(
        scene_from_dict(SCENE | {"growth": GROWTH | {"increments": 30}}), observe=observe
    )
    steps = (now[0] - len(written)) / 2.0
    assert steps > 20
    assert written[0] == 3.0  # at once after the first step
    assert len(written) == 1 + (now[0] - written[0]) * SHARE // 1.0


# Of a state that is solved again: its stresses, and what goes with them.
SOLVED_AGAIN = {
    f"stage.body.{points}.{name}: other numbers"
    for points in ("points", "integration")
    for name in ("displacement_gradient", "stress", "energy")
}


def differences(found: Any, expected: Any, where: str = "") -> Iterator[str]:
    """List all differences between two values, bit by bit."""
    if type(found) is not type(expected):
        yield f"{where}: {type(found).__name__} is no {type(expected).__name__}"
    elif is_dataclass(expected):
        for field in fields(expected):
            parts = getattr(found, field.name), getattr(expected, field.name)
            yield from differences(*parts, f"{where}.{field.name}")
    elif isinstance(expected, dict):
        if list(found) != list(expected):
            yield f"{where}: {list(found)} are not {list(expected)}"
        for key in found.keys() & expected.keys():
            yield from differences(found[key], expected[key], f"{where}[{key!r}]")
    elif isinstance(expected, (list, tuple)):
        if len(found) != len(expected):
            yield f"{where}: {len(found)} entries, not {len(expected)}"
        for i, pair in enumerate(zip(found, expected, strict=False)):
            yield from differences(*pair, f"{where}[{i}]")
    elif isinstance(expected, np.ndarray):
        if not np.array_equal(found, expected, equal_nan=expected.dtype.kind == "f"):
            yield f"{where}: other numbers"
    elif issparse(expected):
        if found.shape != expected.shape or (found != expected).nnz:
            yield f"{where}: other numbers"
    elif found != expected and not (found != found and expected != expected):
        yield f"{where}: {found!r} is not {expected!r}"


@pytest.mark.parametrize("variant", [*VARIANTS, *MODES, *GROWING])
def test_everything_that_a_run_goes_on_from_comes_back(tmp_path: Path, variant: str) -> None:
    """Each field of body, equilibrium, decision and record."""
    starts: list[Start] = []

    def observe(state: State, record: Record) -> None:
        if len(record.steps) == 6:
            before = copy.copy(record)
            before.steps = record.steps[:-1]
            starts.append(Start(state.stage, before))
            write_checkpoint(starts[0], tmp_path / CHECKPOINT)
            raise StopHereError

    with pytest.raises(StopHereError):
        simulation.run(scene_of(variant), observe=observe)
    (written,), read = starts, read_checkpoint(tmp_path / CHECKPOINT)
    # What follows from the rest is found again.
    stage = replace(written.stage, gradients=None)
    assert set(differences(read.stage, stage, "stage")) <= SOLVED_AGAIN
    assert list(differences(read.record.decision, stage.decision, "record.decision")) == []
    assert len(read.record.steps) == 5
    kept = ("scene", "full", "origin", "notes", "warnings", "holes")
    for name in kept:
        pair = getattr(read.record, name), getattr(written.record, name)
        assert list(differences(*pair, f"record.{name}")) == []
    for i, (found, step) in enumerate(zip(read.record.steps, written.record.steps, strict=True)):
        values = {name: np.asarray(found.values[name], float) for name in step.values}
        expected = {name: np.asarray(value, float) for name, value in step.values.items()}
        assert list(differences(values, expected, f"steps[{i}]")) == []
        rest = [
            (one.load_factor, dict(one.seconds), tuple(map(float, one.conjugates)))
            for one in (found, step)
        ]
        assert list(differences(*rest, f"steps[{i}]")) == []
