"""Which crack tips run, at which load, and where to."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.body import Body
from cfmpm.body.grid import CrackTip, Floats, Grid, regions_ahead
from cfmpm.ending import RunEnded
from cfmpm.equilibrium.balance import Parts
from cfmpm.fracture import fatigue
from cfmpm.fracture.criteria.protocols import (
    direction_by,
    driving_force_by,
    is_closed,
    load_factor_at_fracture,
)
from cfmpm.fracture.critical_load import TipsByFactor, factor_at_fracture, presses
from cfmpm.fracture.fatigue import Progress
from cfmpm.scene.growth import Fatigue, Growth

# Tips whose criteria differ by less than this part run together under crack control: twins of a
# symmetric part differ by the error of the grid.
TIE = 0.02
# Part of what drove a tip at the load of the step before, below which nothing is left of it but
# round-off: a body that has come apart. In stress its root, 1e-9.
RELIEVED = 1e-18
# By how much what drives the first tip may miss its toughness at the load that was found for it.
MET = 1e-6
# Largest angle by which a segment is turned on from the tangent at its start [rad].
MOST_BEND = math.radians(5.0)


@dataclass(frozen=True)
class Decision:
    """What the cracks do next.

    Attributes
    ----------
    load_factor : float
        At which they do it; infinite where no load makes a crack run, nan where no tip is left
        under crack control.
    running : dict of str to (2,) float
        Direction of the next segment of each tip that runs, by its name.
    tangents : dict of str to (2,) float
        Direction in which each tip last set out: that of the segment, but for a curved path.
    progress : Progress or None
        Of fatigue.
    """

    load_factor: float
    running: dict[str, Floats]
    tangents: dict[str, Floats] = field(default_factory=dict)
    progress: Progress | None = None


def decide(
    grid: Grid,
    values: Mapping[str, Any],
    g_c: Floats,
    growth: Growth | None,
    last: Decision | None = None,
    load_factor: float = 1.0,
    scale: float = 1.0,
    *,
    law: Fatigue | None = None,
    grown: Mapping[str, float] | None = None,
    unresolved: Collection[str] = (),
    proportional: bool = True,
    least: Mapping[str, Any] | None = None,
) -> Decision:
    """Compare the tips with their toughness, or find how fast fatigue lets them advance.

    Parameters
    ----------
    grid : Grid
    values : mapping of str to (tip,) array
        By the names of `output.variables.VARIABLES`.
    g_c : (q,) float
        Critical energy release rate of each region [N/mm]; nan where there is none.
    growth : Growth or None
        None where the cracks do not grow.
    last : Decision, optional
        The one before, from which the bend of a path is known.
    load_factor : float
        Of the step.
    scale : float
        What stresses are to be multiplied with to be those of the step, at small strain.
    law : Fatigue, optional
        Of control by fatigue.
    grown : mapping of str to float, optional
        Lengths of the segments just released, by the tips that ran [mm].
    unresolved : collection of str
        Tips whose domain cannot tell a direction: these go straight on.
    proportional : bool
        Whether the values grow with the load factor; else they hold at that of the step only.
    least : mapping of str to (tip,) array, optional
        The values at the least load of a cycle, where those are not in proportion to it.

    Returns
    -------
    Decision
        Under load control tips run whose criterion reaches g_c. Under crack control the load factor
        is the one at which the first tip gets there, sqrt(g_c / G), or that of `load_of_growth`.
        By fatigue tips advance whose range is above the threshold, until one of them reaches g_c.
    """
    if growth is None:
        return Decision(load_factor, {})
    if not grid.tips and law is None:
        return Decision(load_factor if growth.control == "load" else math.nan, {})
    heading, closed = _headings(grid, values, growth, unresolved)
    ratio = _driving_ratio(grid, values, heading, closed, g_c, growth, scale)
    progress = None
    if law is not None:
        if least is not None:
            lower = _headings(grid, least, growth, unresolved)
            ratio = np.fmax(ratio, _driving_ratio(grid, least, *lower, g_c, growth, 1.0))
        progress, runs = _advance(grid, values, closed, ratio, last, law, grown or {}, least)
    elif growth.control == "load":
        runs = ratio >= 1.0
    else:
        largest = float(ratio.max())
        if proportional:
            load_factor, largest = _proportional_load_of_growth(largest, last)
        elif abs(largest - 1.0) > MET:  # no load was found (`load_of_growth`)
            load_factor, largest = math.inf, 0.0
        runs = (ratio >= (1.0 - TIE) * largest) & (largest > 0.0)
    if growth.tips == "largest":
        runs &= ratio == ratio.max()
    running, tangents = _directions(grid, heading, runs, growth, last, unresolved)
    return Decision(load_factor, running, tangents, progress)


def _directions(
    grid: Grid,
    heading: Mapping[str, Floats],
    runs: NDArray[np.bool_],
    growth: Growth,
    last: Decision | None,
    unresolved: Collection[str],
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Directions of the next segments of the tips that run, and tangents; see `Decision`."""
    tangents = {
        tip.name: heading[tip.name] for tip, run in zip(grid.tips, runs, strict=True) if run
    }
    known = {} if last is None else last.tangents
    before = {name: known[name] for name in known if growth.order == 2 and name not in unresolved}
    running = {
        name: secant(before[name], tangent) if name in before else tangent
        for name, tangent in tangents.items()
    }
    return running, known | tangents


