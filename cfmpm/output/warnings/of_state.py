"""Warnings about one state of equilibrium."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.body import Body
from cfmpm.body.crack_faces import smallest_openings
from cfmpm.body.motion import Motion
from cfmpm.body.volume_patches import patch_of
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture.release import LARGEST_KINK
from cfmpm.fracture.relieved import relieved_nodes
from cfmpm.mechanics import held_turning, leans
from cfmpm.output.warnings.doubt import SIZE, Doubt
from cfmpm.output.warnings.of_scene import BETTER_CONDITIONED
from cfmpm.scene.model import Scene

# Largest accepted relative difference of external work and energies at finite deformation.
IMBALANCE = 0.01
# Largest angle between a segment and the direction of growth without a warning [deg].
DEVIATION = 5.0
# Limits for a grid that is reset (design study): smallest filled fraction of a triangle, smallest
# ratio of a point's volume to its initial volume, largest relative difference between the
# configurational forces of the two domains, largest drift at a tip in element sizes.
LEAST_FILL, LEAST_VOLUME, APART, DRIFT = 0.1, 0.5, 0.02, 0.25
# Configurational force of round-off, as at closed faces, times clearance, over strain energy.
NO_FORCE = 1e-6


def doubts(scene: Scene, body: Body, balance: Equilibrium) -> Iterator[Doubt]:
    """Give the warnings about one state of equilibrium.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body
    balance : Equilibrium
    """
    yield from _overlaps(body, balance)
    if balance.unstable_points > 0:
        yield Doubt(
            f"up to {SIZE} material points have lost ellipticity (unstable_points), from load "
            f"factor {balance.unstable_from:.4g} on: results there depend on the grid, and finer "
            "grids become unstable at lower loads; material.law: ciarlet stays elliptic",
            size=float(balance.unstable_points),
        )
    one_grid = body.motion is None and scene.growth is None
    gap = _gap_of_work(body, balance) if balance.finite and one_grid else 0.0
    if gap > IMBALANCE:
        yield Doubt(
            "the external work, summed over the load steps, differs from the strain energy and "
            f"plastic work by up to {SIZE} % (external_work): increase load_steps",
            size=100.0 * gap,
        )
    if leans(body, balance):
        yield Doubt(
            "the loads have a moment on the deformed body, and no support prevents the rotation: "
            f"it was held, with a reaction moment, by up to {SIZE} % of the largest nodal force; "
            "add supports that prevent it (a displacement of zero in both components of one point "
            "and in one of another)",
            size=100.0 * held_turning(body, balance),
        )
    if balance.residual_floor > 0.0 and not relieved_nodes(body, balance).all():
        yield Doubt(
            f"the unbalanced force is up to {SIZE} of the largest nodal force (residual_norm), "
            "above the tolerance, limited by round-off; causes are a large contrast of stiffness, "
            "near incompressibility, or a slender ligament: "
            f"{BETTER_CONDITIONED}, or leave a wider ligament",
            size=balance.residual_norm,
        )
    for tip, deviation in body.grown.deviations.items():
        if deviation <= DEVIATION:
            continue
        yield Doubt(
            f"a segment deviates by up to {SIZE} deg from the direction of growth: the kink would "
            f"have exceeded {LARGEST_KINK:g} deg, or the crack was led to a node beside its path "
            "that may not move, of a boundary, a crack or an interface; a smaller fracture.refine "
            "makes such a detour shorter",
            tip,
            size=deviation,
        )
    if body.motion is not None:
        ghost = scene.updated is not None and scene.updated.ghost > 0.0
        yield from _alarms(body, body.motion, balance, ghost=ghost)
    elif body.empty_elements:
        yield Doubt(
            f"growth.transfer: paper left up to {SIZE} triangles without a material point "
            "(empty_elements) and nodes without stiffness (floating_nodes), which were held; "
            "growth.transfer: domains leaves none",
            size=float(body.empty_elements),
        )


def _overlaps(body: Body, balance: Equilibrium) -> Iterator[Doubt]:
    """Find cracks whose faces overlap."""
    largest = np.abs(balance.displacement).max(initial=0.0)
    for name, opening in smallest_openings(body.grid, balance.displacement, balance.finite).items():
        if opening < -1e-6 * largest:
            fixed = body.motion is not None and body.motion.reset.fixed
            why = (
                "since a fixed grid has no contact; updated.grid: following has it (linear "
                "triangles only, mesh.element: T3)"
                if fixed
                else "where supports prescribe it: prescribe a displacement that leaves them apart"
            )
            yield Doubt(f"its faces overlap by up to {SIZE} mm {why}", name, -float(opening))


def _gap_of_work(body: Body, balance: Equilibrium) -> float:
    """Relative difference of the external work from the strain energy and the plastic work."""
    points = balance.points
    spent = float(points.energy @ points.volume)
    if points.internal_variables.size:
        spent += float(body.materials.plastic_work(points) @ points.volume)
    return abs(balance.external_work - spent) / max(abs(spent), 1e-300)


def _alarms(body: Body, motion: Motion, balance: Equilibrium, *, ghost: bool) -> Iterator[Doubt]:
    """Give the warnings about a grid that is reset."""
    if body.empty_elements:
        yield Doubt(
            f"up to {SIZE} triangles inside the body have lost material points (empty_elements): "
            "each acts as a hole or a mechanism, and its neighbours carry its volume. One such "
            "triangle already causes errors of some per cent in forces. updated.integration: "
            "domains avoids them (linear triangles, mesh.element: T3, and hyperelastic laws only)",
            size=float(body.empty_elements),
        )
    if motion.fill < LEAST_FILL and not ghost:
        yield Doubt(
            f"up to {SIZE} % of a triangle inside the body is empty (least_fill), so that its "
            "stiffness is close to zero; updated.ghost: 0.1 stabilises it (linear triangles only, "
            "mesh.element: T3)",
            size=100.0 * (1.0 - motion.fill),
        )
    least = float(_volume_ratios(body, balance).min())
    if least < LEAST_VOLUME:
        yield Doubt(
            f"a material point has lost up to {SIZE} % of its volume (min_det_F): the load "
            "compresses it so far, or the grid has separated from the material and crushes it; "
            "formulation: total, which does not reset the grid, shows which",
            size=100.0 * (1.0 - least),
        )


def _volume_ratios(body: Body, balance: Equilibrium) -> NDArray[np.float64]:
    """Ratio of current to reference volume that enters the law: the mean over each patch."""
    points = balance.points
    ratio = np.linalg.det(np.eye(2) + points.displacement_gradient)
    if body.patches is None:
        return ratio
    _, patch = np.unique(patch_of(body.patches, points), return_inverse=True)
    return np.bincount(patch, points.volume * ratio) / np.bincount(patch, points.volume)


def doubts_of_fixed_loads(
    body: Body, balance: Equilibrium, values: Mapping[str, NDArray[np.float64]]
) -> Iterator[Doubt]:
    """Find the tips without a load factor at fracture.

    Parameters
    ----------
    body : Body
    balance : Equilibrium
    values : mapping of str to (tip,) array
        From `evaluate_tips`.
    """
    if balance.parts is None or "critical_load_factor" not in values:
        return
    for tip, factor, k in zip(
        body.grid.tips, values["critical_load_factor"], values["K_I"], strict=True
    ):
        if np.isnan(factor) and not np.isnan(k):
            yield Doubt(
                "no critical_load_factor: the fixed loads alone reach g_c, or crack faces are in "
                "contact at that load, so that the states under fixed and under proportional loads "
                "cannot be superposed; smaller fixed loads leave one",
                tip.name,
            )


def doubts_at_tips(
    body: Body, balance: Equilibrium, values: Mapping[str, NDArray[np.float64]]
) -> Iterator[Doubt]:
    """Find the tips at which a grid that is reset has separated from the material.

    Parameters
    ----------
    body : Body
    balance : Equilibrium
    values : mapping of str to (tip,) array
        From `evaluate_tips` and `reference.compare`.
    """
    if body.motion is None:
        return
    energy = float(balance.points.energy @ balance.points.volume)
    for i, (tip, domain) in enumerate(zip(body.grid.tips, body.tip_domains, strict=True)):
        on_grid, material = values["cf_norm_grid"][i], values["cf_norm"][i]
        felt = NO_FORCE * energy / domain.clearance
        if abs(on_grid - material) > max(APART * material, felt):
            yield Doubt(
                "the configurational force on the grid differs from that on the material by up to "
                f"{SIZE} % (cf_norm_grid): both are unreliable; formulation: total does not reset "
                "the grid",
                tip.name,
                100.0 * float(abs(on_grid - material) / material),
            )
        if values["tip_drift"][i] > DRIFT * tip.h:
            yield Doubt(
                f"the crack tip of the grid is up to {SIZE} element sizes away from that of the "
                "material (tip_drift); updated.grid: following keeps them together (linear "
                "triangles only, mesh.element: T3)",
                tip.name,
                float(values["tip_drift"][i] / tip.h),
            )
