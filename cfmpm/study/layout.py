"""Variables and dimensions of the dataset of a study."""

from __future__ import annotations

from typing import Any

from cfmpm.output.variables import OF_FATIGUE, VARIABLES
from cfmpm.scene import Scene
from cfmpm.scene.base import Model
from cfmpm.scene.document import parse_key
from cfmpm.study.expansion import SAMPLE

# `unstable`: solved up to a step that no stable state follows.
STATUS = ("done", "failed", "not_run", "unstable")
# Dimensions of the members' histories.
DIMENSIONS = ("step", "tip", "radius", "boundary")
# Variables of every member: units, long name. Those without units are text.
OF_MEMBERS: dict[str, tuple[str, str]] = {
    "status": ("1", "status of the member"),
    "reason": ("", "why the member is not done"),
    "ending": ("", "why the run of the member ended"),
    "warnings": ("", "warnings of the member, JSON text"),
    "solver": ("", "linear solver of the member"),
    "member_key": ("", "hash of the member's effective configuration and of the program"),
    "run_time": ("s", "wall time of the member"),
    "cpu_time": ("s", "processor time of the member"),
    "fracture_load_factor": (
        "1",
        "load factor at which the first tip reaches g_c by G_kink, at finite deformation between "
        "load steps and where the crack would go on straight ahead by J",
    ),
}
# Variables of members with several steps.
FROM_STEPS: dict[str, tuple[str, str]] = {
    "increments": ("1", "number of steps in which a tip has moved"),
    "peak_load_factor": ("1", "largest load factor of all steps"),
    "path_length": ("mm", "length of the path of the tip"),
}
# Variables of the history whose last known value is given in addition to all steps.
LAST = (
    *("tip_x", "tip_y", "crack_length", "tip_status"),
    *("cf_norm", "cf_angle", "J", "G", "K_I", "K_II", "T_stress"),
    *("strain_energy", "external_work", "fracture_energy"),
)
RESERVED = {
    *(SAMPLE, *DIMENSIONS, *VARIABLES, *OF_FATIGUE, *OF_MEMBERS, *FROM_STEPS),
    *("load_factor", "run_status", "stability"),
    *(f"final_{name}" for name in LAST),
    *(f"{name}_spread" for name in VARIABLES),
}


def described(scene: Scene, key: str | None) -> dict[str, str]:
    """Attributes of a key from the model of a scene: `key`, and `long_name` and `units` if given.

    Parameters
    ----------
    scene : Scene
        A scene with the key.
    key : str or None
        Dotted; None for variants, which replace several keys.
    """
    if key is None:
        return {"long_name": "variant of the scene"}
    attributes = {"key": key}
    here: Any = scene
    text = ""
    for part in parse_key(key):
        if isinstance(here, Model) and isinstance(part, str):
            text = type(here).model_fields[part].description or ""
            here = getattr(here, part)
        elif isinstance(here, list | tuple) and isinstance(part, int):
            here = here[part]
        else:
            return attributes
    # As in "element size [mm]; default from the body".
    meaning, _, rest = text.partition("[")
    if meaning.strip():
        attributes["long_name"] = meaning.strip()
    if "]" in rest:
        attributes["units"] = rest.partition("]")[0]
    return attributes
