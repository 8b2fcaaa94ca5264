"""Work of the loads from one step to the next, and the energy that growth releases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats
from cfmpm.body.loads import Loading
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.output.history import StepRecord


def work_after(
    last: StepRecord | None, body: Body, balance: Equilibrium, factor: float, *, jumped: bool
) -> float:
    """Return the external work since the start, by the trapezoidal rule over the steps [N].

    Parameters
    ----------
    last : StepRecord or None
        The step before; None in the first one.
    body : Body
    balance : Equilibrium
        Of the body, at small strain.
    factor : float
        Load factor of the step.
    jumped : bool
        Whether a last ligament has broken since the step before. It breaks at the load factor of
        that step, which changes afterwards.

    Returns
    -------
    float
        The work of fixed loads follows from the displacement alone; in the first step they are
        increased together with the proportional loads.
    """
    now = conjugates(body, balance, balance.scale(factor))
    work, last_factor, before = 0.0, 0.0, (0.0, 0.0, 0.0)
    if last is not None:
        work = float(last.values["external_work"])
        last_factor, before = last.load_factor, last.conjugates
    elif not balance.proportional:
        work = 0.5 * (_work_on_fixed_grips(body, balance) - now[2])
    broken = _conjugates_at(body, balance, factor, last_factor) if jumped else None
    if broken is not None:
        work += last_factor * (broken[0] - before[0]) + (broken[2] - before[2])
        before = broken
    work += 0.5 * (factor + last_factor) * (now[0] - before[0]) + (now[2] - before[2])
    return work + 0.5 * (now[1] + before[1]) * (factor - last_factor)


def released(steps: Sequence[StepRecord], body: Body, balance: Equilibrium, factor: float) -> float:
    """Energy that the last segments have set free at the load before; see `VARIABLES` [N]."""
    if not steps or not body.grown.segments:
        return np.nan
    last = steps[-1]
    if balance.finite:
        if balance.load_factor != last.load_factor:
            return np.nan
        spent = float(balance.points.energy @ balance.points.volume)
        if balance.points.internal_variables.size:
            spent += float(body.materials.plastic_work(balance.points) @ balance.points.volume)
            spent -= float(last.values["plastic_work"])
        work = balance.external_work - float(last.values["external_work"])
        return work - spent + float(last.values["strain_energy"])
    now = _conjugates_at(body, balance, factor, last.load_factor)
    if now is None or not balance.proportional:
        return np.nan
    return _set_free(last.conjugates, last.load_factor, now)


def _set_free(
    before: tuple[float, float, float], factor: float, now: tuple[float, float, float]
) -> float:
    """Return by how much the potential energy of a linear body has fallen at one load [N].

    Parameters
    ----------
    before, now : (float, float, float)
        Conjugates (`StepRecord`) before and after a crack has grown, both at `factor`.
    factor : float
        Load factor.

    Notes
    -----
    By Clapeyron the potential energy is half the work of the grips less half that of the dead
    loads, with contact without friction as well. A crack takes constraints away, by which it can
    only fall: what a release sets free is never negative, but for the error of the grid.
    """
    (dead, grip, _), (dead_now, grip_now, _) = before, now
    return 0.5 * factor * ((grip - dead) - (grip_now - dead_now))


def conjugates(body: Body, balance: Equilibrium, scale: float) -> tuple[float, float, float]:
    """Return the work conjugates of dead loads, grips and fixed loads; see `StepRecord` [N]."""
    loading = body.loading
    # Zero where the displacement is prescribed: a force there does no work.
    free = balance.displacement - loading.at(balance.load_factor).displacement
    dead, grip, fixed = _sums(loading, free, balance.internal_force - balance.contact_force)
    return scale * dead, scale * grip, scale * fixed


def _conjugates_at(
    body: Body, balance: Equilibrium, factor: float, other: float
) -> tuple[float, float, float] | None:
    """`conjugates` of a linear body at another load factor; None where unknown."""
    now = conjugates(body, balance, balance.scale(factor))
    if balance.parts is None:
        return (
            None
            if factor == 0.0
            else (now[0] * other / factor, now[1] * other / factor, now[2] * other / factor)
        )
    part, loading = balance.parts.proportional, body.loading
    free = part.displacement - loading.proportional.displacement
    slopes = _sums(loading, free, part.internal_force)
    dead, grip, fixed = (a + (other - factor) * b for a, b in zip(now, slopes, strict=True))
    return dead, grip, fixed


def _sums(loading: Loading, free: Floats, force: Floats) -> tuple[float, float, float]:
    """Sums of dead force times displacement, force times prescribed displacement, fixed force."""
    unit = loading.proportional
    fixed = 0.0 if loading.fixed is None else float((loading.fixed.force * free).sum())
    return float((unit.force * free).sum()), float((force * unit.displacement).sum()), fixed


def _work_on_fixed_grips(body: Body, balance: Equilibrium) -> float:
    """Sum of reactions times fixed displacements [N]."""
    fixed = body.loading.fixed
    if fixed is None:
        return 0.0
    return float(((balance.internal_force - balance.contact_force) * fixed.displacement).sum())
