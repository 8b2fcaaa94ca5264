"""Warnings of a run: which of its results are doubtful, why, and what to change."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cfmpm.body.body import Body
from cfmpm.body.crack_faces import smallest_openings
from cfmpm.body.motion import Motion
from cfmpm.body.tip_domains import FILL, RESOLVED
from cfmpm.body.volume_patches import patch_of
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.fracture.release import LARGEST_KINK
from cfmpm.mechanics import NEGLIGIBLE
from cfmpm.output.analysis import LIGAMENT, before_arrival, parts_of_gap
from cfmpm.registry.criteria import DIRECTIONS
from cfmpm.registry.laws import LAWS
from cfmpm.registry.loads import LOADS
from cfmpm.scene.families import expand
from cfmpm.scene.growth import Growth
from cfmpm.scene.model import Scene

# Range of material constants, rounded outwards: Young's modulus from gels (1e-3 MPa) to diamond
# (1e6 MPa), toughness from ice (0.003 N/mm) to pure ductile metals (1000 N/mm); Ashby and Jones,
# Engineering Materials 1, tables of Young's modulus and of toughness.
USUAL = {"E": (1e-3, 2e6, "MPa"), "g_c": (1e-3, 1e3, "N/mm")}
# Largest accepted relative difference of external work and energies at finite deformation.
IMBALANCE = 0.01
# Largest angle between a segment and the direction of growth without a warning [deg].
DEVIATION = 5.0
# Largest ratio of the element size at a tip to that at the start without a warning.
COARSER = 3.0
# Largest relative difference of J between domain radii without a warning. A difference below NO_J
# times the largest strain energy over the clearance is round-off.
OVER_RADII, NO_J = 0.1, 1e-6
# Largest relative difference of J and G, and largest relative energy gap, without a warning.
J_FROM_G = 0.05
OPEN_BALANCE = 0.05
# Limits for a grid that is reset (design study): smallest filled fraction of a triangle, smallest
# ratio of a point's volume to its initial volume, largest relative difference between the
# configurational forces of the two domains, largest drift at a tip in element sizes.
LEAST_FILL, LEAST_VOLUME, APART, DRIFT = 0.1, 0.5, 0.02, 0.25


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


def _by_finite(scene: Scene) -> str:
    """The keys that a scene needs for finite deformation, including those it requires besides."""
    growth = scene.growth
    needs = {
        "plane: strain": scene.plane == "strain",
        "growth.control: load": growth is None or growth.control == "load",
        "growth.direction: cf": growth is None or not DIRECTIONS[growth.direction].needs_k,
    }
    missing = [need for need, given in needs.items() if not given]
    return "kinematics: finite" + (f" (with {' and '.join(missing)})" if missing else "")


def _adds_up(body: Body, balance: Equilibrium) -> bool:
    """Whether the external work equals the strain energy and the plastic work within IMBALANCE."""
    points = balance.points
    spent = float(points.energy @ points.volume)
    if points.internal_variables.size:
        spent += float(body.materials.plastic_work(points) @ points.volume)
    return bool(abs(balance.external_work - spent) <= IMBALANCE * max(abs(spent), 1e-300))


def _leans(body: Body, balance: Equilibrium) -> bool:
    """Whether a rigid rotation held at nodes has a reaction at finite deformation."""
    places = tuple(body.loading.turning.T)
    if not balance.finite or not body.loading.turning.size:
        return False
    force = balance.internal_force - body.loading.at(balance.load_factor).force
    largest = np.abs(balance.internal_force).max(initial=0.0)
    return bool(np.abs(force[places]).max() > 1e-6 * largest)


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
    grid = body.grid
    found = [*unusual(scene), *body.loading.warnings]
    if not body.loading.any:
        found.append(
            "the body has no load, so that all results are zero: add a traction, a force, a "
            "displacement other than zero, or a body_force to loads"
        )
    if body.patches is not None and body.materials.plastic.any():
        found.append(
            "linear triangles (T3) are too stiff in plastic flow near the limit load, also with "
            "the volume change averaged over patches: use mesh.element: T6 (formulation: updated "
            "then needs grid: fixed)"
        )
    for tip, domain in zip(grid.tips, body.tip_domains, strict=True):
        if domain.cut_back:
            found.append(
                f"{tip.name}: requested domain radii were reduced to {FILL} of the clearance, the "
                "distance to the nearest object that a domain must not contain (domain_radius)"
            )
        if not domain.growing and max(domain.radii) < RESOLVED * tip.h:
            found.append(
                f"{tip.name}: the largest domain radius is below {RESOLVED:g} element sizes; "
                "refine the grid at the tip (mesh.grading.tip_size, or mesh.size)"
            )
    return found


def doubts_of_domains(history: xr.Dataset) -> list[str]:
    """Find the stationary crack tips at which J depends on the domain.

    Parameters
    ----------
    history : xarray.Dataset

    Returns
    -------
    list of str
        With the steps.
    """
    if not history.sizes["tip"]:
        return []
    plastic = bool(history["J_plastic"].notnull().any())
    J = history["J_radius"] + (history["J_plastic_radius"] if plastic else 0.0)
    spread = J.max("radius") - J.min("radius")
    largest = history["J"] + (history["J_plastic"] if plastic else 0.0)
    felt = NO_J * history["strain_energy"].max() / history["clearance"]
    far = (spread > OVER_RADII * abs(largest)) & (spread > felt)
    what = "the sum of J and J_plastic" if plastic else "J"
    why = (
        "plastic loading was not proportional, as in unloading"
        if plastic
        else "refine the grid at the tip"
    )
    return [
        f"{name}: {_steps(far.sel(tip=name).values)} {what} differs by more than "
        f"{100 * OVER_RADII:g} % between the domain radii, so that J depends on the domain: {why}"
        for name in history["tip"].values[far.any("step")]
    ]


def doubts_of_path(history: xr.Dataset, growth: Growth) -> list[str]:
    """Find steps of crack growth whose results are doubtful.

    Parameters
    ----------
    history : xarray.Dataset
    growth : Growth

    Returns
    -------
    list of str
        With the steps. Steps within the last elements before an arrival are ignored.
    """
    found = []
    for name in history["tip"].values:
        tip = history.sel(tip=name)
        h, clearance = tip["tip_size"].values, tip["clearance"].values
        before = before_arrival(tip)
        close = before & (clearance < LIGAMENT * h)
        if close.any():
            nearest = float(clearance[close].min())
            found.append(
                f"{name}: {_steps(close)} the clearance is down to {nearest:.3g} mm, less than "
                f"{LIGAMENT:g} element sizes, and the direction of growth is inaccurate; set "
                "fracture.refine to a third of the clearance, or reduce mesh.hole_size"
            )
        coarse = before & (h > COARSER * h[0])
        if coarse.any():
            found.append(
                f"{name}: {_steps(coarse)} the elements at the tip are up to "
                f"{np.nanmax(h[coarse]) / h[0]:.2g} times as large as at the start, since the tip "
                "has left the refined part of the grid; fracture.refine keeps the grid refined "
                "around the tip"
            )
        G, J = tip["G"].values, tip["J"].values
        border = np.isfinite(h) & np.isnan(tip["K_I"].values) & np.isfinite(J)
        if border.any() and np.isfinite(tip["K_I"]).any():
            found.append(
                f"{name}: {_steps(border)} the tip lies on the interface of two materials, where "
                "K_I and K_II are not defined; J is compared with g_c, and the crack grows "
                "straight ahead"
            )
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = np.where(before & ~close, np.abs(J / G - 1.0), 0.0)
        far = apart > J_FROM_G
        if far.any():
            found.append(
                f"{name}: {_steps(far)} J and G from K_I and K_II differ by up to "
                f"{100 * apart.max():.2g} %: the grid is too coarse; fracture.refine refines it "
                "around the growing tip. The first segments behind a kink keep this difference, "
                "since they are as short as an element on any grid"
            )
    if growth.control == "crack":
        found += _open_balance(history)
    return found


def _open_balance(history: xr.Dataset) -> list[str]:
    """Warn of an energy gap along the equilibrium path."""
    parts = parts_of_gap(history)
    if not max(parts) > OPEN_BALANCE:
        return []
    return [
        f"the energy balance has a gap of {100 * parts[1]:.2g} % of the fracture energy, "
        f"{100 * parts[0]:.2g} % of the external work, which measures the error of G along the "
        "path; reduce it by fracture.refine or a smaller mesh.size"
    ]


def _steps(where: NDArray[np.bool_]) -> str:
    """Name the range of steps from the first to the last marked one."""
    first, last = np.flatnonzero(where)[[0, -1]] + 1
    return f"in step {first}" if first == last else f"in steps {first} to {last}"


def doubts(scene: Scene, body: Body, balance: Equilibrium, scale: float = 1.0) -> list[str]:
    """Give the warnings about one state of equilibrium.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body
    balance : Equilibrium
    scale : float
        Factor by which its stresses are multiplied.

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
    if balance.finite_effect * abs(scale) > NEGLIGIBLE:
        found.append(
            "finite deformation is neglected, but would change the strain energy by more than "
            f"{100 * NEGLIGIBLE:g} % (finite_effect); {_by_finite(scene)} takes it into account"
        )
    one_grid = body.motion is None and scene.growth is None
    if balance.finite and one_grid and not _adds_up(body, balance):
        found.append(
            "the external work, summed over the load steps, differs from the strain energy and "
            f"plastic work by more than {100 * IMBALANCE:g} % (external_work): increase load_steps"
        )
    if _leans(body, balance):
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
