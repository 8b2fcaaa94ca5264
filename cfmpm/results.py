"""The history of a run as one labelled dataset, and its safe writing to netCDF."""

from __future__ import annotations

import json
import os
import secrets
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import cfmpm.accessor  # noqa: F401  (who has a history has its accessor)
from cfmpm.fracture.stability import STABILITY
from cfmpm.interruption import held_back
from cfmpm.scene import config_hash, effective_config
from cfmpm.scene.model import Scene
from cfmpm.versions import versions

TIP_STATUS = (
    "growing",
    "stopped",
    "arrived_boundary",
    "arrived_hole",
    "arrived_crack",
    "severed",  # inside a body that another crack has cut apart
)

_STEP, _TIP, _RADIUS = ("step",), ("step", "tip"), ("step", "tip", "radius")
_STRESS_INTENSITY = "MPa mm0.5"
_REACTION = (
    "force on the body at the loaded part: what the load applies, or what its prescribed "
    "components exert; of supports that share a node the first has its force"
)
# Name: dimensions, units, long name.
VARIABLES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "tip_x": (_TIP, "mm", "position of the crack tip"),
    "tip_y": (_TIP, "mm", "position of the crack tip"),
    "crack_length": (_TIP, "mm", "length of the crack line that ends in the tip"),
    "tip_status": (_TIP, "1", "what the tip does"),
    "cf_x": (_TIP, "N mm-1", "configurational force on the largest domain (paper eq 27)"),
    "cf_y": (_TIP, "N mm-1", "configurational force on the largest domain (paper eq 27)"),
    "cf_norm": (_TIP, "N mm-1", "norm of the configurational force on the largest domain"),
    "cf_angle": (_TIP, "degree", "angle of the configurational force from the crack tangent"),
    "cf_tip_x": (_TIP, "N mm-1", "configurational force on the tip node (paper eq 26)"),
    "cf_tip_y": (_TIP, "N mm-1", "configurational force on the tip node (paper eq 26)"),
    "cf_plastic_x": (_TIP, "N mm-1", "what plastic work adds to the configurational force"),
    "cf_plastic_y": (_TIP, "N mm-1", "what plastic work adds to the configurational force"),
    "J_plastic": (_TIP, "N mm-1", "what plastic work adds to J, which is of the stored energy"),
    "J": (_TIP, "N mm-1", "domain integral along the crack tangent, largest ring"),
    "G": (
        _TIP,
        "N mm-1",
        "energy release rate from K_I and K_II, largest ring; at finite deformation J",
    ),
    "G_kink": (_TIP, "N mm-1", "what drives the tip in the direction in which it would kink"),
    "K_I": (_TIP, _STRESS_INTENSITY, "stress intensity factor of mode I, largest ring"),
    "K_II": (_TIP, _STRESS_INTENSITY, "stress intensity factor of mode II, largest ring"),
    "T_stress": (_TIP, "MPa", "T-stress, largest ring"),
    "cf_norm_grid": (
        _TIP,
        "N mm-1",
        "norm of the configurational force on a disc of the grid, where that is reset",
    ),
    "tip_drift": (_TIP, "mm", "distance of the material's tip from that of the grid, if reset"),
    "kink_angle": (_TIP, "degree", "angle of largest hoop stress from the crack tangent"),
    "clearance": (_TIP, "mm", "distance to the nearest thing that no domain may hold"),
    "tip_size": (_TIP, "mm", "element size at the tip"),
    "min_opening": (_TIP, "mm", "smallest opening of the crack's faces, negative in overlap"),
    "critical_load_factor": (_TIP, "1", "load factor at which G_kink reaches g_c"),
    "domain_radius": (_RADIUS, "mm", "radius of the domain, as used"),
    "J_radius": (_RADIUS, "N mm-1", "domain integral along the crack tangent"),
    "J_plastic_radius": (_RADIUS, "N mm-1", "what plastic work adds to J"),
    "G_radius": (_RADIUS, "N mm-1", "energy release rate from K_I and K_II"),
    "K_I_radius": (_RADIUS, _STRESS_INTENSITY, "stress intensity factor of mode I"),
    "K_II_radius": (_RADIUS, _STRESS_INTENSITY, "stress intensity factor of mode II"),
    "T_stress_radius": (_RADIUS, "MPa", "T-stress"),
    "cf_norm_radius": (_RADIUS, "N mm-1", "norm of the configurational force on the domain"),
    "cf_angle_radius": (_RADIUS, "degree", "angle of the configurational force, from the tangent"),
    "strain_energy": (_STEP, "N", "strain energy per mm of thickness (N mm/mm)"),
    "plastic_work": (_STEP, "N", "plastic work per mm of thickness (N mm/mm); nan without flow"),
    "external_work": (_STEP, "N", "work of the loads per mm of thickness (N mm/mm)"),
    "fracture_energy": (_STEP, "N", "g_c times new crack length per mm of thickness (N mm/mm)"),
    "energy_gap": (_STEP, "N", "external_work less strain_energy less fracture_energy"),
    "jump": (_STEP, "1", "1 where a tip has broken through to what it met, at the load before"),
    "newton_iterations": (_STEP, "1", "Newton iterations so far; 0 for a linear solve"),
    "substeps": (_STEP, "1", "load steps so far, those in between included; 0 for a linear solve"),
    "finite_effect": (
        _STEP,
        "1",
        "part of the energy that finite deformation, left out, would change: an estimate",
    ),
    "residual_norm": (_STEP, "1", "largest unbalanced force over the largest nodal force"),
    "negative_pivots": (_STEP, "1", "negative pivots of the stiffness; nan by amg"),
    "unstable_points": (_STEP, "1", "points that lost ellipticity; nan: linear, not looked at"),
    "n_points": (_STEP, "1", "material points"),
    "n_nodes": (_STEP, "1", "nodes of the background grid"),
    "contact_pairs": (_STEP, "1", "pairs of nodes at which crack faces press on each other"),
    "min_det_F": (_STEP, "1", "least volume ratio of the material points; nan at small strain"),
    "least_fill": (_STEP, "1", "of triangles with material the least part that it fills, if reset"),
    "grid_resets": (_STEP, "1", "how often the grid was moved under the points so far, if reset"),
    "grid_quality": (_STEP, "1", "worst triangle that growth changed; 1 equilateral, 0 flat"),
    "empty_elements": (
        _STEP,
        "1",
        "triangles without a material point; where the grid is reset, with fewer than were seeded",
    ),
    "floating_nodes": (_STEP, "1", "nodes without stiffness, which were held"),
    "n_unknowns": (_STEP, "1", "free degrees of freedom"),
    "reaction_x": (("step", "boundary"), "N mm-1", _REACTION),
    "reaction_y": (("step", "boundary"), "N mm-1", _REACTION),
    "displacement_x": (("step", "boundary"), "mm", "mean displacement of the loaded part"),
    "displacement_y": (("step", "boundary"), "mm", "mean displacement of the loaded part"),
    "displacement": (
        ("step", "boundary"),
        "mm",
        "mean displacement of the loaded part along the force on it (reaction_x, reaction_y); "
        "nan without a force",
    ),
    "wall_time": (("step", "phase"), "s", "wall time"),
}
# The same, of scenes with fatigue alone.
OF_FATIGUE = {
    "cycles": (_STEP, "1", "cycles of load so far, by Paris' law"),
    "delta_K": (_TIP, _STRESS_INTENSITY, "range of sqrt(K_I^2 + K_II^2) in a cycle"),
    "da_dN": (_TIP, "mm", "growth per cycle, by Paris' law; zero at and below the threshold"),
}
# With which power of the load factor the quantities of a linear scene grow; the others not at all.
LOAD_POWER = {
    **dict.fromkeys(("K_I", "K_II", "T_stress", "min_opening"), 1),
    **dict.fromkeys(("K_I_radius", "K_II_radius", "T_stress_radius"), 1),
    "finite_effect": 1,
    **dict.fromkeys(("reaction_x", "reaction_y", "displacement_x", "displacement_y"), 1),
    "displacement": 1,
    **dict.fromkeys(("cf_x", "cf_y", "cf_norm", "cf_tip_x", "cf_tip_y", "cf_norm_radius"), 2),
    **dict.fromkeys(("J", "G", "G_kink", "J_radius", "G_radius", "strain_energy"), 2),
}
# Quantities whose largest difference over the radii is stated as their spread.
SPREAD = ("J", "G", "K_I", "K_II", "T_stress", "cf_norm", "cf_angle")


