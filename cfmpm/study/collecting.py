"""The members of a study as one labelled dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cfmpm.ending import RUN_STATUS
from cfmpm.errors import Problem, SceneError
from cfmpm.output.provenance import origin
from cfmpm.output.variables import TIP_STATUS, VARIABLES
from cfmpm.study import layout
from cfmpm.study.fracture_load import fracture_load_factor
from cfmpm.study.member import Outcome
from cfmpm.study.reading import Member, Plan, program_hash

Values = NDArray[Any]
# At steps with the last position only, tips and body were not evaluated.
NO_STATUS = -1
# Variables whose values are indices of words.
STATUS_WORDS = {"tip_status": TIP_STATUS, "run_status": RUN_STATUS}


def collect(plan: Plan, outcomes: Mapping[str, Outcome]) -> xr.Dataset:
    """Collect outcomes in a dataset with a dimension for each parameter.

    Parameters
    ----------
    plan : Plan
    outcomes : mapping of str to Outcome
        By the keys of the members; missing ones have status ``not_run``.

    Returns
    -------
    xarray.Dataset
        The quantities of a history, and further measured ones, over the parameters, tips, radii and
        boundaries. With growth, or if any member has several steps, also over the steps, padded
        with nan; then ``final_<name>`` is the last value of each. Failed members have nan, or the
        steps before they failed.

    Raises
    ------
    SceneError
        If a measure gives a quantity the name of a parameter.
    """
    found = [outcomes.get(member.key) for member in plan.members]
    growing = any(member.scene.growth is not None for member in plan.members)
    labels = {
        name: _labels([one.labels.get(name, []) for one in found if one is not None])
        for name in ("tip", "boundary")
    }
    data = _stacked(found, labels)
    if data.sizes.get("step") == 1 and not growing:
        data = data.isel(step=0, drop=True)
    radii = {tuple(one.labels["radius"]) for one in found if one is not None and one.labels}
    if len(radii) == 1:
        data = data.assign_coords(
            radius=("radius", list(*radii), {"units": "mm", "long_name": "domain radius"})
        )
    data = data.assign(_of_members(plan, found))
    if "step" in data.dims:
        data = data.assign(_from_steps(data))
    return _unfolded(plan, data).assign_attrs(_attributes(plan))


def _labels(lists: Sequence[Sequence[str]]) -> list[str]:
    """All names, in the order in which they first appear."""
    return list(dict.fromkeys(name for names in lists for name in names))


def _stacked(found: Sequence[Outcome | None], labels: Mapping[str, list[str]]) -> xr.Dataset:
    """Quantities of all members along one dimension, ``member``."""
    solved = [(i, one) for i, one in enumerate(found) if one is not None and one.quantities]
    meanings: dict[str, tuple[tuple[str, ...], np.dtype[Any], dict[str, Any]]] = {}
    sizes = {name: len(names) for name, names in labels.items()}
    for _, one in solved:
        for name, (dims, values, attributes) in one.quantities.items():
            meanings.setdefault(name, (dims, values.dtype, attributes))
            for dim, size in zip(dims, values.shape, strict=True):
                if dim not in labels:
                    sizes[dim] = max(size, sizes.get(dim, 0))
    rows = [
        (i, one, {dim: [names.index(n) for n in one.labels[dim]] for dim, names in labels.items()})
        for i, one in solved
    ]
    variables = {}
    for name, (dims, dtype, attributes) in meanings.items():
        whole = np.full(
            (len(found), *(sizes[dim] for dim in dims)), _missing(name, dtype), dtype=dtype
        )
        for i, one, places in rows:
            if name in one.quantities:
                values = one.quantities[name][1]
                at = [
                    places.get(dim, list(range(size)))
                    for dim, size in zip(dims, values.shape, strict=True)
                ]
                whole[np.ix_([i], *at)] = values
        variables[name] = (("member", *dims), whole, _with_missing(name, attributes))
    coords = {
        name: (name, np.array(names, dtype=object), {"long_name": meaning})
        for (name, names), meaning in zip(labels.items(), ("crack tip", "loaded part"), strict=True)
        if names
    }
    if "step" in sizes:
        steps = np.arange(1, sizes["step"] + 1)
        coords["step"] = ("step", steps, {"long_name": "load or growth step"})
    for dim in sorted(sizes.keys() - {*layout.DIMENSIONS}):
        # A dimension of a measure, if its labels are the same in all members.
        named = [one.labels[dim] for _, one in solved if dim in one.labels]
        if named and all(one == named[0] for one in named):
            coords[dim] = (dim, np.array(named[0]), {})
    return xr.Dataset(variables, coords)


def _missing(name: str, dtype: np.dtype[Any]) -> float:
    if name in STATUS_WORDS:
        return NO_STATUS
    return np.nan if dtype.kind == "f" else 0


def _with_missing(name: str, attributes: Mapping[str, Any]) -> dict[str, Any]:
    if name not in STATUS_WORDS:
        return dict(attributes)
    words = STATUS_WORDS[name]
    return {
        **attributes,
        "flag_values": np.arange(NO_STATUS, len(words), dtype=np.int8),
        "flag_meanings": " ".join(("none", *words)),
    }


def _of_members(plan: Plan, found: Sequence[Outcome | None]) -> dict[str, Any]:
    """Status, reason and times of each member."""
    texts = {
        name: ["" if one is None else one.texts.get(name, "") for one in found]
        for name in ("ending", "warnings", "solver")
    }
    status = ["not_run" if one is None else one.status for one in found]
    columns: dict[str, Any] = {
        "status": np.array([layout.STATUS.index(word) for word in status], np.int8),
        "reason": ["" if one is None else one.reason for one in found],
        **texts,
        "member_key": [member.key for member in plan.members],
        "fracture_load_factor": np.array(
            [
                np.nan if one is None else _fracture_load_factor(member, one)
                for member, one in zip(plan.members, found, strict=True)
            ]
        ),
        "run_time": np.array([np.nan if one is None else one.seconds for one in found]),
        "cpu_time": np.array([np.nan if one is None else one.cpu_seconds for one in found]),
    }
    variables = {}
    for name, (units, long_name) in layout.OF_MEMBERS.items():
        attributes: dict[str, Any] = {"long_name": long_name}
        if units:
            attributes["units"] = units
        if name == "status":
            attributes["flag_values"] = np.arange(len(layout.STATUS), dtype=np.int8)
            attributes["flag_meanings"] = " ".join(layout.STATUS)
        values = columns[name] if units else np.array(columns[name], dtype=object)
        variables[name] = ("member", values, attributes)
    return variables


def _fracture_load_factor(member: Member, outcome: Outcome) -> float:
    values = {name: one[1] for name, one in outcome.quantities.items()}
    return fracture_load_factor(member.scene, values) if values else np.nan


def _from_steps(data: xr.Dataset) -> dict[str, xr.DataArray]:
    """Results of the steps: last known values, lengths, counts."""
    found = {}
    for name in layout.LAST:
        one = data[name]
        known = one != NO_STATUS if name == "tip_status" else one.notnull()
        # In reverse order: the first known value is the last one.
        last = data.sizes["step"] - 1 - known.isel(step=slice(None, None, -1)).argmax("step")
        attributes = dict(one.attrs)
        attributes["long_name"] = f"{attributes['long_name']}; last known value"
        found[f"final_{name}"] = one.isel(step=last).drop_vars("step").assign_attrs(attributes)
    segments = (data["tip_x"].diff("step") ** 2 + data["tip_y"].diff("step") ** 2) ** 0.5
    solved = data["load_factor"].notnull().any("step")
    columns = {
        "increments": (segments > 0.0).any("tip").sum("step").where(solved),
        "peak_load_factor": data["load_factor"].max("step"),
        "path_length": segments.sum("step").where(data["tip_x"].notnull().any("step")),
    }
    for name, (units, long_name) in layout.FROM_STEPS.items():
        found[name] = columns[name].assign_attrs(units=units, long_name=long_name)
    return found


def _unfolded(plan: Plan, data: xr.Dataset) -> xr.Dataset:
    """The dimension ``member`` replaced by one dimension for each axis of the study."""
    names, sizes = [axis.name for axis in plan.axes], [len(axis) for axis in plan.axes]
    variables = {}
    for name, one in data.data_vars.items():
        one = one.transpose("member", ...)
        values = one.values.reshape(*sizes, *one.shape[1:])
        variables[name] = ((*names, *one.dims[1:]), values, one.attrs)
    keys = {name: parameter.key for _, name, parameter in plan.study.parameters()}
    coords: dict[str, Any] = {
        name: (
            axis.name,
            np.array(labels, dtype=object if isinstance(labels[0], str) else None),
            layout.described(plan.members[0].scene, keys[name]),
        )
        for axis in plan.axes
        for name, labels in axis.labels.items()
    }
    for name in coords.keys() & variables.keys():
        reason = f"{plan.study.measure} calls a quantity by the name of a parameter"
        raise SceneError([Problem(reason, name)])
    coords |= {str(name): data.coords[name] for name in data.dims if name in data.coords}
    return xr.Dataset(variables, coords)


def _attributes(plan: Plan) -> dict[str, Any]:
    study = plan.study
    files = [one.scene.mesh_file for one in plan.members]
    hashes = {file.path: file.sha256 for file in files if file is not None}
    # Needed to read the scene of a member in another folder, and to check that it is the same.
    meshes = {"base_folder": plan.folder, "mesh_files": json.dumps(hashes)} if hashes else {}
    return {
        **origin(study.name, study.description or f"Parameter study {study.name}", "study"),
        "comment": "study and base are JSON text; no number depends on the number of processes",
        "study": json.dumps(study.model_dump(mode="json", exclude_defaults=True)),
        "base": json.dumps(plan.base),
        **meshes,
        "program": program_hash(),
    }


# Variables of the history that the summary needs.
assert set(layout.LAST) <= set(VARIABLES)