def load_of_growth(
    body: Body,
    by_factor: TipsByFactor,
    parts: Parts,
    growth: Growth,
    last: Decision | None = None,
) -> tuple[float, str]:
    """Find the load factor at which the first tip runs, under loads that are not all proportional.

    Parameters
    ----------
    body : Body
    by_factor : TipsByFactor
    parts : Parts
    growth : Growth
    last : Decision, optional
        The one before.

    Returns
    -------
    load_factor : float
        As of `critical_load.factor_at_fracture`.
    reason : str
        Why it is nan; empty where it is not.
    """

    def drive(values: Mapping[str, Any]) -> float:
        heading, closed = _headings(body.grid, values, growth, body.unresolved_tips)
        g_c = body.materials.g_c
        ratio = _driving_ratio(body.grid, values, heading, closed, g_c, growth, 1.0)
        return math.sqrt(max(float(ratio.max()), 0.0))

    alone = drive(by_factor.proportional())
    if last is not None:
        left = max(drive(by_factor.at(last.load_factor)), alone * abs(last.load_factor))
        alone = 0.0 if left**2 < RELIEVED else alone
    factor = factor_at_fracture(lambda f: drive(by_factor.at(f)), alone)
    if math.isnan(factor):
        if drive(by_factor.at(0.0)) >= 1.0:
            return math.nan, "the fixed loads alone make a crack run"
        return math.nan, "as a tip opens its driving force jumps over the toughness"
    if presses(body, parts, factor):
        return math.nan, (
            f"at load factor {factor:.6g}, where a crack would run, crack faces press on each "
            "other: the state is no sum of those of fixed and proportional loads"
        )
    return factor, ""


def _proportional_load_of_growth(largest: float, last: Decision | None) -> tuple[float, float]:
    """Load factor at which the first tip runs, from its ratio at one; both of a relieved body."""
    if last is not None and largest * last.load_factor**2 < RELIEVED:
        largest = 0.0
    return load_factor_at_fracture(largest, 1.0), largest


def _headings(
    grid: Grid, values: Mapping[str, Any], growth: Growth, unresolved: Collection[str]
) -> tuple[dict[str, Floats], NDArray[np.bool_]]:
    """Find where each tip would run, by its name, and which have no direction to run in, (tip,).

    Such a tip is closed, or the criterion has no answer; it is taken to point straight on.
    Finite deformation knows no K; there, faces that press on each other leave J what shear makes.
    """
    closed = np.zeros(len(grid.tips), bool)
    if "K_I" in values:
        closed |= is_closed(np.asarray(values["K_I"]), np.asarray(values["K_II"]))
    criterion = direction_by(growth.direction)
    heading = {}
    for i, tip in enumerate(grid.tips):
        heading[tip.name] = tip.tangent
        if tip.name not in unresolved and not closed[i]:
            ahead = criterion.heading(_of_tip(values, i), tip.tangent)
            closed[i] = np.isnan(ahead).any()
            heading[tip.name] = tip.tangent if closed[i] else ahead
    return heading, closed


def _of_tip(values: Mapping[str, Any], i: int) -> dict[str, Any]:
    return {name: value[i] for name, value in values.items()}


def _driving_ratio(
    grid: Grid,
    values: Mapping[str, Any],
    heading: Mapping[str, Floats],
    closed: NDArray[np.bool_],
    g_c: Floats,
    growth: Growth,
    scale: float,
) -> Floats:
    """Divide what drives each tip by the toughness of what it runs into; nan without one, (tip,).

    Of two materials, along whose border it runs, the weaker one counts.
    """
    if not grid.tips:
        return np.empty(0)
    toughness = np.array(g_c, float)
    ahead = [regions_ahead(grid, tip, heading[tip.name]) for tip in grid.tips]
    weakest = np.array([toughness[regions].min() for regions in ahead])
    criterion = driving_force_by(growth.criterion)
    driving = np.array([criterion(_of_tip(values, i)) for i in range(len(grid.tips))])
    return np.where(closed, 0.0, scale**2 * driving) / weakest


