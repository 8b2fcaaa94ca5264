"""Decision of crack growth: which tips grow, at which load, in which direction."""

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
from cfmpm.fracture import fatigue
from cfmpm.fracture.criteria.protocols import (
    direction_by,
    driving_force_by,
    is_closed,
    load_factor_at_fracture,
)
from cfmpm.fracture.critical_load import TipsByFactor, factor_at_fracture
from cfmpm.fracture.evaluation import values_of_tip
from cfmpm.fracture.fatigue import Progress
from cfmpm.fracture.ties import Tie, grid_error, growing_tips
from cfmpm.scene.growth import Fatigue, Growth

# A driving ratio below this, at the load of the step before, is round-off: the body is severed.
# It corresponds to 1e-9, its root, in stress.
RELIEVED = 1e-18
# Tolerance of the driving ratio of the first tip at the load factor found for it.
MET = 1e-6
# Largest angle between a segment and the tangent at its start [rad].
MOST_BEND = math.radians(5.0)


@dataclass(frozen=True)
class Decision:
    """What the cracks do next.

    Attributes
    ----------
    load_factor : float
        Load factor of that growth; infinite where no load makes a crack grow, nan where no tip is
        left under crack control.
    running : dict of str to (2,) float
        Direction of the next segment of each growing tip, by its name.
    tangents : dict of str to (2,) float
        Direction of the path of each tip at its last growth. It differs from that of the segment
        only with `order` 2.
    progress : Progress or None
        State of fatigue.
    tied : tuple of str
        Under crack control, the tips that reach the toughness first within the error of the grid,
        if they are more than one. With `tips: largest` one of them grows.
    ties : tuple of Tie
    """

    load_factor: float
    running: Mapping[str, Floats]
    tangents: Mapping[str, Floats] = field(default_factory=dict)
    progress: Progress | None = None
    tied: tuple[str, ...] = ()
    ties: tuple[Tie, ...] = ()

    @property
    def tie(self) -> Tie | None:
        """The tie of the growing tips, if they are in one."""
        running = set(self.running)
        return next((tie for tie in self.ties if running and running <= set(tie.grown)), None)


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
    """Compare the driving forces with the toughness, or apply the law of fatigue crack growth.

    Parameters
    ----------
    grid : Grid
    values : mapping of str to (tip,) array
        By the names of `output.variables.VARIABLES`.
    g_c : (q,) float
        Critical energy release rate of each region [N/mm]; nan where none is given.
    growth : Growth or None
        None for stationary cracks.
    last : Decision, optional
        The previous decision, for the curvature of the paths.
    load_factor : float
        Load factor of the step.
    scale : float
        Factor from the given stresses to those of the step, at small strain.
    law : Fatigue, optional
        Law of fatigue crack growth, for control by fatigue.
    grown : mapping of str to float, optional
        Lengths of the segments just released, by the name of the tip [mm].
    unresolved : collection of str
        Tips whose domain is too small for a direction: these grow straight ahead.
    proportional : bool
        Whether the values scale with the load factor; otherwise they hold at that of the step only.
    least : mapping of str to (tip,) array, optional
        The values at the minimum load of a cycle, if not proportional to those at the maximum.

    Returns
    -------
    Decision
        Under load control every tip grows whose driving force reaches g_c. Under crack control the
        load factor is the one at which the first tip reaches g_c, sqrt(g_c / G), or that of
        `load_of_growth`; tips that agree within the error of the grid grow together (`ties`). Under
        fatigue every tip grows whose range of K is above the threshold, until one reaches g_c.
    """
    if growth is None:
        return Decision(load_factor, {})
    if not grid.tips and law is None:
        return Decision(load_factor if growth.control == "load" else math.nan, {})
    heading, closed = _headings(grid, values, growth, unresolved)
    ratio = _driving_ratio(grid, values, heading, closed, g_c, growth, scale)
    progress: Progress | None = None
    tied: tuple[str, ...] = ()
    ties: tuple[Tie, ...] = ()
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
        runs = np.zeros(len(ratio), bool)
        if largest > 0.0:
            runs, tied, ties = _first(grid, values, ratio, last, grown or {})
    if growth.tips == "largest":
        runs, ties = runs & (ratio == ratio.max()), ()
    running, tangents = _directions(grid, heading, runs, growth, last, unresolved)
    return Decision(load_factor, running, tangents, progress, tied, ties)