@dataclass
class StepRecord:
    """What one step adds to the history; every key of `values` is one of `VARIABLES`.

    Attributes
    ----------
    load_factor : float
    values : mapping of str to float or array
        Without the step dimension: scalars, (tip,), (tip, radius), (boundary,).
    seconds : mapping of str to float
        Wall time of each phase [s].
    conjugates : (float, float)
        What loads do work with when the load factor changes: the sum of dead forces (at factor one)
        times displacements, and that of reactions times prescribed displacements (at factor one)
        [N].
    """

    load_factor: float
    values: Mapping[str, Any]
    seconds: Mapping[str, float]
    conjugates: tuple[float, float] = (np.nan, np.nan)


def build_history(
    scene: Scene,
    records: Sequence[StepRecord],
    *,
    tips: Sequence[str],
    radii: Sequence[float],
    boundaries: Sequence[str],
    notes: Mapping[str, Any],
    stability: NDArray[np.int8] | None = None,
) -> xr.Dataset:
    """Gather the steps of a run into one dataset.

    Parameters
    ----------
    scene : Scene
        As the user wrote it; its effective configuration goes into the attributes.
    records : sequence of StepRecord
    tips, boundaries : sequence of str
    radii : sequence of float
        Nominal domain radii [mm].
    notes : mapping
        Further attributes: text, numbers, or lists, which become JSON text: of a list netCDF keeps
        neither that it is empty nor that it has one entry.
    stability : (step,) int8, optional
        Index into `STABILITY`; default undefined.

    Returns
    -------
    xarray.Dataset
        Dimensions step, tip, radius, boundary and phase; what a run did not compute is nan.
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
    data["stability"] = (
        _STEP,
        np.zeros(len(records), np.int8) if stability is None else stability,
        {
            "units": "1",
            "long_name": "growth from this step on, under crack control",
            "comment": "stable: the force rises; unstable: it falls; snap_back: so does the "
            "displacement",
            **_flags(STABILITY),
        },
    )
    for name in SPREAD:
        values = data[f"{name}_radius"][1]
        if VARIABLES[name][1] == "degree":
            values = np.unwrap(values, period=360.0, axis=2)
        spread = np.ptp(values, axis=2) if len(radii) > 1 else np.full(values.shape[:2], np.nan)
        data[f"{name}_spread"] = (
            _TIP,
            spread,
            {
                "units": VARIABLES[name][1],
                "long_name": f"largest less smallest {name} over the radii: its uncertainty as "
                "far as the domain goes; the error of the grid comes on top",
            },
        )
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
    return xr.Dataset(data, coords, {**provenance(scene), **texts})


def _flags(meanings: Sequence[str]) -> dict[str, Any]:
    """Attributes of a variable whose values are indices into words."""
    return {
        "flag_values": np.arange(len(meanings), dtype=np.int8),
        "flag_meanings": " ".join(meanings),
    }


def provenance(scene: Scene) -> dict[str, Any]:
    """Return global attributes after CF and ACDD, with what is needed to run a scene again."""
    import numba  # loaded already where a scene has been solved, and else not needed

    return {
        **origin(scene.name, scene.description or f"Crack tips of scene {scene.name}", "run"),
        "comment": "lists are JSON text; no number depends on how many threads were available",
        "threads": numba.get_num_threads(),
        "config": json.dumps(effective_config(scene), sort_keys=True),
        "config_hash": config_hash(scene),
    }


def origin(title: str, summary: str, command: str) -> dict[str, Any]:
    """Return global attributes after CF and ACDD that every dataset has.

    Parameters
    ----------
    title, summary : str
    command : str
        Of ``cfmpm`` that makes the dataset.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    now = datetime.fromtimestamp(float(epoch) if epoch else time.time(), UTC)
    stamp = now.strftime("%Y-%m-%dT%H:%M:%SZ")
    return {
        "Conventions": "CF-1.11, ACDD-1.3",
        "title": title,
        "summary": summary,
        "source": f"cfmpm {versions()['cfmpm']}",
        "references": "Zhou et al., Theor. Appl. Fract. Mech. 117 (2022) 103186",
        "keywords": "fracture mechanics, material point method, configurational force",
        "history": f"{stamp} cfmpm {command}",
        "date_created": stamp,
        "versions": json.dumps(versions()),
    }


