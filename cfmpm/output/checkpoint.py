"""Checkpoint file of a run, from which it resumes with results equal to an uninterrupted run."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from cfmpm.body import body as bodies
from cfmpm.body.body import Body, Grown
from cfmpm.body.grid import Triangulation
from cfmpm.body.particle_domains import ParticleDomains, Quadrature
from cfmpm.body.points import DeformedPoints, MaterialPoints
from cfmpm.body.volume_patches import paired_triangles
from cfmpm.build import compose, materials_of
from cfmpm.equilibrium.balance import Equilibrium, FiniteEffect
from cfmpm.errors import MeshError, Problem, SceneError, SolveError
from cfmpm.fracture.fatigue import Progress
from cfmpm.fracture.growth import Decision
from cfmpm.fracture.ties import Tie
from cfmpm.mechanics import load_levels
from cfmpm.output.arrays import opened_arrays
from cfmpm.output.checkpoint_rules import Texts, require_nodes, require_sound
from cfmpm.output.files import file_named
from cfmpm.output.history import StepRecord
from cfmpm.output.record import Origin, Record
from cfmpm.output.warnings.doubt import Doubts
from cfmpm.scene import Scene, effective_config, expand
from cfmpm.state import Stage
from cfmpm.updated import reset


@dataclass(frozen=True)
class Start:
    """The start of a run, at its first step or from a checkpoint.

    Attributes
    ----------
    stage : Stage
        The stage to be solved next.
    record : Record
        The steps so far.
    """

    stage: Stage
    record: Record


# Version of the file layout.
FORMAT = 9
# Fields of `Motion` that do not follow from the grid of the reference configuration, and those of
# the points there.
MOTION = ("displacement", "triangle", "base", "smoothed")
REFERENCE = ("position", "element")
Arrays = dict[str, NDArray[Any]]


def write_checkpoint(start: Start, path: Path) -> None:
    """Write a stage and the steps before it in place, into a temporary file of `written_aside`.

    Parameters
    ----------
    start : Start
    path : Path
        An .npz file with arrays, and all else as JSON text; no pickle.
    """
    record, stage = start.record, start.stage
    body, decision = stage.body, stage.decision
    mesh = body.triangulation
    texts = {
        "format": FORMAT,
        "config": effective_config(record.scene),
        "region_names": mesh.region_names,
        "edges": list(mesh.edges),
        "cracks": list(mesh.cracks),
        "points": mesh.points,
        "uncounted": mesh.uncounted,
        "grown": asdict(body.grown),
        "fixed_loads": sorted(body.loading.fixed_names),
        "origin": asdict(record.origin),
        "notes": record.notes,
        "warnings": list(record.warnings),
        "doubts": record.doubts.listed(),
        "came_off": record.came_off,
        "seconds": [step.seconds for step in record.steps],
        "decision": None if decision is None else asdict(decision),
        "level": stage.level,
        "balance": _numbers(stage.balance),
        "resets": 0 if body.motion is None else body.motion.resets,
    }
    arrays = {
        "texts": np.array(json.dumps(texts, default=lambda value: value.tolist())),
        "mesh.nodes": mesh.nodes,
        "mesh.triangles": mesh.triangles,
        "mesh.regions": mesh.regions,
        **{f"mesh.edges.{i}": pairs for i, pairs in enumerate(mesh.edges.values())},
        **{f"mesh.cracks.{i}": pairs for i, pairs in enumerate(mesh.cracks.values())},
        **_columns("points", body.points),
        **_columns("domains", body.particle_domains),
        **_columns("quadrature", body.quadrature),
        **({} if body.patches is None else {"patches.of_triangle": body.patches.of_triangle}),
        **_columns("balance", stage.balance),
        **_columns("balance.points", None if stage.balance is None else stage.balance.points),
        **_steps(record.steps),
        **_motion(body),
    }
    with file_named(path), path.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def read_checkpoint(path: Path) -> Start:
    """Read what `write_checkpoint` wrote.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Start

    Raises
    ------
    SceneError
        If the file is not a checkpoint, or has another format.
    """
    try:
        return _start(*_contents(path))
    except SceneError:
        raise
    except _OF_DAMAGE as error:
        said = " ".join(f"{error}".split())[:200]
        raise SceneError([Problem(f"is damaged: {said}", file=str(path))]) from None


# What shows that values do not go with each other, where no rule has told it before.
_OF_DAMAGE = (
    *(ArithmeticError, AssertionError, AttributeError, LookupError, MemoryError),
    *(TypeError, ValueError, MeshError, SolveError, np.linalg.LinAlgError),
)


def _contents(path: Path) -> tuple[Arrays, dict[str, Any]]:
    """The arrays and texts of a checkpoint of this version, each of which is sound."""
    try:
        with opened_arrays(path) as file:
            arrays = {name: file[name] for name in file.names}
        data = json.loads(str(arrays.pop("texts")))
    except (OSError, ValueError, LookupError, RecursionError) as error:
        reason = f"is not a checkpoint: {getattr(error, 'strerror', None) or error}"
        raise SceneError([Problem(reason, file=str(path))]) from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        found = data.get("format") if isinstance(data, dict) else None
        reason = f"has format {found}; this version reads {FORMAT}: run the scene again"
        raise SceneError([Problem(reason, file=str(path))])
    try:
        texts = Texts.model_validate(data)
    except ValidationError as error:
        place = ".".join(map(str, error.errors()[0]["loc"]))
        raise SceneError([Problem(f"is damaged: {place}", file=str(path))]) from None
    require_sound(arrays, texts)
    return arrays, data


def _start(arrays: Arrays, texts: dict[str, Any]) -> Start:
    """The run that a checkpoint is of."""
    # Checked when it was read; a mesh file may be gone by now, since the grid is here.
    try:
        scene = Scene.model_validate(texts["config"])
    except ValidationError:
        raise ValueError("its configuration") from None
    origin = texts["origin"]
    origin["tips"] = {name: (crack, end) for name, (crack, end) in origin["tips"].items()}
    record = Record(scene, expand(scene), Origin(**origin))
    record.notes = texts["notes"]
    record.warnings = dict.fromkeys(texts["warnings"])
    record.doubts = Doubts(texts["doubts"])
    record.came_off = [np.array(centre) for centre in texts["came_off"]]
    record.steps = _read_steps(arrays, texts["seconds"])
    decision = texts["decision"]
    if decision is not None:
        for key in ("running", "tangents"):
            decision[key] = {name: np.array(vector) for name, vector in decision[key].items()}
        if decision["progress"] is not None:
            decision["progress"] = Progress(**decision["progress"])
        decision["tied"] = tuple(decision["tied"])
        decision["ties"] = tuple(Tie(**tie) for tie in decision["ties"])
        decision = Decision(**decision)
    record.decision = decision
    body, balance = _read_body(arrays, texts, record), _read_balance(arrays, texts["balance"])
    if balance is not None:
        require_nodes(arrays, len(body.grid.nodes), len(body.grid.triangles))
        effect = balance.finite_effect
        if effect is not None and len(effect.J) not in (0, len(body.grid.tips)):
            raise ValueError("finite_effect counts other tips")
    if not 0 <= texts["level"] < len(load_levels(record.full)):
        raise ValueError("level counts what is not there")
    step = len(record.steps) + 1
    return Start(Stage(record.full, body, decision, step, texts["level"], balance), record)


def _columns(
    prefix: str, table: MaterialPoints | ParticleDomains | Quadrature | Equilibrium | None
) -> Arrays:
    if table is None:
        return {}
    columns = {field.name: getattr(table, field.name) for field in fields(table)}
    return {
        f"{prefix}.{name}": column
        for name, column in columns.items()
        if isinstance(column, np.ndarray)
    }


def _numbers(balance: Equilibrium | None) -> dict[str, Any] | None:
    """The fields of an equilibrium that are not arrays."""
    if balance is None:
        return None
    values = {field.name: getattr(balance, field.name) for field in fields(balance)}
    tables = np.ndarray, MaterialPoints
    words = {name: value for name, value in values.items() if not isinstance(value, tables)}
    if balance.finite_effect is not None:
        words["finite_effect"] = asdict(balance.finite_effect)
    return words


def _read_balance(arrays: Arrays, numbers: dict[str, Any] | None) -> Equilibrium | None:
    if numbers is None:
        return None
    names = [field.name for field in fields(Equilibrium)]
    columns: dict[str, Any] = {
        name: arrays[f"balance.{name}"] for name in names if f"balance.{name}" in arrays
    }
    columns["points"] = _table(arrays, "balance.points", DeformedPoints)
    columns["residuals"] = tuple(numbers["residuals"])
    effect = numbers["finite_effect"]
    if effect is not None:
        tips = tuple(tuple(tip) for tip in effect["J"])
        columns["finite_effect"] = FiniteEffect(tuple(effect["energy"]), tips, effect["least"])
    return Equilibrium(**{**numbers, **columns})


def _table(arrays: Arrays, prefix: str, kind: Any) -> Any:
    """Read the arrays of `_columns`; None if there are none."""
    if f"{prefix}.{fields(kind)[0].name}" not in arrays:
        return None
    return kind(**{field.name: arrays[f"{prefix}.{field.name}"] for field in fields(kind)})


def _steps(steps: list[StepRecord]) -> Arrays:
    """The steps as one array for each quantity, with nan for missing values."""
    shapes = {name: np.shape(value) for step in steps for name, value in step.values.items()}
    return {
        "steps.load_factor": np.array([step.load_factor for step in steps]),
        "steps.conjugates": np.array([step.conjugates for step in steps]).reshape(-1, 3),
    } | {
        f"values.{name}": np.array(
            [step.values.get(name, np.full(shape, np.nan)) for step in steps], float
        )
        for name, shape in shapes.items()
    }


def _read_steps(arrays: Arrays, seconds: list[dict[str, float]]) -> list[StepRecord]:
    values = {
        key.removeprefix("values."): array
        for key, array in arrays.items()
        if key.startswith("values.")
    }
    return [
        StepRecord(
            float(arrays["steps.load_factor"][i]),
            {name: array[i] for name, array in values.items()},
            spent,
            tuple(arrays["steps.conjugates"][i].tolist()),
        )
        for i, spent in enumerate(seconds)
    ]


def _motion(body: Body) -> Arrays:
    """The data of a body's motion that do not follow from its reference configuration."""
    if body.motion is None:
        return {}
    kept = {f"motion.{name}": getattr(body.motion, name) for name in (*MOTION, *REFERENCE)}
    return {"grid.nodes": body.grid.nodes, **kept}


