"""Work of the loads from step to step, and the energy that growth sets free."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cfmpm.body.body import Body
from cfmpm.body.grid import Floats
from cfmpm.body.loads import Loading
from cfmpm.equilibrium.balance import Equilibrium
from cfmpm.output.history import StepRecord


def done(
    steps: Sequence[StepRecord], body: Body, balance: Equilibrium, factor: float, *, jumped: bool
) -> float:
    """Work of the loads from the start, by the trapezoidal rule over the steps [N].

    Fixed loads do theirs by the motion alone; to begin with they grow together with the others.
    Where a last ligament has broken it did so at the load of the step before, by itself; the
    load has changed after that.
    """
    now = conjugates(body, balance, balance.scale(factor))
    work, last_factor, last = 0.0, 0.0, (0.0, 0.0, 0.0)
    if steps:
        work = float(steps[-1].values["external_work"])
        last_factor, last = steps[-1].load_factor, steps[-1].conjugates
    elif not balance.proportional:
        work = 0.5 * (_work_on_fixed_grips(body, balance) - now[2])
    broken = conjugates_at(body, balance, factor, last_factor) if jumped else None
    if broken is not None:
        work += last_factor * (broken[0] - last[0]) + (broken[2] - last[2])
        last = broken
    work += 0.5 * (factor + last_factor) * (now[0] - last[0]) + (now[2] - last[2])
    return work + 0.5 * (now[1] + last[1]) * (factor - last_factor)


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
    now = conjugates_at(body, balance, factor, last.load_factor)
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
    """What the dead loads have moved through and the force on the grips; see `StepRecord` [N]."""
    loading = body.loading
    # Zero where a support prescribes the displacement: a force there does no work.
    free = balance.displacement - loading.at(balance.load_factor).displacement
    dead, grip, fixed = _sums(loading, free, balance.internal_force - balance.contact_force)
    return scale * dead, scale * grip, scale * fixed


def conjugates_at(
    body: Body, balance: Equilibrium, factor: float, other: float
) -> tuple[float, float, float] | None:
    """The same of a linear body at another load factor; None where that is not known."""
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
    """Sums of dead forces times motion, of forces times prescribed motion, and of fixed forces."""
    unit = loading.proportional
    fixed = 0.0 if loading.fixed is None else float((loading.fixed.force * free).sum())
    return float((unit.force * free).sum()), float((force * unit.displacement).sum()), fixed


def _work_on_fixed_grips(body: Body, balance: Equilibrium) -> float:
    """Sum of reactions times fixed displacements [N]."""
    fixed = body.loading.fixed
    if fixed is None:
        return 0.0
    return float(((balance.internal_force - balance.contact_force) * fixed.displacement).sum())