def write_dataset(dataset: xr.Dataset, path: Path) -> None:
    """Write a dataset to netCDF aside and rename it, so that no half file is ever seen.

    Parameters
    ----------
    dataset : xarray.Dataset
    path : Path
        Its folder is made if needed.

    Raises
    ------
    OSError
        Where the folder cannot be written; `path` is then untouched.
    """
    with written_aside(path) as aside:
        store(dataset, aside)


def store(dataset: xr.Dataset, path: Path) -> None:
    """Write a dataset to netCDF in place: into what `written_aside` gives."""
    # Coordinates have no missing values; NaN marks them everywhere else.
    encoding = {str(c): {"_FillValue": None} for c in dataset.coords}
    dataset.to_netcdf(path, engine="netcdf4", encoding=encoding)


@contextmanager
def written_aside(path: Path) -> Iterator[Path]:
    """Give a place to write to, which becomes `path` when the ``with`` block ends well.

    Requests to end wait for that.

    Parameters
    ----------
    path : Path
        Its folder is made if needed.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        # Unlike tempfile's, with the permissions that any new file of this process gets.
        os.close(os.open(aside, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        with held_back():
            yield aside
            with aside.open("rb+") as file:
                os.fsync(file.fileno())
            aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)


def remove_asides(folder: Path, name: str) -> None:
    """Take away what processes that were killed had begun to write aside.

    Parameters
    ----------
    folder : Path
    name : str
        What the files were to be called; a pattern.
    """
    for path in Path(folder).glob(f".{name}.{'[0-9a-f]' * 8}.part"):
        path.unlink(missing_ok=True)
