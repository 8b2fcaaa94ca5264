"""What a run says about itself: what was chosen, what was left out, what is doubtful."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cfmpm.body import Body
from cfmpm.equilibrium import Equilibrium
from cfmpm.fracture.domains import FILL, RESOLVED
from cfmpm.fracture.opening import smallest_openings
from cfmpm.fracture.release import LARGEST_KINK
from cfmpm.materials import LOCKING
from cfmpm.mechanics import NEGLIGIBLE
from cfmpm.meshing import resolved_grading
from cfmpm.motion import Motion
from cfmpm.scene.model import Scene

# What materials have, widened to round numbers: Young's modulus from flexible foams (1 MPa) to
# diamond (1e6 MPa), toughness from ice (0.003 N/mm) to pure ductile metals (1000 N/mm); Ashby and
# Jones, Engineering Materials 1, tables of Young's modulus and of toughness.
USUAL = {"E": (1.0, 2e6, "MPa"), "g_c": (1e-3, 1e3, "N/mm")}

# Angle between a segment and the direction asked for [deg] that is worth a warning.
DEVIATION = 5.0
# Of a grid that is reset (design study): how full a triangle is, what is left of a point's volume,
# how far two domains of the configurational force are apart, and element sizes of drift at a tip.
LEAST_FILL, LEAST_VOLUME, APART, DRIFT = 0.1, 0.5, 0.02, 0.25


def left_out(scene: Scene, has_tips: bool, *, finite: bool = False) -> list[str]:
    """List what a run of this scene does not do because the scene does not need it.

    Parameters
    ----------
    scene : Scene
        Expanded.
    has_tips : bool
        Whether any crack ends inside the body.
    finite : bool
        Whether deformation was finite.

    Returns
    -------
    list of str
    """
    if finite:
        items = [
            "K_I, K_II, T: finite deformation has none; G is J",
        ]
        if scene.formulation == "total":
            items.append("grid reset: all is in the reference configuration")
    else:
        items = ["Newton loop, finite deformation: the scene is linear (finite_effect)"]
        if scene.growth is not None:
            items.append("grid reset: at small strain the grid stays where it is")
    if scene.growth is None:
        reset = "" if scene.formulation == "updated" else ", grid reset"
        items.append(f"crack growth{reset}: the cracks are stationary")
    if not has_tips:
        items.append("configurational force at tips: the scene has no crack tip")
    elif scene.fracture.radii == 1 or (
        isinstance(scene.fracture.radii, list) and len(scene.fracture.radii) == 1
    ):
        items.append("spread over radii: one radius only (fracture.radii: 3 asks for three)")
    if scene.material.g_c is None and not finite:
        items.append("load at fracture: no material.g_c")
        if scene.fatigue is not None:
            items.append("end of fatigue by fracture: no material.g_c")
    if not scene.output.fields and scene.output.every is None:
        items.append("field output: not asked for (output.fields: true)")
    return items


def choices(body: Body, balance: Equilibrium) -> dict[str, Any]:
    """Say what was chosen, as attributes of the history.

    Parameters
    ----------
    body : Body
    balance : Equilibrium

    Returns
    -------
    dict of str to value
    """
    grading = resolved_grading(body.scene)
    notes: dict[str, Any] = {
        "formulation": _formulation(body.scene) + _kinematics(balance),
        "element": body.scene.mesh.element,
        "solver": balance.solver,
        "linear_iterations": balance.iterations,
        "rigid_motions_held": body.loading.held,
    }
    if body.patches is not None:
        notes["near_incompressibility"] = (
            f"nu above {LOCKING:g}: change of volume averaged over {len(body.patches.nodes)} "
            "patches, of two or three triangles each"
        )
    if balance.contact_pairs:
        notes["contact"] = f"{balance.contact_pairs} pairs of crack face nodes closed at the end"
    if grading is not None:
        notes |= {"grid_tip_size": grading.tip_size, "grid_growth": grading.growth}
    if body.tip_domains:
        notes |= {
            "domain_clearance": [domain.clearance for domain in body.tip_domains],
            "domain_cut_back": [int(domain.cut_back) for domain in body.tip_domains],
            "domain_note": (
                f"a domain fills at most {FILL} of the clearance of its tip, so that it holds no "
                "outline, hole, other crack or tip, support or other material, nor, around a tip "
                "that does not run, a bend of its own crack"
            ),
        }
    return notes


def _formulation(scene: Scene) -> str:
    """In which configuration."""
    if scene.formulation == "total":
        return "total Lagrangian, "
    reset = {
        "fixed": "a grid that goes back after every load step; no contact of crack faces",
        "following": "a grid that follows boundary, crack faces and tips",
    }[scene.updated.grid]
    summed = {"points": "points as they are", "domains": "exact particle domains"}
    return f"updated Lagrangian on {reset}; integration by {summed[scene.updated.integration]}; "


def _kinematics(balance: Equilibrium) -> str:
    """How the body deforms, and what that left out."""
    if balance.finite:
        return "finite deformation: Newton's method in load steps, through stable states only"
    chosen = "small strain: one linear solve a step"
    if math.isnan(balance.finite_effect):
        return chosen
    return f"{chosen}; by estimate finite deformation changes the energy as finite_effect says"


def unusual(scene: Scene) -> list[str]:
    """Name the constants of materials that look as if they were in other units.

    Parameters
    ----------
    scene : Scene
        Expanded.

    Returns
    -------
    list of str
        Hints: a scene may have such a material.
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
                    f"{name}material.{key}: {value:g} {unit} is outside of {low:g} to {high:g} "
                    f"{unit}, which materials have; is it meant in {unit}?"
                )
    return found