def _read_body(arrays: Arrays, texts: dict[str, Any], record: Record) -> Body:
    mesh = Triangulation(
        nodes=arrays["mesh.nodes"],
        triangles=arrays["mesh.triangles"],
        regions=arrays["mesh.regions"],
        region_names=tuple(texts["region_names"]),
        edges={name: arrays[f"mesh.edges.{i}"] for i, name in enumerate(texts["edges"])},
        cracks={name: arrays[f"mesh.cracks.{i}"] for i, name in enumerate(texts["cracks"])},
        points=texts["points"],
        uncounted=texts["uncounted"],
    )
    names = {place: name for name, place in record.origin.tips.items()}
    grid = bodies.named_grid(mesh, record.full.mesh.element, names)
    points = _table(arrays, "points", MaterialPoints)
    materials = materials_of(record.full, mesh.region_names)
    quadrature = _table(arrays, "quadrature", Quadrature)
    paired = None
    if "patches.of_triangle" in arrays:
        kept = arrays["patches.of_triangle"][: len(mesh.triangles)]
        paired = paired_triangles(grid, kept)
    if record.full.formulation == "updated":
        first = replace(points, **{name: arrays[f"motion.{name}"] for name in REFERENCE})
        grown, fixed = Grown(**texts["grown"]), texts["fixed_loads"]
        whole = compose(
            record.full, materials, mesh, grid, first, grown=grown, fixed=fixed, paired=paired
        )
        body = reset.begin(whole, record.full)
        require_nodes(arrays, len(body.grid.nodes), len(body.grid.triangles))
        state = {name: arrays[f"motion.{name}"] for name in MOTION} | {"resets": texts["resets"]}
        return reset.restore(body, arrays["grid.nodes"], points, quadrature, state)
    return compose(
        record.full,
        materials,
        mesh,
        grid,
        points,
        _table(arrays, "domains", ParticleDomains),
        quadrature,
        Grown(**texts["grown"]),
        texts["fixed_loads"],
        paired,
    )