def _first(
    grid: Grid,
    values: Mapping[str, Any],
    ratio: Floats,
    last: Decision | None,
    grown: Mapping[str, float],
) -> tuple[NDArray[np.bool_], tuple[str, ...], tuple[Tie, ...]]:
    """Select the tips that grow first under crack control; the others as in `Decision`."""
    names = [tip.name for tip in grid.tips]
    first, chosen, ties = growing_tips(
        dict(zip(names, ratio.tolist(), strict=True)),
        dict(zip(names, grid_error(values).tolist(), strict=True)),
        {tip.name: tip.h for tip in grid.tips},
        () if last is None else last.ties,
        grown,
    )
    runs = np.array([name in chosen for name in names])
    return runs, tuple(first) if len(first) > 1 else (), ties


def _directions(
    grid: Grid,
    heading: Mapping[str, Floats],
    runs: NDArray[np.bool_],
    growth: Growth,
    last: Decision | None,
    unresolved: Collection[str],
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Directions of the next segments of the growing tips, and tangents; see `Decision`."""
    tangents = {
        tip.name: heading[tip.name] for tip, run in zip(grid.tips, runs, strict=True) if run
    }
    known = {} if last is None else last.tangents
    before = {name: known[name] for name in known if growth.order == 2 and name not in unresolved}
    running = {
        name: secant(before[name], tangent) if name in before else tangent
        for name, tangent in tangents.items()
    }
    return running, {**known, **tangents}


def load_of_growth(
    body: Body, by_factor: TipsByFactor, growth: Growth, last: Decision | None = None
) -> tuple[float, str]:
    """Find the load factor at which the first tip grows, under fixed and proportional loads.

    Parameters
    ----------
    body : Body
    by_factor : TipsByFactor
    growth : Growth
    last : Decision, optional
        The previous decision.

    Returns
    -------
    load_factor : float
        From `critical_load.factor_at_fracture`.
    reason : str
        Why it is nan; otherwise empty.
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
            return math.nan, "the fixed loads alone make a crack grow"
        return math.nan, "as a tip opens, its driving force jumps past the toughness"
    return factor, ""


def _proportional_load_of_growth(largest: float, last: Decision | None) -> tuple[float, float]:
    """Load factor at which the first tip grows, from its driving ratio at load factor one.

    Returns
    -------
    float, float
        The load factor and the driving ratio; infinity and zero in a body without stress.
    """
    if last is not None and largest * last.load_factor**2 < RELIEVED:
        largest = 0.0
    return load_factor_at_fracture(largest, 1.0), largest


def _headings(
    grid: Grid, values: Mapping[str, Any], growth: Growth, unresolved: Collection[str]
) -> tuple[dict[str, Floats], NDArray[np.bool_]]:
    """Find the direction of growth of each tip, by its name, and which tips cannot grow, (tip,).

    A tip cannot grow if it is closed, if it lies in a part that carries nothing, or if the
    criterion gives no direction; its direction is then the tangent. At finite deformation there is
    no K. There, contact of the crack faces leaves in J only the contribution of shear, which counts
    where it is above the error of the method.
    """
    closed = np.isnan(values["G"]) if grid.tips else np.zeros(0, bool)
    without_k = np.ones(len(grid.tips), bool)
    if "K_I" in values:
        closed |= is_closed(np.asarray(values["K_I"]), np.asarray(values["K_II"]))
        without_k = np.isnan(values["K_I"])
    if "contact_pressure" in values:
        pressed = without_k & (np.asarray(values["contact_pressure"]) > 0.0)
        closed |= pressed & (np.asarray(values["J"]) <= values["G_floor"])
    criterion = direction_by(growth.direction)
    heading = {}
    for i, tip in enumerate(grid.tips):
        heading[tip.name] = tip.tangent
        if tip.name not in unresolved and not closed[i]:
            ahead = criterion.heading(values_of_tip(values, i), tip.tangent)
            closed[i] = np.isnan(ahead).any()
            heading[tip.name] = tip.tangent if closed[i] else ahead
    return heading, closed


def _driving_ratio(
    grid: Grid,
    values: Mapping[str, Any],
    heading: Mapping[str, Floats],
    closed: NDArray[np.bool_],
    g_c: Floats,
    growth: Growth,
    scale: float,
) -> Floats:
    """Ratio of driving force to the toughness of the material ahead; nan without one, (tip,).

    If the crack grows along the interface of two materials, the smaller toughness is taken.
    """
    if not grid.tips:
        return np.empty(0)
    toughness = np.array(g_c, float)
    ahead = [regions_ahead(grid, tip, heading[tip.name]) for tip in grid.tips]
    weakest = np.array([toughness[regions].min() for regions in ahead])
    criterion = driving_force_by(growth.criterion)
    driving = np.array([criterion(values_of_tip(values, i)) for i in range(len(grid.tips))])
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
    """Count the load cycles so far, and select the tips that grow next under fatigue."""
    names = [tip.name for tip in grid.tips]
    known = {} if last is None or last.progress is None else last.progress.ranges
    spans = []
    for i, name in enumerate(names):
        k_1, k_2 = float(values["K_I"][i]), float(values["K_II"][i])
        if math.isnan(k_1):  # on the interface of two materials: the range before it is kept
            spans.append(0.0 if closed[i] else known.get(name, 0.0))
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
    lengths: Mapping[str, float],
    last_level: bool = True,
    last: Decision | None = None,
    grown: Mapping[str, float] | None = None,
    pressed: Collection[str] = (),
) -> None:
    """End the run if neither growth nor a further load step follows this step.

    Parameters
    ----------
    growth : Growth or None
    decision : Decision
    tips : tuple of CrackTip
        The remaining tips.
    steps : int
        Number of steps so far.
    lengths : mapping of str to float
        Of the cracks, as they are counted [mm].
    last_level : bool
        Whether this is the last load step.
    last : Decision, optional
        The previous decision.
    grown : mapping of str to float, optional
        As in `decide`.
    pressed : collection of str
        Tips whose faces press on each other.

    Raises
    ------
    RunEnded
    """
    if growth is None:
        if last_level:
            raise RunEnded("solved", "solved: the cracks are stationary")
        return
    if not tips:
        raise RunEnded("arrived", "arrived: no crack tip is left inside the body")
    if decision.running:
        if steps > growth.increments:
            text = f"increments: growth.increments allows {growth.increments}"
            raise RunEnded("increments", text)
        return
    shut = f"; pressed shut: {', '.join(pressed)}" if pressed else ""
    if decision.progress is not None:
        before = None if last is None else last.progress
        _check_fracture(decision.progress, before, tips, lengths, grown)
        raise RunEnded(
            "arrested",
            "arrested: the range of K of every tip is at or below the threshold, after "
            f"{decision.progress.cycles:.6g} cycles{shut}",
        )
    if math.isinf(decision.load_factor):
        raise RunEnded("stopped", f"stopped: no tip meets the criterion at any load{shut}")
    if last_level:
        raise RunEnded("stopped", f"stopped: no tip meets the criterion{shut}")