def doubts_before(body: Body) -> list[str]:
    """Name what is doubtful already before a solve.

    Parameters
    ----------
    body : Body

    Returns
    -------
    list of str
    """
    grid = body.grid
    found = [*unusual(body.scene), *body.loading.warnings]
    for tip, domain in zip(grid.tips, body.tip_domains, strict=True):
        if domain.cut_back:
            found.append(
                f"{tip.name}: radii asked for were cut back to {FILL} of the distance to what a "
                "domain must not hold (domain_radius)"
            )
        if max(domain.radii) < (RESOLVED if not domain.growing else 0.5 * RESOLVED) * tip.h:
            found.append(
                f"{tip.name}: its domain reaches over few elements; make the grid finer there "
                "(mesh.grading.tip_size, or mesh.size)"
            )
    return found


def doubts(body: Body, balance: Equilibrium, scale: float = 1.0) -> list[str]:
    """Name what makes the numbers of a state of balance doubtful.

    Parameters
    ----------
    body : Body
    balance : Equilibrium
    scale : float
        What its stresses are multiplied with.

    Returns
    -------
    list of str
    """
    grid = body.grid
    found = doubts_before(body)
    largest = np.abs(balance.displacement).max(initial=0.0)
    for name, opening in smallest_openings(grid, balance.displacement).items():
        if opening < -1e-6 * largest:
            fixed = body.motion is not None and body.scene.updated.grid == "fixed"
            why = (
                "on a fixed grid, which has no contact" if fixed else "where supports prescribe it"
            )
            found.append(f"{name}: its faces overlap {why}")
    if balance.unstable_points > 0:
        found.append(
            f"from load factor {balance.unstable_from:.4g} on the material has lost ellipticity at "
            "points (unstable_points): results there depend on the grid, and finer grids lose "
            "their stability sooner; material.law: ciarlet keeps it"
        )
    if balance.finite_effect * abs(scale) > NEGLIGIBLE:
        found.append(
            f"finite deformation, left out, would change the energy by more than {NEGLIGIBLE:g} of "
            "itself (finite_effect); kinematics: finite takes it into account"
        )
    if balance.residual_floor > 0.0:
        found.append(
            "the unbalanced force (residual_norm) is at the floor that round-off sets, above what "
            "is asked for: a strong contrast of stiffness, near incompressibility, or a slender "
            "ligament"
        )
    if body.grown.deviation > DEVIATION:
        found.append(
            f"a segment points more than {DEVIATION:g} deg away from the direction asked for: that "
            f"one pointed back, beyond a kink of {LARGEST_KINK:g} deg, or the crack ran into a "
            "node next to its way that may not move"
        )
    if body.motion is not None:
        found += _alarms(body, body.motion)
    elif body.empty_elements:
        found.append(
            "growth.transfer: paper left triangles without a material point (empty_elements), and "
            "nodes without stiffness (floating_nodes), which were held"
        )
    return found


def _alarms(body: Body, motion: Motion) -> Iterator[str]:
    """Name what is wrong with the grid that a body was reset on."""
    if body.empty_elements:
        yield (
            "triangles inside the body have lost material points (empty_elements): each is a hole "
            "or a mechanism, and its neighbours carry its volume; forces are wrong by some per "
            "cent and more from the first of them on; updated.integration: domains has none"
        )
    if motion.fill < LEAST_FILL:
        yield (
            f"material fills less than {LEAST_FILL:g} of a triangle inside the body (least_fill), "
            "which is nearly without stiffness; updated.ghost: 0.1 stabilises it"
        )
    ratio = np.linalg.det(np.eye(2) + body.points.displacement_gradient).min()
    if ratio < LEAST_VOLUME:
        yield (
            f"a material point has less than {LEAST_VOLUME:g} of its volume left (min_det_F): "
            "points are crushed where the grid has come apart from them"
        )


def doubts_at_tips(body: Body, values: Mapping[str, NDArray[np.float64]]) -> Iterator[str]:
    """Name the tips at which a grid that is reset has come apart from the material.

    Parameters
    ----------
    body : Body
    values : mapping of str to (tip,) array
        From `evaluate_tips` and `updated.compare`.
    """
    if body.motion is None:
        return
    for i, tip in enumerate(body.grid.tips):
        on_grid, material = values["cf_norm_grid"][i], values["cf_norm"][i]
        if abs(on_grid - material) > APART * material:
            yield (
                f"{tip.name}: the configurational force on the grid differs from that on the "
                f"material by more than {100 * APART:g} % (cf_norm_grid): neither is to be trusted"
            )
        if values["tip_drift"][i] > DRIFT * tip.h:
            yield (
                f"{tip.name}: the material has moved by more than a quarter of an element past the "
                "tip of the grid (tip_drift): the crack of the grid is not where that of the "
                "material is; updated.grid: following keeps them together"
            )
