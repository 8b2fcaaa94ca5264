"""Warnings about a whole history: domains of stationary tips, and paths of growing ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from cfmpm.fracture.finite_effect import NEGLIGIBLE
from cfmpm.fracture.ties import grid_error
from cfmpm.output.analysis import (
    LIGAMENT,
    Floats,
    before_arrival,
    by_about,
    in_steps,
    parts_of_gap,
    runs_at_object,
)
from cfmpm.output.warnings.of_scene import finer_at_tips, rounded_down
from cfmpm.registry.criteria import DIRECTIONS
from cfmpm.registry.laws import LAWS
from cfmpm.scene.growth import Growth
from cfmpm.scene.model import Scene

# Effect of finite deformation above which small strain is no approximation of it.
FAR = 0.1
# Largest ratio of the element size at a tip to that at the start without a warning.
COARSER = 3.0
# Largest relative difference of J between domain radii without a warning. A difference below NO_J
# times the largest strain energy over the clearance is round-off.
OVER_RADII, NO_J = 0.1, 1e-6
# Largest relative difference of J and G, of stationary and of growing tips, and largest relative
# energy gap, without a warning.
J_FROM_G, J_FROM_G_GROWING = 0.03, 0.05
OPEN_BALANCE = 0.05
# What `before_arrival` needs of a tip.
PLACE = ("tip_x", "tip_y", "tip_size", "tip_status")


def doubts_of_end(history: xr.Dataset, growth: Growth) -> list[str]:
    """Warn of growth that ended by the default number of increments, which nobody has chosen.

    Parameters
    ----------
    history : xarray.Dataset
    growth : Growth

    Returns
    -------
    list of str
    """
    default = Growth.model_fields["increments"].default
    if history.attrs["run_status"] != "increments" or growth.increments != default:
        return []
    return [
        f"the run ended after {default} increments, the default of growth.increments, while a "
        "crack could still grow: increase growth.increments to follow it to its end"
    ]


def doubts_of_kinematics(history: xr.Dataset, scene: Scene, *, finite: bool) -> list[str]:
    """Warn of finite deformation that is neglected, and of K that it takes away unasked.

    Parameters
    ----------
    history : xarray.Dataset
    scene : Scene
        Expanded.
    finite : bool
        Whether the run used finite deformation.

    Returns
    -------
    list of str
        With the steps.
    """
    effect = np.abs(history["finite_effect"].values)
    if not finite:
        return _of_neglected(history, effect, scene)
    if scene.kinematics != "auto":
        return []
    lost = np.isnan(history["K_I"].values) & ~np.isnan(history["J"].values)
    in_J = np.fmax.reduce(np.abs(history["finite_effect_J"].values), axis=0)
    backwards = bool((history["load_factor"].values < 0.0).any())
    return [
        f"{name}: {in_steps(lost[:, i])} no K_I, K_II and T at finite "
        "deformation, which kinematics: auto chose, since strain around the tip is not small, or "
        "its faces are in contact or bend within the domain; G is J. "
        + _way_to_k(np.nanmax(effect), in_J[i], backwards=backwards)
        for i, name in enumerate(history["tip"].values)
        if lost[:, i].any()
    ]


def _way_to_k(effect: float, in_J: float, *, backwards: bool) -> str:
    """How to have K by small strain, if that is near enough to be of use.

    Parameters
    ----------
    effect, in_J : float
        Largest effects of finite deformation on the energy and on J; nan where it is unknown.
    backwards : bool
        Whether a load factor is negative, which small strain does not take.
    """
    if np.fmax(effect, in_J) > FAR:
        return "A smaller load keeps K: at this one small strain is no approximation"
    if backwards:
        return "kinematics: small gives K for each sense of the load alone, in a run of its own"
    of_J, name = ("", "") if np.isnan(in_J) else (f" and a J that is {100 * in_J:.2g} %", "_J")
    return (
        f"kinematics: small gives K, with a strain energy that is {100 * effect:.2g} %{of_J} off "
        f"at the largest load (finite_effect{', finite_effect' + name if name else ''})"
    )


def _of_neglected(history: xr.Dataset, effect: NDArray[np.float64], scene: Scene) -> list[str]:
    """Warn of finite deformation that is neglected, in one sentence on energy and one on J."""
    in_J = history["finite_effect_J"].values
    felt = np.abs(in_J) > NEGLIGIBLE
    changes = []
    if (effect > NEGLIGIBLE).any():
        size = by_about(float(np.nanmax(effect)), "finite_effect")
        changes.append((effect > NEGLIGIBLE, f"the strain energy {size}"))
    if felt.any():
        sizes = [
            f"{by_about(column[np.nanargmax(np.abs(column))], 'finite_effect_J')} at {name}"
            for name, column in zip(history["tip"].values, in_J.T, strict=True)
            if (np.abs(column) > NEGLIGIBLE).any()
        ]
        said = f"J {', '.join(sizes)}, and K by half of that"
        changes.append((felt.any(axis=1), said))
    return [
        f"{in_steps(where)} finite deformation is neglected, which would change {change}; "
        f"{_by_finite(scene)}"
        for where, change in changes
    ]


def _by_finite(scene: Scene) -> str:
    """How to take finite deformation into account, or to see its size."""
    growth = scene.growth
    needs = {
        "plane: strain": scene.plane == "strain",
        "growth.control: load": growth is None or growth.control == "load",
        "growth.direction: cf": growth is None or not DIRECTIONS[growth.direction].needs_k,
    }
    missing = [need for need, given in needs.items() if not given]
    if not missing:
        return "kinematics: finite takes it into account"
    # Other keys make another problem of it: they are no remedy.
    rest = "without growth, at the load of the step, " if growth is not None else ""
    plane = "and plane: strain " if scene.plane != "strain" else ""
    return (
        f"kinematics: finite needs {' and '.join(missing)}; to see the size, compare kinematics: "
        f"small and finite {rest}{plane}".rstrip(", ")
    )


def doubts_of_domains(history: xr.Dataset, scene: Scene) -> list[str]:
    """Find the stationary crack tips at which J depends on the domain.

    Parameters
    ----------
    history : xarray.Dataset
    scene : Scene
        Expanded.

    Returns
    -------
    list of str
        With the steps.
    """
    if not history.sizes["tip"]:
        return []
    # xarray's own arithmetic takes longer than the solve of a small scene.
    plastic = not np.isnan(history["J_plastic"].values).all()
    J, largest = (
        history[f"J{of}"].values + (history[f"J_plastic{of}"].values if plastic else 0.0)
        for of in ("_radius", "")
    )
    spread = np.fmax.reduce(J, axis=-1) - np.fmin.reduce(J, axis=-1)
    h = history["tip_size"].values
    felt = NO_J * np.fmax.reduce(history["strain_energy"].values) / history["clearance"].values
    far = (spread > OVER_RADII * np.abs(largest)) & (spread > felt)
    what = "the sum of J and J_plastic" if plastic else "J"
    unstable = np.fmax.reduce(history["unstable_points"].values) > 0.0
    found = []
    for i in np.flatnonzero(far.any(axis=0)):
        where = far[:, i]
        size = 100.0 * float(np.max(spread[where, i] / np.abs(largest[where, i])))
        if plastic:
            why = (
                "plastic loading was not proportional there, as near the tip and in unloading: "
                "give larger fracture.radii, or end load_steps before"
            )
        elif unstable and not LAWS[scene.material.law].elliptic:
            why = (
                "points around the tip have lost ellipticity, and smaller elements lose it at "
                "lower loads; material.law: ciarlet stays elliptic"
            )
        else:
            why = finer_at_tips(scene, 0.5 * float(h[where, i].min()))
            if (history["contact_pairs"].values[where] > 0.0).any():
                why += ", and give smaller fracture.radii, since crack faces are in contact"
        found.append(
            f"{history['tip'].values[i]}: {in_steps(where)} {what} differs by up to {size:.2g} % "
            f"between the domain radii, so that J depends on the domain: {why}"
        )
    return found


def doubts_of_release_rates(history: xr.Dataset, scene: Scene) -> list[str]:
    """Find the tips at which J and G from K_I and K_II differ by more than their stated errors.

    The errors are the ranges over the domain radii, and a part of the larger value for the grid. J
    and G are different sums over the same points: where they differ, at least one of them is wrong.
    Where K has been set to zero, J is told that is above its range and `G_floor`.

    Parameters
    ----------
    history : xarray.Dataset
    scene : Scene

    Returns
    -------
    list of str
        With the steps. Steps within the last elements before an arrival are ignored.
    """
    growth = scene.growth
    part = J_FROM_G if growth is None else J_FROM_G_GROWING
    found = []
    for i, name in enumerate(history["tip"].values):
        J, G, K_I, K_II, x, y, h, status = (
            history[of].values[:, i] for of in ("J", "G", "K_I", "K_II", *PLACE)
        )
        larger = np.maximum(np.abs(J), np.abs(G))
        error = part * larger
        for of in ("J_spread", "G_spread"):
            if of in history:
                error = error + np.nan_to_num(history[of].values[:, i])
        counts = np.ones(len(J), bool)
        if growth is not None:
            counts = before_arrival(x, y, h, status)
        none = (K_I == 0.0) & (K_II == 0.0)
        if "G_floor" in history:
            floor = np.nan_to_num(history["G_floor"].values[:, i])
            error = error + np.where(none, floor, 0.0)
        alone = none & (np.abs(J) > error) & counts
        if alone.any():
            largest = float(np.abs(J[alone]).max())
            way = _finer(scene, x, y, h, alone)
            found.append(
                f"{name}: {in_steps(alone)} J is up to {largest:.3g} N/mm, more than its error, "
                "while K_I and K_II are too small for the stress around the tip and set to 0: the "
                f"grid is too coarse {way}"
            )
        # Without K, G is J.
        far = (np.abs(J - G) > error) & np.isfinite(K_I) & counts & ~none
        if far.any():
            largest = 100.0 * float((np.abs(J - G)[far] / larger[far]).max())
            way = _finer(scene, x, y, h, far)
            found.append(
                f"{name}: {in_steps(far)} J and G from K_I and K_II differ by up to {largest:.2g} "
                "% of the larger one, more than their errors, so that at least one of them is "
                f"wrong: the grid is too coarse {way}"
            )
    return found


def doubts_of_held_tips(history: xr.Dataset, scene: Scene) -> list[str]:
    """Find the closed tips without K that `G_floor` holds back although J is above g_c.

    Parameters
    ----------
    history : xarray.Dataset
    scene : Scene
        Expanded.

    Returns
    -------
    list of str
        With the steps.
    """
    regions = scene.geometry.regions if scene.geometry is not None else []
    given = [scene.material.g_c, *(region.material.g_c for region in regions)]
    least = min((g_c for g_c in given if g_c is not None), default=np.inf)
    if "G_floor" not in history:
        return []
    J, floor = history["J"].values, history["G_floor"].values
    x, y, h, _ = (history[of].values for of in PLACE)
    held = (least <= J) & (floor >= J) & np.isnan(history["K_I"].values)
    held &= history["contact_pressure"].values > 0.0
    return [
        f"{name}: {in_steps(held[:, i])} J is up to {J[held[:, i], i].max():.3g} N/mm, not less "
        f"than g_c, but within its error, G_floor of {floor[held[:, i], i].max():.3g} N/mm, of a "
        "tip that is pressed shut, so that it does not grow: the grid is too coarse "
        f"{_finer(scene, x[:, i], y[:, i], h[:, i], held[:, i])}"
        for i, name in enumerate(history["tip"].values)
        if held[:, i].any()
    ]


def _finer(scene: Scene, x: Floats, y: Floats, h: Floats, where: NDArray[np.bool_]) -> str:
    """Advise a finer grid around a tip in some steps, from its places and element sizes [mm]."""
    at_rest, running = _sizes(scene, x, y, 0.5 * h, where)
    ways = [f"at the tip, or at a kink of the crack: {at_rest}"] if at_rest else []
    if running:
        ways.append(
            f"around the growing tip: {running}. The first segments behind a kink keep this "
            "difference, since they are as short as an element on any grid"
        )
    return "; ".join(ways)


def _sizes(
    scene: Scene, x: Floats, y: Floats, size: Floats, where: NDArray[np.bool_]
) -> tuple[str, str]:
    """Advise element sizes [mm] for those of some steps before and after a tip has grown.

    Before, it is in the grid of the start, which fracture.refine leaves as it is.
    """
    at_rest = where & (x == x[0]) & (y == y[0])
    running = where & ~at_rest
    return (
        finer_at_tips(scene, float(size[at_rest].min())) if at_rest.any() else "",
        f"set fracture.refine to at most {rounded_down(float(size[running].min()))} mm"
        if running.any()
        else "",
    )


def doubts_of_path(history: xr.Dataset, scene: Scene, growth: Growth) -> list[str]:
    """Find steps of crack growth whose results are doubtful.

    Parameters
    ----------
    history : xarray.Dataset
    scene : Scene
        Expanded.
    growth : Growth

    Returns
    -------
    list of str
        With the steps. Steps within the last elements before an arrival are ignored, and so is a
        small clearance where a tip runs at an object.
    """
    found = []
    for i, name in enumerate(history["tip"].values):
        clearance, x, y, h, status = (history[of].values[:, i] for of in ("clearance", *PLACE))
        before = before_arrival(x, y, h, status)
        close = before & (clearance < LIGAMENT * h) & ~runs_at_object(x, y, clearance)
        if close.any():
            ways = _sizes(scene, x, y, 0.5 * clearance / LIGAMENT, close)
            found.append(
                f"{name}: {in_steps(close)} the clearance is down to {clearance[close].min():.3g} "
                f"mm, less than {LIGAMENT:g} element sizes, and the direction of growth is "
                f"inaccurate; {' and '.join(filter(None, ways))}"
            )
        # Who sets fracture.refine has chosen the size at the tip.
        chosen = scene.fracture.refine is not None
        coarse = before & (h > COARSER * h[0]) & (not chosen)
        if coarse.any():
            found.append(
                f"{name}: {in_steps(coarse)} the elements at the tip are up to "
                f"{np.nanmax(h[coarse]) / h[0]:.2g} times as large as at the start, since the tip "
                f"has left the refined part of the grid; fracture.refine: {rounded_down(h[0])} "
                "keeps it refined around the tip"
            )
    if growth.control == "crack":
        found += _ties(history, growth) + _open_balance(history)
    return found


def _ties(history: xr.Dataset, growth: Growth) -> list[str]:
    """Warn where the grid decides which tip grows first."""
    tied, names = history["tied"].values > 0.0, history["tip"].values
    error = grid_error({name: history[name].values for name in ("J_radius", "G_radius")})
    found = []
    for group in np.unique(tied[tied.any(axis=1)], axis=0):
        steps = (tied == group).all(axis=1)
        # Of a load, half of that of the energy release rate; twice, for two tips.
        size = 100.0 * float(error[steps][:, group].max())
        way = (
            "they grow together, by equal lengths. Tips that are not meant to be alike are told "
            "apart by a finer grid (smaller mesh.size); growth.tips: largest lets one grow alone"
            if growth.tips == "all"
            else "growth.tips: largest lets one of them grow alone; growth.tips: all lets them "
            "grow together"
        )
        found.append(
            f"{_listed(names[group].tolist())}: {in_steps(steps)} the loads at which they reach "
            f"g_c agree within the error of the grid, {size:.2g} % at most (J, G and their range "
            f"over the domain radii), so that the grid decides which grows first: {way}"
        )
    return found


def _listed(names: Sequence[str]) -> str:
    """Name things in a sentence."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _open_balance(history: xr.Dataset) -> list[str]:
    """Warn of an energy gap along the equilibrium path."""
    parts = parts_of_gap(history)
    if not max(parts) > OPEN_BALANCE:
        return []
    return [
        f"the energy balance has a gap of {100 * parts[1]:.2g} % of the fracture energy, "
        f"{100 * parts[0]:.2g} % of the external work, which measures the error of G along the "
        f"path, of the size of the segments: {_smaller_segments(history)}"
    ]


def _smaller_segments(history: xr.Dataset) -> str:
    """Advise segments, and elements, of half the size."""
    h = 0.5 * float(np.nanmin(history["tip_size"].values))
    return f"set fracture.refine to at most {rounded_down(h)} mm"
