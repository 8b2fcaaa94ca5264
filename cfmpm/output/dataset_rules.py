"""What a history, fields, and a table of fields must hold to be read as such."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from cfmpm.ending import RUN_STATUS
from cfmpm.fracture.stability import STABILITY
from cfmpm.output.variables import OF_FATIGUE, SPREAD, STEP, TIP, TIP_STATUS, VARIABLES

NUMBERS, INTEGERS, TEXT = "fiu", "iu", "OUST"
Layout = Mapping[str, tuple[tuple[str, ...], str]]

_NODE, _FACE, _POINT, _CRACK = (
    ("time", "node"),
    ("time", "face"),
    ("time", "point"),
    ("crack_node",),
)
_STRESSES = ("sigma_xx", "sigma_yy", "sigma_xy", "sigma_zz")
_FIELDS: Layout = {
    **dict.fromkeys(("time", "load_factor", "crack_length"), (("time",), NUMBERS)),
    **{f"node_{axis}": (("node",), NUMBERS) for axis in "xy"},
    **{f"point_{axis}": (("point",), NUMBERS) for axis in "xy"},
    "face_nodes": (("face", "corner"), INTEGERS),
    "element": (("face",), INTEGERS),
    "region": (("face",), INTEGERS),
    "point_volume": (("point",), NUMBERS),
    "point_element": (("point",), INTEGERS),
    **{f"{name}_{axis}": (_NODE, NUMBERS) for name in ("u", "cf") for axis in "xy"},
    **dict.fromkeys((*_STRESSES, "von_mises", "energy_density"), (_FACE, NUMBERS)),
    **{f"point_{name}": (_POINT, NUMBERS) for name in (*_STRESSES, "energy_density")},
}
_OF_CRACKS: Layout = {
    "crack": (_CRACK, INTEGERS),
    "crack_x": (_CRACK, NUMBERS),
    "crack_y": (_CRACK, NUMBERS),
}
_INDEX: Layout = {
    "step": (STEP, INTEGERS),
    "load_factor": (STEP, NUMBERS),
    "crack_length": (STEP, NUMBERS),
    "file": (STEP, TEXT),
}
_HISTORY: Layout = {
    "step": (STEP, INTEGERS),
    "load_factor": (STEP, NUMBERS),
    "radius": (("radius",), NUMBERS),
    **{name: ((name,), TEXT) for name in ("tip", "boundary", "phase")},
    **{name: (dims, NUMBERS) for name, (dims, _, _) in VARIABLES.items()},
    **{f"{name}_spread": (TIP, NUMBERS) for name in SPREAD},
    "run_status": ((), INTEGERS),
    "stability": (STEP, INTEGERS),
}


def broken_rules(dataset: xr.Dataset, kind: str) -> Iterator[str]:
    """Say what is wrong with a dataset, the simplest first.

    Parameters
    ----------
    dataset : xarray.Dataset
    kind : str
        A key of `RULES`.
    """
    for name in ("config", "config_hash"):
        if not isinstance(dataset.attrs[name], str):
            yield f"its attribute {name} is no text"
    yield from RULES[kind](dataset)


def _layout(dataset: xr.Dataset, layout: Layout) -> Iterator[str]:
    for name, (dims, kinds) in layout.items():
        if name not in dataset.variables:
            yield f"it has no {name}"
            continue
        variable = dataset[name]
        # Without a crack there are no names of tips, and what is empty has no type.
        if variable.dims != dims or (variable.size and variable.dtype.kind not in kinds):
            yield f"{name} is of the wrong shape or type"


def _index(dataset: xr.Dataset) -> Iterator[str]:
    yield from _layout(dataset, _INDEX)
    yield from _in_order(dataset["step"].values)


def _in_order(steps: Any) -> Iterator[str]:
    if len(steps) == 0 or steps[0] < 1 or (np.diff(steps) <= 0).any():
        yield "its steps are not in order"


def _history(dataset: xr.Dataset) -> Iterator[str]:
    layout = dict(_HISTORY)
    if not OF_FATIGUE.keys().isdisjoint(dataset.variables):
        layout |= {name: (dims, NUMBERS) for name, (dims, _, _) in OF_FATIGUE.items()}
    yield from _layout(dataset, layout)
    yield from _in_order(dataset["step"].values)
    for name in ("tip", "boundary", "phase"):
        words = dataset[name].values.tolist()
        if not all(isinstance(word, str) for word in words) or len(set(words)) != len(words):
            yield f"the names along {name} are not names, or not different"
    for name, words in (
        ("tip_status", TIP_STATUS),
        ("run_status", RUN_STATUS),
        ("stability", STABILITY),
    ):
        values = dataset[name].values
        if not ((values >= 0) & (values < len(words))).all():
            yield f"{name} has values that mean nothing"
        if dataset[name].attrs.get("flag_meanings") != " ".join(words):
            yield f"{name} has lost what its values mean"
    attributes = dataset.attrs
    if attributes.get("run_status") != RUN_STATUS[int(dataset["run_status"])]:
        yield "its two run_status differ"
    if not isinstance(attributes.get("ending"), str):
        yield "its attribute ending is no text"
    if not np.isfinite(dataset["n_unknowns"].values).any():
        yield "it has no step that was solved"


def _fields(dataset: xr.Dataset) -> Iterator[str]:
    layout = dict(_FIELDS)
    if not _OF_CRACKS.keys().isdisjoint(dataset.variables):
        layout |= _OF_CRACKS
    yield from _layout(dataset, layout)
    faces = dataset["face_nodes"].values
    if dataset.sizes["time"] != 1 or faces.shape[1] != 3 or len(faces) == 0:
        yield "it has not one time, or no triangles"
    if not 0 <= faces.min() <= faces.max() < dataset.sizes["node"]:
        yield "face_nodes counts nodes that are not there"
    for name in ("time", *(f"{name}_{axis}" for name in ("node", "u", "cf") for axis in "xy")):
        if not np.isfinite(dataset[name].values).all():
            yield f"{name} is not finite"
    try:
        modulus = json.loads(dataset.attrs["config"])["material"]["E"]
    except (ValueError, LookupError, TypeError, RecursionError):
        modulus = None
    if not isinstance(modulus, int | float):
        yield "its attribute config has no material.E"


# By the variable that only such a dataset has.
RULES: Mapping[str, Callable[[xr.Dataset], Iterator[str]]] = {
    "domain_radius": _history,
    "face_nodes": _fields,
    "file": _index,
}
