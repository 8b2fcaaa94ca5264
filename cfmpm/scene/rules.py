"""Conditions on several fields of a scene: all rules in the order of checking."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from cfmpm.elements.record import find_element
from cfmpm.registry.criteria import DIRECTIONS, DRIVING_FORCES
from cfmpm.registry.elements import ELEMENTS
from cfmpm.registry.laws import LAWS
from cfmpm.scene.body import Geometry, MeshFile, Region
from cfmpm.scene.families import expand, key_as_written
from cfmpm.scene.geometry import BodyShape
from cfmpm.scene.material import Material
from cfmpm.scene.mesh import Grading, Mesh
from cfmpm.scene.model import Scene, Updated
from cfmpm.scene.rules_body import Finding, broken_lines, misplaced_holes, misplaced_regions
from cfmpm.scene.rules_crack import misplaced_cracks, moved_ends
from cfmpm.scene.rules_gaps import narrow_gaps
from cfmpm.scene.rules_load import (
    contradictions,
    misplaced_loads,
    swallowed_loads,
    unknown_edges,
)

# Limit on the estimated number of triangles, set by the memory of one machine.
MOST_TRIANGLES = 2e7


# Keys of a scene that `rules_of_body` depends on.
BODY_KEYS = ("geometry", "family", "mesh_file", "loads", "mesh", "fracture", "growth")


@dataclass(frozen=True)
class BodyFindings:
    """What the rules of the body find in a scene.

    Attributes
    ----------
    found : list of (str, str)
        Dotted key in the scene file, and reason.
    regions : dict of str to Material
        Materials of the regions, by what their keys begin with in the expanded scene.
    """

    found: list[Finding]
    regions: dict[str, Material]


def broken_rules(scene: Scene) -> list[Finding]:
    """Return the rules that a scene breaks.

    Parameters
    ----------
    scene : Scene
        Not expanded.

    Returns
    -------
    list of (str, str)
        Dotted key in the scene file, and reason.

    Raises
    ------
    ValidationError
        If the parameters of a family give an invalid geometry.
    """
    body = rules_of_body(scene)
    return [*rules_of_keys(scene, body.regions), *body.found]


def rules_of_keys(scene: Scene, regions: Mapping[str, Material]) -> list[Finding]:
    """Return the broken rules that do not depend on the shape of the body.

    Parameters
    ----------
    scene : Scene
        Not expanded.
    regions : mapping of str to Material
        As in `BodyFindings`.

    Returns
    -------
    list of (str, str)
        Dotted key in the scene file, and reason.
    """
    materials = {"": scene.material, **regions}
    found = [
        *_toughness(scene, materials),
        *_refinement(scene),
        *_fatigue(scene),
        *_kinematics(scene, materials),
        *_formulation(scene),
        *_growth_of_element(scene),
    ]
    return _as_written(scene, found)


def rules_of_body(scene: Scene) -> BodyFindings:
    """Find the broken rules of the body, its loads and its element sizes.

    Distances are relative to the size of the body. A point nearer than 1e-6 to a line is on it. A
    point at a distance between 1e-6 and 1e-4 is ambiguous and refused.

    Parameters
    ----------
    scene : Scene
        Not expanded. Only the keys `BODY_KEYS` are used, since studies check the scenes that agree
        in these keys once.

    Returns
    -------
    BodyFindings

    Raises
    ------
    ValidationError
        If the parameters of a family give an invalid geometry.
    """
    if scene.mesh_file is not None:
        found = [
            *_mesh_file(scene.mesh_file),
            *_sizes_of_mesh_file(scene.mesh),
            *_names_of_loads(scene),
            *contradictions(scene),
            *swallowed_loads(scene),
            *_nothing_to_grow(scene, bool(scene.mesh_file.cracks)),
        ]
        return BodyFindings(found, _materials("mesh_file", scene.mesh_file.regions))
    whole = expand(scene)
    geometry = whole.geometry
    assert geometry is not None
    # The rules of the shapes need valid closed lines, and know cracks, holes and edges by name.
    broken = [*_names(geometry), *broken_lines(geometry)]
    found = [*broken, *_names_of_loads(whole), *unknown_edges(whole)]
    found += [*contradictions(whole), *swallowed_loads(whole)]
    if not broken:
        body = BodyShape(geometry)
        misplaced = [
            *misplaced_holes(body),
            *misplaced_regions(body),
            *misplaced_cracks(body),
        ]
        found += misplaced or narrow_gaps(body)
        found += chain(
            misplaced_loads(whole, body),
            _nothing_to_grow(scene, bool(body.tips), moved_ends(geometry.cracks, body)),
            _sizes(whole, body),
        )
    return BodyFindings(_as_written(scene, found), _materials("geometry", geometry.regions))


def _as_written(scene: Scene, found: list[Finding]) -> list[Finding]:
    return [(key_as_written(scene, key), reason) for key, reason in found]


def _materials(body: str, regions: Sequence[Region]) -> dict[str, Material]:
    return {f"{body}.regions[{i}].": region.material for i, region in enumerate(regions)}


def _sizes_of_mesh_file(mesh: Mesh) -> Iterator[Finding]:
    """Element sizes in a scene with a mesh file."""
    for key in ("size", "grading", "hole_size"):
        if getattr(mesh, key) != getattr(Mesh(), key):
            yield (
                f"mesh.{key}",
                "has no effect with mesh_file, whose triangles are the grid; omit it, and change "
                "the element size in the mesh file",
            )


def _mesh_file(mesh_file: MeshFile) -> Iterator[Finding]:
    if not mesh_file.file.endswith(".msh"):
        yield "mesh_file.file", f"must end in .msh: {mesh_file.file}"
    elif not os.path.isfile(mesh_file.path):
        yield "mesh_file.file", f"no such file: {mesh_file.path}"
    else:
        try:
            digest = mesh_file.digest()
        except OSError as error:
            reason = f"cannot be read: {mesh_file.path}: {error.strerror or error}"
            yield "mesh_file.file", reason
        else:
            if mesh_file.sha256 not in (None, digest):
                yield "mesh_file.file", f"has changed since sha256 was taken: {mesh_file.path}"
    yield from _repeated("mesh_file.cracks[{}]", mesh_file.cracks)
    for key, reason in _repeated("{}", ["body", *(r.name for r in mesh_file.regions)]):
        yield f"mesh_file.regions[{int(key) - 1}].name", reason
    for i, region in enumerate(mesh_file.regions):
        if region.circle or region.polygon:
            yield f"mesh_file.regions[{i}]", "takes its shape from the mesh file"


def _names(geometry: Geometry) -> Iterator[Finding]:
    edges = [str(corner.edge) for corner in geometry.outline]
    # An edge begins where the previous side has another name; consecutive sides may share a name.
    begins = [i for i, edge in enumerate(edges) if edge != edges[i - 1]]
    first = {edges[i]: i for i in reversed(begins)}
    for i in begins:
        if first[edges[i]] != i:
            yield (
                f"geometry.outline[{i}].edge",
                f"{edges[i]} is also the name of side {first[edges[i]] + 1}; only consecutive "
                "sides may share a name",
            )
    holes = [str(hole.name) for hole in geometry.holes]
    for i, name in enumerate(holes):
        if name in edges:
            yield f"geometry.holes[{i}].name", f"{name} is also the name of an edge of the outline"
    yield from _repeated("geometry.holes[{}].name", holes)
    yield from _repeated("geometry.cracks[{}].name", [str(c.name) for c in geometry.cracks])
    regions = ["body", *(region.name for region in geometry.regions)]
    for key, reason in _repeated("{}", regions):
        yield f"geometry.regions[{int(key) - 1}].name", reason


def _names_of_loads(scene: Scene) -> Iterator[Finding]:
    yield from _repeated("loads[{}].name", [load.name for load in scene.loads])


def _repeated(key: str, names: Sequence[str | None]) -> Iterator[Finding]:
    for i, name in enumerate(names):
        if name is not None and name in names[:i]:
            yield key.format(i), f"{name} is a name already in use"


def _refinement(scene: Scene) -> Iterator[Finding]:
    """Refinement without growth, or with transfer: paper, where new triangles have no points."""
    if scene.fracture.refine is None:
        return
    if scene.growth is None:
        yield "fracture.refine", "refines the grid at growing tips: it needs growth"
    elif scene.growth.transfer == "paper":
        yield (
            "fracture.refine",
            "needs growth.transfer: domains; with paper, bisected triangles have no material point",
        )


def _fatigue(scene: Scene) -> Iterator[Finding]:
    """Paris' law without fatigue growth, or fatigue growth without Paris' law."""
    growth = scene.growth
    asked = growth is not None and growth.control == "fatigue"
    if scene.fatigue is not None and not asked:
        yield "fatigue", "needs growth.control: fatigue, which the scene does not have"
    if scene.fatigue is None and asked:
        yield "fatigue", "is missing: growth.control: fatigue needs its C and m"
    if asked and growth is not None and growth.tips == "largest":
        yield "growth.tips", "largest does not go with control: fatigue: all tips advance"


def _kinematics(scene: Scene, materials: Mapping[str, Material]) -> Iterator[Finding]:
    """Keys that do not go with finite deformation, and keys that need it."""
    plastic = [(part, each.law) for part, each in materials.items() if LAWS[each.law].plastic]
    part, law = plastic[0] if plastic else ("", "")
    if plastic and scene.kinematics != "finite":
        yield f"{part}material.law", f"{law} needs kinematics: finite"
    if plastic and scene.updated.integration == "domains":
        yield (
            "updated.integration",
            f"domains does not go with {law}: it would average the plastic state; use points",
        )
    if scene.growth is not None and scene.growth.control != "load":
        control = scene.growth.control
        if scene.kinematics == "finite":
            yield (
                "growth.control",
                f"{control} needs kinematics: small, since it scales results with the load; use "
                "control: load at finite deformation",
            )
        if scene.load_steps != 1:
            yield (
                "load_steps",
                f"does not go with growth.control: {control}, which sets the load itself",
            )
    turns = isinstance(scene.load_steps, list) and min(scene.load_steps) < 0.0
    kept_small = scene.plane == "stress" or scene.growth is not None
    if turns and (scene.kinematics == "small" or (scene.kinematics == "auto" and kept_small)):
        yield (
            "load_steps",
            "a negative load factor needs kinematics: finite: crack faces that close make the "
            "response to load reversal nonlinear",
        )
    if scene.kinematics != "finite":
        return
    if scene.plane == "stress":
        yield "kinematics", "finite needs plane: strain"
    if scene.growth is not None:
        if plastic:
            yield f"{part}material.law", f"{law} does not go with growth"
        for key, table in (("direction", DIRECTIONS), ("criterion", DRIVING_FORCES)):
            word = getattr(scene.growth, key)
            if table[word].needs_k:
                others = " or ".join(other for other in table if not table[other].needs_k)
                yield (
                    f"growth.{key}",
                    f"{word} needs K_I and K_II, which are not defined at finite deformation; use "
                    f"{others}",
                )


def _nothing_to_grow(scene: Scene, has_tips: bool, moved: str = "") -> Iterator[Finding]:
    if scene.growth is not None and not has_tips:
        yield "growth", f"needs a crack that ends inside the body: the scene has none{moved}"


def _formulation(scene: Scene) -> Iterator[Finding]:
    """Options of the updated formulation without it, and keys that do not go with it."""
    default = Updated()
    if scene.formulation == "total":
        if scene.updated != default:
            yield "updated", "needs formulation: updated; total resets no grid"
        return
    if scene.kinematics != "finite":
        yield "formulation", "updated needs kinematics: finite; at small strain no grid is reset"
    if scene.growth is not None:
        fitting = {"points": "paper", "domains": "domains"}[scene.updated.integration]
        if scene.growth.transfer != fitting:
            yield (
                "growth.transfer",
                f"{scene.growth.transfer} does not go with updated.integration: "
                f"{scene.updated.integration}; use {fitting}, or the other integration",
            )
    element = find_element(scene.mesh.element)
    if scene.updated.ghost and not element.constant_gradients:
        yield "updated.ghost", "needs mesh.element: T3, whose gradients are constant"
    for key, needing in (("grid", "following"), ("integration", "domains")):
        if getattr(scene.updated, key) == needing and not element.moves_as_one_domain:
            yield (
                f"updated.{key}",
                f"{needing} needs mesh.element: T3, whose sides stay straight; "
                f"{scene.mesh.element} goes with grid: fixed and integration: points",
            )
    fits = {"margin": "fixed", "smooth_below": "following"}
    for key, grid in fits.items():
        other = getattr(scene.updated, key) != getattr(default, key)
        if other and scene.updated.grid != grid:
            yield f"updated.{key}", f"needs updated.grid: {grid}"


def _growth_of_element(scene: Scene) -> Iterator[Finding]:
    """Growth with an element that does not define the domains of its material points."""
    growth = scene.growth
    if growth is None or growth.transfer == "paper":
        return
    if find_element(scene.mesh.element).domains is None:
        fitting = [word for word in ELEMENTS if find_element(word).domains is not None]
        yield (
            "mesh.element",
            f"{scene.mesh.element} does not go with growth.transfer: domains: it does not define "
            f"the domains of its material points, as {', '.join(fitting)} do; use one of these, or "
            "growth.transfer: paper",
        )


def _toughness(scene: Scene, materials: Mapping[str, Material]) -> Iterator[Finding]:
    """Materials without g_c in a scene with growth."""
    if scene.growth is None or scene.growth.control == "fatigue":
        return
    for part, material in materials.items():
        if material.g_c is None:
            yield f"{part}material.g_c", "is missing: growth needs a critical energy release rate"


def _sizes(scene: Scene, body: BodyShape) -> Iterator[Finding]:
    x_min, y_min, x_max, y_max = body.outline.bounds
    width = min(x_max - x_min, y_max - y_min)
    mesh = scene.mesh
    sizes = {} if mesh.size is None else {"mesh.size": mesh.size}
    if mesh.hole_size is not None:
        sizes["mesh.hole_size"] = mesh.hole_size
    if isinstance(mesh.grading, Grading):
        sizes["mesh.grading.tip_size"] = mesh.grading.tip_size
    for key, size in sizes.items():
        if size > width:
            yield key, f"{size:g} mm is larger than the body, whose smaller extent is {width:g} mm"
    triangles = estimated_triangles(scene, body)
    if triangles > MOST_TRIANGLES:
        asked = {"mesh.hole_size": mesh.hole_size, "mesh.size": mesh.size, "mesh.grading": 0.0}
        key = next(key for key, size in asked.items() if size is not None)
        yield key, f"gives about {triangles:.0e} triangles; the limit is {MOST_TRIANGLES:.0e}"
    if isinstance(scene.fracture.radii, list):
        for i, radius in enumerate(scene.fracture.radii):
            if radius > body.size:
                yield (
                    f"fracture.radii[{i}]",
                    f"{radius:g} mm is larger than the body, {body.size:g} mm",
                )


def estimated_triangles(scene: Scene, body: BodyShape) -> float:
    """Estimate the number of triangles from the element sizes that are numbers in the scene.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : BodyShape
        Body of the scene.

    Returns
    -------
    float
        Area of the body, and of the graded zones at tips and holes, divided by the area of an
        equilateral triangle of the local element size, h^2 sqrt(3)/4 = 0.433 h^2.
    """
    size, grading, hole_size = scene.mesh.size, scene.mesh.grading, scene.mesh.hole_size
    coarse = 0.0 if size is None else _over(body.polygon.area, size)
    if hole_size is not None:
        # Integral over r of (circumference / area of a triangle of size hole_size + growth r).
        growth = grading.growth if isinstance(grading, Grading) else 0.3
        around = sum(hole.length for hole in body.holes.values())
        coarse += min(around / (0.433 * growth * hole_size), _over(body.polygon.area, hole_size))
    if not isinstance(grading, Grading):
        return coarse
    tips = len(body.tips)
    # Integral over r of (2 pi r / area of a triangle of size tip_size + growth r).
    reach = math.log1p((size or body.size) / grading.tip_size)
    fine = _over(math.tau * reach, grading.growth)
    return coarse + min(tips * fine, _over(body.polygon.area, grading.tip_size))


def _over(area: float, size: float) -> float:
    """Divide an area by that of an equilateral triangle; the square is taken last: no underflow."""
    return (math.sqrt(area / 0.433) / size) * (math.sqrt(area / 0.433) / size)
