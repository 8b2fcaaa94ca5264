"""What is doubtful about the numbers of a run, said by the run itself."""

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

# What materials have, widened to round numbers: Young's modulus from gels (1e-3 MPa) to
# diamond (1e6 MPa), toughness from ice (0.003 N/mm) to pure ductile metals (1000 N/mm); Ashby and
# Jones, Engineering Materials 1, tables of Young's modulus and of toughness.
USUAL = {"E": (1e-3, 2e6, "MPa"), "g_c": (1e-3, 1e3, "N/mm")}
# Part of the work of the loads that the energies may miss at finite deformation.
IMBALANCE = 0.01
# Angle between a segment and the direction asked for [deg] that is worth a warning.
DEVIATION = 5.0
# How much larger than at the start the elements at a tip may become.
COARSER = 3.0
# Difference of J over the domain radii that is worth a warning, as a part of itself; and how small
# it must be, as a part of the largest energy over the clearance, for J to be nothing but round-off.
OVER_RADII, NO_J = 0.1, 1e-6
# Differences of J from G, and of work from what it went into, that are worth one.
J_FROM_G = 0.05
OPEN_BALANCE = 0.05
# Of a grid that is reset (design study): how full a triangle is, what is left of a point's volume,
# how far two domains of the configurational force are apart, and element sizes of drift at a tip.
LEAST_FILL, LEAST_VOLUME, APART, DRIFT = 0.1, 0.5, 0.02, 0.25


def ways_on(scene: Scene, balance: Equilibrium) -> list[str]:
    """Say what may lead further where a run has lost its stability.

    Parameters
    ----------
    scene : Scene
    balance : Equilibrium
        The last stable one.
    """
    found = []
    if not all(LOADS[load.kind].holds for load in expand(scene).loads):
        found.append("Prescribed displacements lead past a largest load; forces do not.")
    law = LAWS[scene.material.law]
    if balance.unstable_points > 0 and not (law.elliptic or law.plastic):
        found.append("material.law: ciarlet keeps the ellipticity that points have lost.")
    if scene.formulation == "updated":
        found.append("formulation: total has no grid that a body could leave or tear.")
    if scene.growth is not None:
        found.append(
            "Behind a running tip triangles are stretched most: mesh.grading: uniform and "
            "mesh.element: T3 bear more."
        )
    return found or ["Fewer loads, or a body that does not buckle, keep it stable."]


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


def _by_finite(scene: Scene) -> str:
    """What leads to finite deformation, with all without which the scene would be refused."""
    growth = scene.growth
    needs = {
        "plane: strain": scene.plane == "strain",
        "growth.control: load": growth is None or growth.control == "load",
        "growth.direction: cf": growth is None or not DIRECTIONS[growth.direction].needs_k,
    }
    missing = [need for need, given in needs.items() if not given]
    return "kinematics: finite" + (f", with {' and '.join(missing)}," if missing else "")


def _adds_up(body: Body, balance: Equilibrium) -> bool:
    """Whether the work of the loads is what is stored and what plastic flow has taken."""
    points = balance.points
    spent = float(points.energy @ points.volume)
    if points.internal_variables.size:
        spent += float(body.materials.plastic_work(points) @ points.volume)
    return bool(abs(balance.external_work - spent) <= IMBALANCE * max(abs(spent), 1e-300))


def _leans(body: Body, balance: Equilibrium) -> bool:
    """Whether a rotation that the program holds carries a force at finite deformation."""
    places = tuple(body.loading.turning.T)
    if not balance.finite or not body.loading.turning.size:
        return False
    force = balance.internal_force - body.loading.at(balance.load_factor).force
    largest = np.abs(balance.internal_force).max(initial=0.0)
    return bool(np.abs(force[places]).max() > 1e-6 * largest)


def doubts_before(scene: Scene, body: Body) -> list[str]:
    """Name what is doubtful already before a solve.

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
            "nothing loads the body, so all results are zero: give loads a traction, a force or a "
            "displacement other than zero, or a body_force"
        )
    if body.patches is not None and body.materials.plastic.any():
        found.append(
            "T3 with plastic flow stays too stiff near the limit load, averaged over pairs of "
            "triangles or not: take mesh.element: T6, which under formulation: updated goes with "
            "grid: fixed"
        )
    for tip, domain in zip(grid.tips, body.tip_domains, strict=True):
        if domain.cut_back:
            found.append(
                f"{tip.name}: radii asked for were cut back to {FILL} of the distance to what a "
                "domain must not hold (domain_radius)"
            )
        if not domain.growing and max(domain.radii) < RESOLVED * tip.h:
            found.append(
                f"{tip.name}: its domain reaches over few elements; make the grid finer there "
                "(mesh.grading.tip_size, or mesh.size)"
            )
    return found


def doubts_of_domains(history: xr.Dataset) -> list[str]:
    """Name the stationary tips at which J depends on the domain that it is summed over.

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
        "plastic flow out of proportion to the load, as in unloading, makes it so"
        if plastic
        else "smaller elements at the tip make it depend less"
    )
    return [
        f"{name}: {_steps(far.sel(tip=name).values)} {what} differs by more than "
        f"{100 * OVER_RADII:g} % of itself over the domain radii: J depends on the domain there: "
        f"{why}"
        for name in history["tip"].values[far.any("step")]
    ]


