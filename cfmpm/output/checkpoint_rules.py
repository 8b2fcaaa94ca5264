"""What the arrays and texts of a checkpoint must be, so that no kernel reads beyond an array."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from cfmpm.output.variables import OF_FATIGUE, VARIABLES

# Of each array its kind, its shape and, of indices, what they count. A letter stands for a size:
# n nodes of the triangulation, m triangles, r materials, p points, v corners of domains,
# q quadrature points, s points of a balance, d nodes and i triangles of the grid it was solved on.
_FLOAT, _INDEX, _FLAG = "f", "iu", "b"
_TABLES: dict[str, tuple[str, tuple[str | int, ...], str]] = {
    "mesh.nodes": (_FLOAT, ("n", 2), ""),
    "mesh.triangles": (_INDEX, ("m", 3), "n"),
    "mesh.regions": (_INDEX, ("m",), "r"),
    "patches.of_triangle": (_INDEX, ("i",), "i"),
    "points.position": (_FLOAT, ("p", 2), ""),
    "points.volume": (_FLOAT, ("p",), ""),
    "points.element": (_INDEX, ("p",), "t"),
    "points.material": (_INDEX, ("p",), "r"),
    "domains.anchors": (_FLOAT, ("p", 2), ""),
    "domains.vertices": (_FLOAT, ("v", 2), ""),
    "domains.offsets": (_INDEX, ("p + 1",), "v + 1"),
    "quadrature.owner": (_INDEX, ("q",), "p"),
    "quadrature.element": (_INDEX, ("q",), "t"),
    "quadrature.position": (_FLOAT, ("q", 2), ""),
    "quadrature.volume": (_FLOAT, ("q",), ""),
    "quadrature.material": (_INDEX, ("q",), "r"),
    "balance.displacement": (_FLOAT, ("d", 2), ""),
    "balance.internal_force": (_FLOAT, ("d", 2), ""),
    "balance.contact_force": (_FLOAT, ("d", 2), ""),
    "balance.points.position": (_FLOAT, ("s", 2), ""),
    "balance.points.volume": (_FLOAT, ("s",), ""),
    "balance.points.element": (_INDEX, ("s",), "t"),
    "balance.points.material": (_INDEX, ("s",), "r"),
    "balance.points.displacement_gradient": (_FLOAT, ("s", 2, 2), ""),
    "balance.points.stress": (_FLOAT, ("s", 3), ""),
    "balance.points.energy": (_FLOAT, ("s",), ""),
    "balance.points.internal_variables": (_FLOAT, ("s", "h"), ""),
    "grid.nodes": (_FLOAT, ("g", 2), ""),
    "motion.position": (_FLOAT, ("p", 2), ""),
    "motion.element": (_INDEX, ("p",), "m"),
    "motion.displacement": (_FLOAT, ("l", 2), ""),
    "motion.triangle": (_INDEX, ("l",), "t"),
    "motion.base": (_FLOAT, ("b", 2, 2), ""),
    "motion.smoothed": (_FLAG, ("l",), ""),
    "steps.load_factor": (_FLOAT, ("step",), ""),
    "steps.conjugates": (_FLOAT, ("step", 3), ""),
}
# Values of steps are missing where there are none.
_MAY_BE_NAN = ("steps.", "values.")


class _Words(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _GrownWords(_Words):
    quality: float
    segments: dict[str, float]
    deviations: dict[str, float]
    fracture_energy: float


class _OriginWords(_Words):
    tips: dict[str, tuple[str, int]]
    boundaries: list[str]
    radii: list[float]


class _ProgressWords(_Words):
    cycles: float
    ranges: dict[str, float]
    rates: dict[str, float]
    pending: dict[str, float]
    leader: str
    driving: dict[str, float]


class _TieWords(_Words):
    grown: dict[str, float]
    excess: dict[str, float]
    error: dict[str, float]
    compared: int


class _DecisionWords(_Words):
    load_factor: float
    running: dict[str, tuple[float, float]]
    tangents: dict[str, tuple[float, float]]
    progress: _ProgressWords | None
    tied: list[str]
    ties: list[_TieWords]


class _EffectWords(_Words):
    energy: tuple[float, float]
    J: list[tuple[float, float]]
    least: float


class _BalanceWords(_Words):
    contact_pairs: int
    residual_norm: float
    residual_floor: float
    solver: str
    n_unknowns: int
    iterations: int
    load_factor: float
    finite: bool
    parts: None
    finite_effect: _EffectWords | None
    external_work: float
    newton_iterations: int
    substeps: int
    residuals: list[float]
    unstable_points: float
    unstable_from: float
    stopped: str
    is_last: bool


class Texts(_Words):
    """What of a checkpoint is no array; the fields are those of `write_checkpoint`."""

    format: int
    config: dict[str, Any]
    region_names: list[str]
    edges: list[str]
    cracks: list[str]
    points: dict[str, int]
    uncounted: dict[str, float]
    grown: _GrownWords
    fixed_loads: list[str]
    origin: _OriginWords
    notes: dict[str, Any]
    warnings: list[str]
    doubts: list[tuple[str, str, float, list[int]]]
    came_off: list[list[Any]]
    seconds: list[dict[str, float]]
    decision: _DecisionWords | None
    level: int
    balance: _BalanceWords | None
    resets: int


def require_sound(arrays: Mapping[str, NDArray[Any]], texts: Texts) -> None:
    """Refuse arrays that do not go with each other.

    Parameters
    ----------
    arrays : mapping of str to array
        Those of a checkpoint.
    texts : Texts

    Raises
    ------
    ValueError
        With the first that is wrong.
    """
    sizes = {"r": len(texts.region_names), "step": len(texts.seconds)}
    sizes |= {"tip": len(texts.origin.tips), "radius": len(texts.origin.radii)}
    sizes["boundary"] = len(texts.origin.boundaries)
    for name, (kind, shape, counted) in _layout(arrays, texts):
        if name not in arrays:
            raise ValueError(f"{name} is missing")
        array = arrays[name]
        if array.dtype.kind not in kind or not _fits(array.shape, shape, sizes):
            raise ValueError(f"{name} has a wrong shape or type")
        if kind == _FLOAT and not name.startswith(_MAY_BE_NAN) and not np.isfinite(array).all():
            raise ValueError(f"{name} is not finite")
        if "grid.nodes" not in arrays and "m" in sizes:
            sizes["t"] = sizes["m"]  # a grid that is never reset is the triangulation
        most = _size(counted, sizes)
        if most is not None:
            _require_indices(name, array, most)
    if "domains.offsets" in arrays:
        offsets = arrays["domains.offsets"]
        if offsets[0] != 0 or offsets[-1] != sizes["v"] or (np.diff(offsets) < 0).any():
            raise ValueError("domains.offsets are not in order")
    nodes = arrays["mesh.nodes"]
    a, b, c = (nodes[arrays["mesh.triangles"][:, k]] for k in range(3))
    (x, y), (z, w) = (b - a).T, (c - a).T
    if not (x * w - y * z > 0.0).all() or (arrays["points.volume"] < 0.0).any():
        raise ValueError("triangles or points without an area")
    if not all(0 <= node < len(nodes) for node in texts.points.values()):
        raise ValueError("points count what is not there")


def require_nodes(arrays: Mapping[str, NDArray[Any]], nodes: int, triangles: int) -> None:
    """Refuse values of another grid than one with so many nodes and triangles.

    Raises
    ------
    ValueError
    """
    for name in ("balance.displacement", "grid.nodes"):
        if name in arrays and len(arrays[name]) != nodes:
            raise ValueError(f"{name} does not go with the grid")
    for name, (_, _, counted) in _TABLES.items():
        if counted == "t" and name in arrays:
            _require_indices(name, arrays[name], triangles)


def _require_indices(name: str, array: NDArray[Any], most: int) -> None:
    if array.size and not 0 <= array.min() <= array.max() < most:
        raise ValueError(f"{name} counts what is not there")


def _layout(
    arrays: Mapping[str, NDArray[Any]], texts: Texts
) -> Iterator[tuple[str, tuple[str, Sequence[str | int], str]]]:
    """The layout of all arrays that must be there, and of those that may."""
    always = ("mesh.", "points.", "steps.")
    for name, layout in _TABLES.items():
        table = name.rpartition(".")[0]
        of_balance = table.startswith("balance") and texts.balance is not None
        begun = any(other.rpartition(".")[0] == table for other in arrays)
        if name.startswith(always) or of_balance or begun:
            yield name, layout
    for what, names in (("edges", texts.edges), ("cracks", texts.cracks)):
        for i in range(len(names)):
            yield f"mesh.{what}.{i}", (_INDEX, (f"{what}{i}", 2), "n")
    known = VARIABLES | OF_FATIGUE
    for name in arrays:
        if name.startswith("values."):
            variable = name.removeprefix("values.")
            if variable not in known:
                raise ValueError(f"{name} is no variable of a history")
            yield name, (_FLOAT, known[variable][0], "")


def _fits(shape: tuple[int, ...], wanted: Sequence[str | int], sizes: dict[str, int]) -> bool:
    """Whether a shape is as wanted; the first array with a letter sets its size."""
    if len(shape) != len(wanted):
        return False
    for size, want in zip(shape, wanted, strict=True):
        known = want if isinstance(want, int) else _size(want, sizes)
        if known is None:
            sizes[str(want)] = size
        elif size != known:
            return False
    return True


def _size(text: str, sizes: Mapping[str, int]) -> int | None:
    letter, plus, more = text.partition(" + ")
    return None if letter not in sizes else sizes[letter] + (int(more) if plus else 0)