def _advance(
    grid: Grid,
    values: Mapping[str, Any],
    closed: NDArray[np.bool_],
    ratio: Floats,
    last: Decision | None,
    law: Fatigue,
    grown: Mapping[str, float],
    least: Mapping[str, Any] | None,
) -> tuple[Progress, NDArray[np.bool_]]:
    """Count the cycles so far, and find which tips fatigue lets run next."""
    names = [tip.name for tip in grid.tips]
    known = {} if last is None or last.progress is None else last.progress.ranges
    spans = []
    for i, name in enumerate(names):
        k_1, k_2 = float(values["K_I"][i]), float(values["K_II"][i])
        if math.isnan(k_1):  # on the border of two materials: as it came there
            spans.append(known.get(name, 0.0))
        else:
            low = None
            if least is not None:
                low = float(least["K_I"][i]), float(least["K_II"][i])
            spans.append(
                0.0 if closed[i] and low is None else fatigue.stress_range(law, k_1, k_2, low)
            )
    ranges = dict(zip(names, spans, strict=True))
    rates = {name: fatigue.growth_rate(law, span) for name, span in ranges.items()}
    cycles, pending = fatigue.count(None if last is None else last.progress, grown, rates)
    leader, chosen = fatigue.select_tips(pending, rates, {tip.name: tip.h for tip in grid.tips})
    driving = dict(zip(names, map(float, ratio), strict=True))
    if any(value >= 1.0 for value in driving.values()):
        leader, chosen = "", []
    progress = Progress(cycles, ranges, rates, pending, leader, driving)
    return progress, np.array([name in chosen for name in names], bool)


def check_end(
    growth: Growth | None,
    decision: Decision,
    tips: tuple[CrackTip, ...],
    steps: int,
    *,
    last_level: bool = True,
    last: Decision | None = None,
    grown: Mapping[str, float] | None = None,
) -> None:
    """End a run that does not go on after this step, growing or to the next level.

    Parameters
    ----------
    growth : Growth or None
    decision : Decision
    tips : tuple of CrackTip
        That are left.
    steps : int
        So far.
    last_level : bool
        Whether the load rises no more.
    last : Decision, optional
        The one before.
    grown : mapping of str to float, optional
        As in `decide`.

    Raises
    ------
    RunEnded
    """
    if growth is None:
        if last_level:
            raise RunEnded("solved", "solved: the cracks are stationary")
        return
    if not tips:
        raise RunEnded("arrived", "arrived: no crack ends inside the body any more")
    if decision.running:
        if steps > growth.increments:
            text = f"increments: growth.increments allows {growth.increments}"
            raise RunEnded("increments", text)
        return
    if decision.progress is not None:
        _check_fracture(decision.progress, None if last is None else last.progress, tips, grown)
        raise RunEnded(
            "arrested",
            "arrested: the range of K of every tip is at or below the threshold, after "
            f"{decision.progress.cycles:.6g} cycles",
        )
    if math.isinf(decision.load_factor):
        raise RunEnded("stopped", "stopped: at no load does a tip meet the criterion")
    if last_level:
        raise RunEnded("stopped", "stopped: no tip meets the criterion")


def _check_fracture(
    now: Progress,
    before: Progress | None,
    tips: tuple[CrackTip, ...],
    grown: Mapping[str, float] | None,
) -> None:
    """End a run in which a tip has reached its toughness under fatigue."""
    tip = max(tips, key=lambda tip: np.nan_to_num(now.driving[tip.name]))
    ratio = now.driving[tip.name]
    if not ratio >= 1.0:
        return
    length = tip.crack_length
    cycles, text = now.cycles, f"fractured: {tip.name} reaches g_c in the first cycle"
    if before is not None:
        # Between the last two steps, by a straight line.
        rest = (ratio - 1.0) / (ratio - before.driving[tip.name])
        length -= rest * (grown or {}).get(tip.name, 0.0)
        cycles -= rest * (now.cycles - before.cycles)
        text = (
            f"fractured: {tip.name} reaches g_c at a crack length of {length:.6g} mm, after "
            f"{cycles:.6g} cycles"
        )
    values = {"cycles_to_fracture": cycles, "critical_crack_length": length}
    raise RunEnded("fractured", text, values=values)


def secant(before: Floats, now: Floats) -> Floats:
    """Direction of the next segment of a path that goes on bending as it did.

    Parameters
    ----------
    before, now : (2,) float
        Unit tangents of the path at the start and at the end of its last segment.

    Returns
    -------
    (2,) float
        The tangent turned on by half of what it turned (the two-step rule of Adams and Bashforth);
        by 5 degrees at the most, for a path that turns more than that is not resolved.
    """
    turned = np.arctan2(before[0] * now[1] - before[1] * now[0], before @ now)
    ahead = np.exp(1j * np.clip(0.5 * turned, -MOST_BEND, MOST_BEND)) * complex(*now)
    return np.array([ahead.real, ahead.imag])
