"""The history of a run as one labelled dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cfmpm.ending import RUN_STATUS, Ending
from cfmpm.fracture.stability import STABILITY
from cfmpm.output.provenance import provenance
from cfmpm.output.variables import (
    OF_FATIGUE,
    SPREAD,
    STEP,
    TIP,
    TIP_STATUS,
    VARIABLES,
)
from cfmpm.scene.model import Scene


@dataclass
class StepRecord:
    """The values of one step of the history; every key of `values` is one of `VARIABLES`.

    Attributes
    ----------
    load_factor : float
    values : mapping of str to float or array
        Without the step dimension: scalars, (tip,), (tip, radius), (boundary,).
    seconds : mapping of str to float
        Wall time of each phase [s].
    conjugates : (float, float, float)
        Work conjugates of the load factor [N]: the sum of dead forces (at factor one) times
        displacements; the sum of reactions times prescribed displacements (at factor one); and, for
        the fixed loads, the sum of dead forces times displacements.
    """

    load_factor: float
    values: Mapping[str, Any]
    seconds: Mapping[str, float]
    conjugates: tuple[float, float, float] = (np.nan, np.nan, np.nan)


def build_history(
    scene: Scene,
    records: Sequence[StepRecord],
    ending: Ending,
    *,
    tips: Sequence[str],
    radii: Sequence[float],
    boundaries: Sequence[str],
    notes: Mapping[str, Any],
    stability: NDArray[np.int8] | None = None,
) -> xr.Dataset:
    """Collect the steps of a run in one dataset.

    Parameters
    ----------
    scene : Scene
        As given by the user; its effective configuration is an attribute.
    records : sequence of StepRecord
    ending : Ending
        End of the run.
    tips, boundaries : sequence of str
    radii : sequence of float
        Nominal domain radii [mm].
    notes : mapping
        Further attributes: text, numbers, or lists. Lists become JSON text, since netCDF does not
        preserve lists of no or one entry.
    stability : (step,) int8, optional
        Index into `STABILITY`; default undefined.

    Returns
    -------
    xarray.Dataset
        Dimensions step, tip, radius, boundary and phase; values that were not computed are nan.
    """
    phases = list(dict.fromkeys(phase for record in records for phase in record.seconds))
    sizes = {
        "step": len(records),
        "tip": len(tips),
        "radius": len(radii),
        "boundary": len(boundaries),
        "phase": len(phases),
    }
    data: dict[str, Any] = {}
    variables = VARIABLES if scene.fatigue is None else VARIABLES | OF_FATIGUE
    for name, (dims, units, long_name) in variables.items():
        if not dims:
            values = np.array(ending.values.get(name, np.nan))
            data[name] = ((), values, {"units": units, "long_name": long_name})
            continue
        values = np.full([sizes[d] for d in dims], np.nan)
        for i, record in enumerate(records):
            if name == "wall_time":
                values[i] = [record.seconds.get(phase, 0.0) for phase in phases]
            elif name in record.values:
                values[i] = record.values[name]
        attributes: dict[str, Any] = {"units": units, "long_name": long_name}
        if name == "tip_status":
            values = np.where(np.isnan(values), 1, values).astype(np.int8)
            attributes |= _flags(TIP_STATUS)
        data[name] = (dims, values, attributes)
    data |= _status(ending, len(records), stability)
    data |= {f"{name}_spread": _spread(name, data[f"{name}_radius"][1]) for name in SPREAD}
    coords = {
        "step": ("step", np.arange(1, len(records) + 1), {"long_name": "load or growth step"}),
        "load_factor": (
            "step",
            np.array([record.load_factor for record in records]),
            {"units": "1", "long_name": "factor on all loads of the scene"},
        ),
        "tip": ("tip", np.array(tips, dtype=object), {"long_name": "crack tip"}),
        "radius": ("radius", np.array(radii), {"units": "mm", "long_name": "domain radius"}),
        "boundary": ("boundary", np.array(boundaries, object), {"long_name": "loaded part"}),
        "phase": ("phase", np.array(phases, object), {"long_name": "part of the run"}),
    }
    texts = {
        name: json.dumps(note, ensure_ascii=False) if isinstance(note, list) else note
        for name, note in notes.items()
    }
    ended = {"ending": ending.text, "run_status": ending.status}
    return xr.Dataset(data, coords, {**provenance(scene), **ended, **texts})


def _status(
    ending: Ending, steps: int, stability: NDArray[np.int8] | None
) -> dict[str, tuple[Any, ...]]:
    """Status of the run, and stability of growth from each step on."""
    return {
        "run_status": (
            (),
            np.int8(RUN_STATUS.index(ending.status)),
            {"units": "1", "long_name": "how the run ended", **_flags(RUN_STATUS)},
        ),
        "stability": (
            STEP,
            np.zeros(steps, np.int8) if stability is None else stability,
            {
                "units": "1",
                "long_name": "growth from this step on, under crack control",
                "comment": "stable: the force rises; unstable: it falls; snap_back: so does the "
                "displacement",
                **_flags(STABILITY),
            },
        ),
    }


def _spread(name: str, values: NDArray[np.float64]) -> tuple[Any, ...]:
    """Range of a quantity, (step, tip, radius), over the radii."""
    if VARIABLES[name][1] == "degree":
        values = np.unwrap(values, period=360.0, axis=2)
    several = values.shape[2] > 1
    return (
        TIP,
        np.ptp(values, axis=2) if several else np.full(values.shape[:2], np.nan),
        {
            "units": VARIABLES[name][1],
            "long_name": f"largest minus smallest {name} over the domain radii: the uncertainty of "
            "its evaluation, without the discretisation error",
        },
    )


def _flags(meanings: Sequence[str]) -> dict[str, Any]:
    """Attributes of a variable whose values are indices of words."""
    return {
        "flag_values": np.arange(len(meanings), dtype=np.int8),
        "flag_meanings": " ".join(meanings),
    }
