"""What a run chose by itself, and what it left out."""

from __future__ import annotations

from typing import Any

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.materials import LOCKING
from cfmpm.body.tip_domains import FILL
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture.finite_effect import NEGLIGIBLE
from cfmpm.mechanics import effects, load_levels
from cfmpm.meshing import resolved_grading
from cfmpm.output.analysis import by_about
from cfmpm.registry.laws import LAWS
from cfmpm.scene.model import Scene


def left_out(scene: Scene, has_tips: bool, *, finite: bool = False) -> list[str]:
    """List the parts of the method that a run of this scene does not use, with the reason.

    Parameters
    ----------
    scene : Scene
        Expanded.
    has_tips : bool
        Whether there is any crack tip.
    finite : bool
        Whether the run used finite deformation.

    Returns
    -------
    list of str
    """
    if finite:
        where = "where strain around the tip is not small" if scene.growth is None else "of growth"
        items = [f"K_I, K_II, T: {where}, at finite deformation; G is J"]
        if has_tips and scene.growth is None and scene.material.g_c is not None:
            items.append(
                "load at fracture: at finite deformation G is not proportional to the square of "
                "the load; lower the load until G is material.g_c"
            )
        if scene.formulation == "total":
            items.append("grid reset: the formulation is total Lagrangian")
    else:
        items = [f"Newton loop, finite deformation: {_why_small(scene)}"]
        if scene.growth is not None:
            items.append("grid reset: not needed at small strain")
    if scene.growth is None:
        reset = "" if scene.formulation == "updated" else ", grid reset"
        items.append(f"crack growth{reset}: the cracks are stationary")
    if not has_tips:
        items.append("configurational force at tips: the scene has no crack tip")
    elif scene.fracture.radii == 1 or (
        isinstance(scene.fracture.radii, list) and len(scene.fracture.radii) == 1
    ):
        items.append("spread over radii: one domain radius only (fracture.radii: 3 gives three)")
    if scene.material.g_c is None and not finite:
        items.append("load at fracture: no material.g_c")
        if scene.fatigue is not None:
            items.append("fracture at the end of fatigue: no material.g_c")
    if not scene.output.fields and scene.output.every is None:
        items.append("field output: not requested (output.fields: true)")
    return items


def choices(scene: Scene, body: Body, balance: Equilibrium) -> dict[str, Any]:
    """Describe what was chosen, as attributes of the history.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body
    balance : Equilibrium

    Returns
    -------
    dict of str to value
    """
    grading, kinematics = resolved_grading(scene), _kinematics(scene, body, balance)
    notes: dict[str, Any] = {
        "formulation": _formulation(scene) + kinematics,
        "kinematics": kinematics,
        "element": scene.mesh.element,
        "solver": balance.solver,
        "linear_iterations": balance.iterations,
        "rigid_motions_held": body.loading.held,
    }
    if body.patches is not None:
        plastic = " or ".join(word for word, law in LAWS.items() if law.plastic)
        notes["near_incompressibility"] = (
            f"nu above {LOCKING:g}, or {plastic}: volume change averaged over "
            f"{len(body.patches.nodes)} patches of two or three triangles each"
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
                f"a domain radius is at most {FILL} of the clearance of the tip, so that the "
                "domain contains no outline, hole, other crack or tip, support or other material, "
                "nor, around a stationary tip, a sharp kink of its own crack"
            ),
        }
    return notes


def _formulation(scene: Scene) -> str:
    """Describe the formulation."""
    if scene.formulation == "total":
        return "total Lagrangian, "
    reset = {
        "fixed": "a grid that is reset after every step; no contact of crack faces",
        "following": "a grid that follows the boundary, crack faces and tips",
    }[scene.updated.grid]
    summed = {"points": "material points", "domains": "exact particle domains"}
    return f"updated Lagrangian on {reset}; integration by {summed[scene.updated.integration]}; "


def _why_small(scene: Scene) -> str:
    """The reason for small strain, before or after a run."""
    if scene.kinematics == "small":
        return "kinematics: small"
    if scene.growth is not None or scene.plane == "stress":
        reason = "crack growth" if scene.growth is not None else "plane stress"
        return f"kinematics: auto keeps small strain under {reason}"
    return (
        "kinematics: auto keeps small strain if finite deformation would change strain energy and "
        f"J by less than {100 * NEGLIGIBLE:g} % (finite_effect, finite_effect_J)"
    )


def _kinematics(scene: Scene, body: Body, balance: Equilibrium) -> str:
    """Describe the kinematics, who chose them, and the estimated effect of finite deformation."""
    if balance.finite:
        chosen = ""
        if scene.kinematics == "auto":
            chosen = f", chosen by kinematics: auto since {_why_finite(scene, body, balance)}"
        return f"finite deformation{chosen}: Newton's method in load steps along stable states"
    return (
        "small strain: one linear solve per step; finite_effect and finite_effect_J are what "
        "finite deformation would change in energy and in J"
    )


def _why_finite(scene: Scene, body: Body, balance: Equilibrium) -> str:
    """The reason for finite deformation."""
    of_energy, of_J = [0.0], [0.0]
    for level in load_levels(scene):
        energy, J = effects(body, balance, level)
        of_energy.append(energy)
        of_J += J[~np.isnan(J)].tolist()
    found = {"the strain energy": (of_energy, "finite_effect"), "J": (of_J, "finite_effect_J")}
    said = [
        f"{what} {by_about(max(values, key=abs), name)}"
        for what, (values, name) in found.items()
        if max(map(abs, values)) > NEGLIGIBLE
    ]
    if said:
        return f"it changes {' and '.join(said)} in a load step (limit {100 * NEGLIGIBLE:g} %)"
    return "some load factors are negative, under which crack faces may close or open"
