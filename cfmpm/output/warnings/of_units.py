"""Warnings about loads that are large for the stiffness, which suggests other units."""

from __future__ import annotations

import math

from cfmpm.scene.geometry import body_size
from cfmpm.scene.model import Scene

# Stress of a load relative to Young's modulus: a tenth is beyond the strength of all but rubber,
# which goes with finite deformation; ten is beyond that, too.
MOST, MOST_OF_RUBBER = 0.1, 10.0


def doubts_of_units(scene: Scene) -> list[str]:
    """Find the largest load whose stress is no small part of the stiffness of the body.

    Parameters
    ----------
    scene : Scene
        Expanded. With a mesh file, whose size it does not know, tractions only.

    Returns
    -------
    list of str
        None for growth at the critical load, which sets the size of the loads itself.
    """
    if scene.growth is not None and scene.growth.control == "crack":
        return []
    part = scene.geometry or scene.mesh_file
    regions = [region.material.E for region in (part.regions if part else [])]
    E = max([scene.material.E, *regions])
    factors = scene.load_steps if isinstance(scene.load_steps, list) else [1.0]
    # The stress of a unit of each kind of load [MPa].
    stress_of = {"traction": 1.0}
    if scene.geometry is not None:
        size = body_size(scene.geometry)
        stress_of |= {"force": 1.0 / size, "body_force": size}
    loads = [load for load in scene.loads if load.kind in stress_of]
    values = [max(map(abs, factors)) * math.hypot(*load.value) for load in loads]
    strains = [v * stress_of[load.kind] / E for v, load in zip(values, loads, strict=True)]
    strain = max(strains, default=0.0)
    if strain <= (MOST_OF_RUBBER if scene.kinematics == "finite" else MOST):
        return []
    load, value = loads[strains.index(strain)], values[strains.index(strain)]
    return [
        f"{load.name}: a {load.kind} of {value:g} gives a strain of the order of {strain:.2g}, its "
        f"stress by material.E of {E:g} MPa: check the units, which are mm, N and MPa (steel has "
        "E: 210e3)"
        + ("; kinematics: finite goes with such strains" if strain <= MOST_OF_RUBBER else "")
    ]