def _check_fracture(
    now: Progress,
    before: Progress | None,
    tips: tuple[CrackTip, ...],
    lengths: Mapping[str, float],
    grown: Mapping[str, float] | None,
) -> None:
    """End a run of fatigue in which the driving force of a tip has reached the toughness."""
    tip = max(tips, key=lambda tip: np.nan_to_num(now.driving[tip.name]))
    ratio = now.driving[tip.name]
    if not ratio >= 1.0:
        return
    length = lengths[tip.crack]
    cycles, text = now.cycles, f"fractured: {tip.name} reaches g_c in the first cycle"
    if before is not None:
        # Linear interpolation between the last two steps.
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
    """Direction of the next segment of a curved path, extrapolated from the last segment.

    Parameters
    ----------
    before, now : (2,) float
        Unit tangents of the path at the start and at the end of its last segment.

    Returns
    -------
    (2,) float
        The tangent turned further by half of the angle by which it turned over the last segment
        (the two-step rule of Adams and Bashforth), at most by 5 degrees: a path of larger
        curvature is not resolved.
    """
    turned = np.arctan2(before[0] * now[1] - before[1] * now[0], before @ now)
    ahead = np.exp(1j * np.clip(0.5 * turned, -MOST_BEND, MOST_BEND)) * complex(*now)
    return np.array([ahead.real, ahead.imag])