def doubts_of_path(history: xr.Dataset, growth: Growth) -> list[str]:
    """Name what is doubtful about the way that cracks have run.

    Parameters
    ----------
    history : xarray.Dataset
    growth : Growth

    Returns
    -------
    list of str
        With the steps. What happens within the last elements before an arrival is left out.
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
                f"{name}: {_steps(close)} it passes in {nearest:.3g} mm what no domain may hold, "
                f"less than {LIGAMENT:g} elements: its direction is coarse there; fracture.refine "
                "of a third of that, or mesh.hole_size, resolves it"
            )
        coarse = before & (h > COARSER * h[0])
        if coarse.any():
            found.append(
                f"{name}: {_steps(coarse)} the elements at the tip are up to "
                f"{np.nanmax(h[coarse]) / h[0]:.2g} times as large as at the start: it has left "
                "the fine grid; fracture.refine takes it along"
            )
        G, J = tip["G"].values, tip["J"].values
        border = np.isfinite(h) & np.isnan(tip["K_I"].values) & np.isfinite(J)
        if border.any() and np.isfinite(tip["K_I"]).any():
            found.append(
                f"{name}: {_steps(border)} it lies on the border of two materials, where K_I and "
                "K_II mean nothing: J is compared with g_c, and it runs straight on"
            )
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = np.where(before & ~close, np.abs(J / G - 1.0), 0.0)
        far = apart > J_FROM_G
        if far.any():
            found.append(
                f"{name}: {_steps(far)} J and G from K_I and K_II differ by up to "
                f"{100 * apart.max():.2g} %: the grid is too coarse there; fracture.refine makes "
                "it finer around the running tip, but for the first segments behind a kink, which "
                "are as short as an element on any grid"
            )
    if growth.control == "crack":
        found += _open_balance(history)
    return found


def _open_balance(history: xr.Dataset) -> list[str]:
    """Warn of energy that the equilibrium path gains or loses."""
    parts = parts_of_gap(history)
    if not max(parts) > OPEN_BALANCE:
        return []
    return [
        f"the balance of energy is open by {100 * parts[1]:.2g} % of g_c times new length, "
        f"{100 * parts[0]:.2g} % of the work: by so much G is wrong on the way; fracture.refine, "
        "or a smaller mesh.size, closes it"
    ]


def _steps(where: NDArray[np.bool_]) -> str:
    """The steps from the first to the last one."""
    first, last = np.flatnonzero(where)[[0, -1]] + 1
    return f"in step {first}" if first == last else f"in steps {first} to {last}"


def doubts(scene: Scene, body: Body, balance: Equilibrium, scale: float = 1.0) -> list[str]:
    """Name what makes the numbers of a state of balance doubtful.

    Parameters
    ----------
    scene : Scene
        Expanded.
    body : Body
    balance : Equilibrium
    scale : float
        What its stresses are multiplied with.

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
            f"itself (finite_effect); {_by_finite(scene)} takes it into account"
        )
    one_grid = body.motion is None and scene.growth is None
    if balance.finite and one_grid and not _adds_up(body, balance):
        found.append(
            "the work of the loads, summed step by step, differs from the energies by more than "
            f"{IMBALANCE:g} of itself (external_work): more load_steps make it better"
        )
    if _leans(body, balance):
        found.append(
            "the loads have a moment on the deformed body that turns it away, as those in "
            "compression do: its rotation, which no support holds, was held and carries that moment"
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
        found += _alarms(body, body.motion, balance)
    elif body.empty_elements:
        found.append(
            "growth.transfer: paper left triangles without a material point (empty_elements), and "
            "nodes without stiffness (floating_nodes), which were held"
        )
    return found


def _alarms(body: Body, motion: Motion, balance: Equilibrium) -> Iterator[str]:
    """Name what is wrong with the grid that a body was reset on."""
    if body.empty_elements:
        yield (
            "triangles inside the body have lost material points (empty_elements): each is a hole "
            "or a mechanism, and its neighbours carry its volume; forces are wrong by some per "
            "cent and more from the first of them on; updated.integration: domains has none, "
            "which needs mesh.element: T3 and does not go with j2"
        )
    if motion.fill < LEAST_FILL:
        yield (
            f"material fills less than {LEAST_FILL:g} of a triangle inside the body (least_fill), "
            "which is nearly without stiffness; updated.ghost: 0.1, which needs mesh.element: T3, "
            "stabilises it"
        )
    if _volume_ratios(body, balance).min() < LEAST_VOLUME:
        yield (
            f"a material point has less than {LEAST_VOLUME:g} of its volume left (min_det_F): "
            "points are crushed where the grid has come apart from them"
        )


def _volume_ratios(body: Body, balance: Equilibrium) -> NDArray[np.float64]:
    """Volume over that of the reference, as the material feels it: a mean over each patch."""
    points = balance.points
    ratio = np.linalg.det(np.eye(2) + points.displacement_gradient)
    if body.patches is None:
        return ratio
    _, patch = np.unique(patch_of(body.patches, points), return_inverse=True)
    return np.bincount(patch, points.volume * ratio) / np.bincount(patch, points.volume)


def doubts_of_fixed_loads(
    body: Body, balance: Equilibrium, values: Mapping[str, NDArray[np.float64]]
) -> Iterator[str]:
    """Name the tips of which no load factor at fracture is known.

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
                "faces press on each other at that load, where the state is no sum of the one "
                "under fixed and the one under proportional loads"
            )


def doubts_at_tips(body: Body, values: Mapping[str, NDArray[np.float64]]) -> Iterator[str]:
    """Name the tips at which a grid that is reset has come apart from the material.

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
                f"material by more than {100 * APART:g} % (cf_norm_grid): neither is to be trusted"
            )
        if values["tip_drift"][i] > DRIFT * tip.h:
            yield (
                f"{tip.name}: the material has moved by more than a quarter of an element past the "
                "tip of the grid (tip_drift): the crack of the grid is not where that of the "
                "material is; updated.grid: following, which needs mesh.element: T3, keeps them "
                "together"
            )
