"""What holds in every step, whatever the scene: loads balance reactions, and no energy appears."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.output.analysis import in_steps
from cfmpm.output.warnings.of_scene import BETTER_CONDITIONED

# Forces, relative to modulus times displacement, below which all is the round-off of a motion of
# parts as a whole.
FELT = 1e-6
# Part of the size of a body by which the centre of a part moves as the grid changes.
NEAR = 0.05
# What is worth a warning: resultant over the largest force, and energy that a segment takes where
# it can only set it free, over the largest so far (the grid changes with each segment).
IMBALANCE, FROM_NOTHING = 1e-9, 1e-3


def force_imbalance(body: Body, balance: Equilibrium) -> float:
    """Compare the resultant of all loads and reactions with the largest of them.

    Parameters
    ----------
    body : Body
    balance : Equilibrium
        Of the body.

    Returns
    -------
    float
        Resultant of the loads and of what their supports exert, at small strain also its moment
        over the size of the body, over the largest force at a loaded part. What the program holds
        rigid motions by is not among them: a force there shows here. At finite deformation they
        are where a rotation is held, which a warning tells (`mechanics.leans`): by a couple, whose
        forces are those of a hold and of a support or another hold. nan where the grid is reset,
        as springs carry loads there.
    """
    if body.motion is not None:
        return math.nan
    loading = body.loading
    applied = loading.at(balance.load_factor)
    held = balance.internal_force - applied.force - balance.contact_force
    supported = loading.supported
    if balance.finite and loading.holds.turning.size:
        supported = supported.copy()
        # A moment is held by the forces of a couple, at two of them.
        supported[tuple(loading.holds.places.T)] = True
    reaction = np.where(supported, held, 0.0)
    acting = applied.force + reaction
    parts = [np.abs(applied.own_weight).sum(axis=0)]
    parts += [
        part.force_at(balance.load_factor).sum(axis=0)
        + np.where(part.holds, reaction[part.nodes], 0.0).sum(axis=0)
        for part in loading.boundaries.values()
    ]
    largest = max(float(np.hypot(*part)) for part in parts)
    moved = np.abs(balance.displacement).max(initial=0.0)
    scale = max(largest, FELT * float(body.materials.elastic.max()) * moved)
    along_x, along_y = np.ascontiguousarray(acting.T)
    resultant = math.hypot(along_x.sum(), along_y.sum())
    if not balance.finite:
        x, y = np.ascontiguousarray(body.grid.nodes.T)
        moment = abs(float(((x - x.mean()) * along_y - (y - y.mean()) * along_x).sum()))
        resultant = max(resultant, moment / body.grid.diagonal)
    return resultant / scale if scale > 0.0 else 0.0


def violations(history: xr.Dataset) -> Iterator[str]:
    """Name the steps in which loads miss reactions, or energy appears from nothing.

    Parameters
    ----------
    history : xarray.Dataset
    """
    stored, work = (np.abs(history[name].values) for name in ("strain_energy", "external_work"))
    largest = np.fmax.accumulate(np.fmax(stored, work))
    missed = history["force_imbalance"].values
    # Energy goes with the square of the forces: a body that has come apart carries round-off.
    out = (missed > IMBALANCE) & (stored > IMBALANCE**2 * largest)
    if out.any():
        yield (
            f"{in_steps(out)} loads and reactions are out of balance by up to "
            f"{np.nanmax(missed):.1e} of the largest (force_imbalance), more than {IMBALANCE:g}: "
            f"forces there are wrong by so much; {BETTER_CONDITIONED}"
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        gained = -history["released_energy"].values / largest
    out = gained > FROM_NOTHING
    if out.any():
        yield (
            f"{in_steps(out)} the last segments have not set energy free but taken up to "
            f"{np.nanmax(gained):.1e} of the largest so far (released_energy), which the longer "
            "crack cannot: a smaller mesh.size makes that less, and mesh.element: T6 where "
            "elements are linear"
        )


def came_off(body: Body, step: int, known: list[Floats]) -> Iterator[str]:
    """Name the parts that have come off a body and that no support holds.

    Parameters
    ----------
    body : Body
    step : int
    known : list of (2,) float
        Centres of those named already; new ones are added.
    """
    reach = NEAR * body.grid.diagonal
    for part in body.loading.holds.free_parts:
        x, y = part.centre
        if any(math.hypot(x - a, y - b) < reach for a, b in known):
            continue
        known.append(part.centre)
        area = body.grid.areas[np.isin(body.grid.triangles, part.nodes).all(axis=1)].sum()
        yield (
            f"from step {step} on the part of the body around ({x:.4g}, {y:.4g}), of "
            f"{area:.3g} mm^2, is cut off, and no support holds all its motions (free_parts): "
            "contact moves it away, and holds it only where it is wedged in; its place is one of "
            "many, and a tip in it that carries nothing has no values; a smaller growth.increments "
            "ends the run before"
        )
