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
from cfmpm.mechanics import leans
from cfmpm.output.warnings.of_scene import doubts_before
from cfmpm.scene.model import Scene

# Largest accepted relative difference of external work and energies at finite deformation.
IMBALANCE = 0.01
# Largest angle between a segment and the direction of growth without a warning [deg].
DEVIATION = 5.0
# Limits for a grid that is reset (design study): smallest filled fraction of a triangle, smallest
# ratio of a point's volume to its initial volume, largest relative difference between the
# configurational forces of the two domains, largest drift at a tip in element sizes.
LEAST_FILL, LEAST_VOLUME, APART, DRIFT = 0.1, 0.5, 0.02, 0.25


def doubts(scene: Scene, body: Body, balance: Equilibrium) -> list[str]:
    """Give the warnings about one state of equilibrium.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body
    balance : Equilibrium

    Returns
    -------
    list of str
    """
    grid = body.grid
    found = doubts_before(scene, body)
    largest = np.abs(balance.displacement).max(initial=0.0)
    for name, opening in smallest_openings(grid, balance.displacement, balance.finite).items():
        if opening < -1e-6 * largest:
            fixed = body.motion is not None and body.motion.reset.fixed
            why = "since a fixed grid has no contact" if fixed else "where supports prescribe it"
            found.append(f"{name}: its faces overlap {why}")
    if balance.unstable_points > 0:
        found.append(
            f"from load factor {balance.unstable_from:.4g} on material points have lost "
            "ellipticity (unstable_points): results there depend on the grid, and finer grids "
            "become unstable at lower loads; material.law: ciarlet stays elliptic"
        )
    one_grid = body.motion is None and scene.growth is None
    if balance.finite and one_grid and not _adds_up(body, balance):
        found.append(
            "the external work, summed over the load steps, differs from the strain energy and "
            f"plastic work by more than {100 * IMBALANCE:g} % (external_work): increase load_steps"
        )
    if leans(body, balance):
        found.append(
            "the loads have a moment on the deformed body, as compressive loads do, and no support "
            "prevents the rotation: it was held, with a reaction moment"
        )
    if balance.residual_floor > 0.0:
        found.append(
            "the unbalanced force (residual_norm) is above the tolerance, limited by round-off; "
            "causes are a large contrast of stiffness, near incompressibility, or a slender "
            "ligament"
        )
    if body.grown.deviation > DEVIATION:
        found.append(
            f"a segment deviates by more than {DEVIATION:g} deg from the direction of growth: the "
            f"kink would have exceeded {LARGEST_KINK:g} deg, or the crack was led to a node beside "
            "its path that may not move"
        )
    if body.motion is not None:
        found += _alarms(body, body.motion, balance)
    elif body.empty_elements:
        found.append(
            "growth.transfer: paper left triangles without a material point (empty_elements) and "
            "nodes without stiffness (floating_nodes); these nodes were held"
        )
    return found


def _adds_up(body: Body, balance: Equilibrium) -> bool:
    """Whether the external work equals the strain energy and the plastic work within IMBALANCE."""
    points = balance.points
    spent = float(points.energy @ points.volume)
    if points.internal_variables.size:
        spent += float(body.materials.plastic_work(points) @ points.volume)
    return bool(abs(balance.external_work - spent) <= IMBALANCE * max(abs(spent), 1e-300))


def _alarms(body: Body, motion: Motion, balance: Equilibrium) -> Iterator[str]:
    """Give the warnings about a grid that is reset."""
    if body.empty_elements:
        yield (
            "triangles inside the body have lost material points (empty_elements): each acts as a "
            "hole or a mechanism, and its neighbours carry its volume. One such triangle already "
            "causes errors of some per cent in forces. updated.integration: domains avoids them "
            "(linear triangles, mesh.element: T3, and hyperelastic laws only)"
        )
    if motion.fill < LEAST_FILL:
        yield (
            f"material fills less than {100 * LEAST_FILL:g} % of a triangle inside the body "
            "(least_fill), whose stiffness is then close to zero; updated.ghost: 0.1 stabilises it "
            "(linear triangles only, mesh.element: T3)"
        )
    if _volume_ratios(body, balance).min() < LEAST_VOLUME:
        yield (
            f"the volume of a material point is below {100 * LEAST_VOLUME:g} % of its initial "
            "volume (min_det_F): points are crushed where the grid has separated from the material"
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
) -> Iterator[str]:
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
            yield (
                f"{tip.name}: no critical_load_factor: the fixed loads alone reach g_c, or crack "
                "faces are in contact at that load, so that the states under fixed and under "
                "proportional loads cannot be superposed"
            )


def doubts_at_tips(body: Body, values: Mapping[str, NDArray[np.float64]]) -> Iterator[str]:
    """Find the tips at which a grid that is reset has separated from the material.

    Parameters
    ----------
    body : Body
    values : mapping of str to (tip,) array
        From `evaluate_tips` and `reference.compare`.
    """
    if body.motion is None:
        return
    for i, tip in enumerate(body.grid.tips):
        on_grid, material = values["cf_norm_grid"][i], values["cf_norm"][i]
        if abs(on_grid - material) > APART * material:
            yield (
                f"{tip.name}: the configurational force on the grid differs from that on the "
                f"material by more than {100 * APART:g} % (cf_norm_grid): both are unreliable"
            )
        if values["tip_drift"][i] > DRIFT * tip.h:
            yield (
                f"{tip.name}: the crack tip of the grid is more than {DRIFT:g} element sizes away "
                "from that of the material (tip_drift); updated.grid: following keeps them "
                "together (linear triangles only, mesh.element: T3)"
            )
