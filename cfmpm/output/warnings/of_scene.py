"""Warnings about a scene known before it is solved, and suggestions after an unstable end."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from shapely import LineString

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats, line_of
from cfmpm.body.notches import sharp_notches
from cfmpm.body.tip_domains import FILL, RESOLVED
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.output.warnings.doubt import SIZE, Doubt
from cfmpm.output.warnings.of_units import doubts_of_units
from cfmpm.registry.laws import LAWS
from cfmpm.registry.loads import LOADS
from cfmpm.scene.families import expand
from cfmpm.scene.model import Scene
from cfmpm.scene.rules_load import cracks_in_box

# Range of material constants, rounded outwards: Young's modulus from gels (1e-3 MPa) to diamond
# (1e6 MPa), toughness from ice (0.003 N/mm) to pure ductile metals (1000 N/mm); Ashby and Jones,
# Engineering Materials 1, tables of Young's modulus and of toughness.
USUAL = {"E": (1e-3, 2e6, "MPa"), "g_c": (1e-3, 1e3, "N/mm")}
# Of the size of the body: crack in the box of a load that is worth a warning.
LEAST_IN_BOX = 1e-3
# Part of a size at which elements are asked for so that none is larger: the mesh generator leaves
# some above it.
MESHED = 0.8
# What makes the equations less sensitive to round-off.
BETTER_CONDITIONED = "bring material.E of the regions closer together, lower material.nu"


def ways_on(scene: Scene, balance: Equilibrium) -> list[str]:
    """Suggest changes of a scene for which no further stable state was found.

    Parameters
    ----------
    scene : Scene
    balance : Equilibrium
        The last stable one.

    Returns
    -------
    list of str
    """
    found = []
    if not all(LOADS[load.kind].holds for load in expand(scene).loads):
        found.append("Prescribed displacements can pass a limit load; prescribed forces cannot.")
    law = LAWS[scene.material.law]
    if balance.unstable_points > 0 and not (law.elliptic or law.plastic):
        found.append("Points have lost ellipticity; material.law: ciarlet never loses it.")
    if scene.formulation == "updated":
        found.append(
            "formulation: total does not reset the grid, so that the body can neither leave the "
            "grid nor separate from it."
        )
    if scene.growth is not None:
        found.append(
            "Triangles are stretched most behind a growing tip; mesh.grading: uniform and "
            "mesh.element: T3 tolerate larger stretches."
        )
    return found or ["Reduce the load, or change the body so that it does not buckle."]


def unusual(scene: Scene) -> list[str]:
    """Find material constants outside the usual range, which suggests other units.

    Parameters
    ----------
    scene : Scene
        Expanded.

    Returns
    -------
    list of str
        Warnings only, since such a material is possible.
    """
    part = scene.geometry or scene.mesh_file
    materials = {"": scene.material}
    materials |= {f"{region.name}: ": region.material for region in (part.regions if part else [])}
    found = []
    for name, material in materials.items():
        for key, (low, high, unit) in USUAL.items():
            value = getattr(material, key)
            if value is not None and not low <= value <= high:
                found.append(
                    f"{name}material.{key}: {value:g} {unit} is outside the usual range of "
                    f"{low:g} to {high:g} {unit}; check that it is given in {unit}"
                )
    return found


def doubts_before(scene: Scene, body: Body) -> list[str]:
    """Give the warnings that are known before the first solve.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body

    Returns
    -------
    list of str
    """
    domains = [doubt.said() for doubt in doubts_of_tip_domains(scene, body)]
    return [*doubts_of_scene(scene, body), *domains]


def doubts_of_scene(scene: Scene, body: Body) -> list[str]:
    """Give the warnings about a scene that hold for all of its states.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body

    Returns
    -------
    list of str
    """
    own = scene.mesh_file is None
    found = [*unusual(scene), *doubts_of_units(scene), *body.loading.warnings]
    if not body.loading.any:
        found.append(
            "the body has no load, so that all results are zero: add a traction, a force, a "
            "displacement other than zero, or a body_force to loads"
        )
    found += [
        f"the boundary has a sharp notch with its root at ({_xy(notch.root)}) and an angle of "
        f"{notch.angle:.3g} deg, where neither K nor J is evaluated and nothing grows; if a crack "
        + (
            "is meant, take the notch out of the outline and add geometry.cracks: "
            f"[{{points: [[{_xy(notch.mouth)}], [{_xy(notch.root)}]]}}]"
            if own
            else "is meant, mesh the body without the notch, with a physical curve from "
            f"({_xy(notch.mouth)}) to ({_xy(notch.root)}) that mesh_file.cracks lists"
        )
        for notch in sharp_notches(body.triangulation)
    ]
    mesh = body.triangulation
    lines = {name: LineString(mesh.nodes[line_of(pairs)]) for name, pairs in mesh.cracks.items()}
    least = LEAST_IN_BOX * float(np.ptp(mesh.nodes, axis=0).max())
    for load in scene.loads:
        if load.box is not None and (held := cracks_in_box(load.box, lines, least)):
            found.append(
                f"{load.name}: its box contains {sum(held.values()):.4g} mm of "
                f"{' and '.join(held)}; the {load.kind} acts on the boundary in the box, not on "
                "crack faces: end the box at the boundary, or name an edge"
            )
    if body.patches is not None and body.materials.plastic.any():
        found.append(
            "linear triangles (T3) are too stiff in plastic flow near the limit load, also with "
            "the volume change averaged over patches: use mesh.element: T6 (formulation: updated "
            "then needs grid: fixed)"
        )
    return found


def doubts_of_tip_domains(scene: Scene, body: Body) -> Iterator[Doubt]:
    """Find tips on the interface of two materials, and domains that were reduced or are small.

    Parameters
    ----------
    scene : Scene
    body : Body
    """
    for tip, domain in zip(body.grid.tips, body.tip_domains, strict=True):
        largest = max(domain.radii)
        if domain.on_border:
            yield Doubt(
                "the tip lies on the interface of two materials, where K_I and K_II are not "
                "defined: G is J, and the crack grows straight ahead by one segment, of up to "
                f"{SIZE} mm; a smaller fracture.refine shortens it. For a crack that runs along "
                "the interface, move the border of the region off its path by a few elements",
                tip.name,
                tip.h,
            )
        if domain.cut_back:
            most = f", here {rounded_down(FILL * domain.clearance)} mm"
            yield Doubt(
                f"requested domain radii were reduced (domain_radius) to {FILL} of the clearance, "
                "the distance to the nearest object that a domain must not contain; fracture.radii "
                f"up to that{'' if domain.growing else most} are used as they are",
                tip.name,
            )
        if not domain.growing and largest < RESOLVED * tip.h:
            yield Doubt(
                f"the largest domain radius is {largest:.3g} mm, below {RESOLVED:g} element sizes: "
                + finer_at_tips(scene, MESHED * largest / RESOLVED),
                tip.name,
            )


def finer_at_tips(scene: Scene, size: float) -> str:
    """Advise elements at the tips of a size below a given one [mm]."""
    if scene.mesh_file is not None:
        return f"give the mesh file elements of at most {rounded_down(size)} mm there"
    return f"set mesh.grading.tip_size to at most {rounded_down(size)} mm"


def rounded_down(length: float) -> str:
    """Return a length of two digits that is not above the given one, as text."""
    unit = 10.0 ** (math.floor(math.log10(length)) - 1)
    return f"{math.floor(length / unit * (1.0 + 1e-12)) * unit:.2g}"


def _xy(point: Floats) -> str:
    """Coordinates of a point without round-off of the grid."""
    return ", ".join(f"{x + 0.0:.6g}" for x in np.round(point, 9))
