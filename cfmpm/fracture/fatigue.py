"""Fatigue crack growth by Paris' law: load cycles, and selection of the tips that grow next."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from cfmpm.fracture.criteria.protocols import is_closed
from cfmpm.scene.growth import Fatigue


@dataclass(frozen=True)
class Progress:
    """Load cycles so far, and state of the tips.

    Attributes
    ----------
    cycles : float
        Load cycles so far.
    ranges : dict of str to float
        dK of each tip of the grid, by its name [MPa mm^0.5].
    rates : dict of str to float
        da/dN of each tip [mm/cycle]; zero at and below the threshold.
    pending : dict of str to float
        Pending advance of each tip: growth by Paris' law less the released segments [mm].
    leader : str
        The tip whose segment determines the number of cycles; empty where no tip grows.
    driving : dict of str to float
        G / g_c of each tip; nan without a toughness.
    """

    cycles: float
    ranges: Mapping[str, float]
    rates: Mapping[str, float]
    pending: Mapping[str, float]
    leader: str
    driving: Mapping[str, float]


def stress_range(
    law: Fatigue, k_1: float, k_2: float, least: tuple[float, float] | None = None
) -> float:
    """Return the range dK of the stress intensity factor in a cycle [MPa mm^0.5].

    Parameters
    ----------
    law : Fatigue
    k_1, k_2 : float
        K_I and K_II at the maximum load of the cycle [MPa mm^0.5].
    least : (float, float), optional
        K_I and K_II at the minimum load of the cycle; default: load_ratio times those at the
        maximum [MPa mm^0.5].

    Returns
    -------
    float
        dK = K_eq of the difference between maximum and minimum load, (1 - R) K_eq under
        proportional loads. K_eq = sqrt(K_I^2 + K_II^2) = sqrt(E' G), from Irwin's energy release
        rate (1957). On a path along which K_II vanishes, every other combination of the modes
        gives the same. A negative K_I is taken as zero; where the tip is closed, so is K_II.

    Examples
    --------
    >>> law = Fatigue(C=1e-12, m=3.0, load_ratio=0.5)
    >>> stress_range(law, 10.0, 0.0)
    5.0
    >>> stress_range(law, 10.0, 0.0, least=(-3.0, 0.0))
    10.0
    """
    if least is not None:
        ends = [
            (0.0, 0.0) if is_closed(*k) else (max(k[0], 0.0), k[1]) for k in ((k_1, k_2), least)
        ]
        return math.dist(*ends)
    return (1.0 - law.load_ratio) * math.hypot(max(k_1, 0.0), k_2)


def growth_rate(law: Fatigue, span: float) -> float:
    """Return da/dN = C dK^m of a range [mm/cycle] (Paris and Erdogan 1963)."""
    return law.C * span**law.m if span > law.threshold else 0.0


def count(
    before: Progress | None, grown: Mapping[str, float], rates: Mapping[str, float]
) -> tuple[float, dict[str, float]]:
    """Count the load cycles of the last released segments.

    Parameters
    ----------
    before : Progress or None
        State at the start of these segments; None at the start of the run.
    grown : mapping of str to float
        Lengths of these segments, by the name of the tip [mm].
    rates : mapping of str to float
        da/dN at the ends of the segments, for the remaining tips [mm/cycle].

    Returns
    -------
    cycles : float
        Load cycles so far. The leader determines those of the last segments: 1 / (da/dN) is
        integrated over its segment by the trapezoidal rule.
    pending : dict of str to float
        See `Progress`. In the same cycles each tip has grown by its own mean rate.
    """
    if before is None:
        return 0.0, {}
    mean = {name: _mean(rate, rates.get(name, rate)) for name, rate in before.rates.items()}
    spent = 0.0
    if grown:
        # Another tip may have run into the leader in the same increment.
        lead = before.leader if before.leader in grown else next(iter(grown))
        spent = max(0.0, grown[lead] - before.pending.get(lead, 0.0)) / mean[lead]
    pending = {
        name: before.pending.get(name, 0.0) + rate * spent - grown.get(name, 0.0)
        for name, rate in mean.items()
    }
    return before.cycles + spent, pending


def select_tips(
    pending: Mapping[str, float], rates: Mapping[str, float], segments: Mapping[str, float]
) -> tuple[str, list[str]]:
    """Select the tips that grow next.

    Parameters
    ----------
    pending, rates : mapping of str to float
        See `Progress`.
    segments : mapping of str to float
        Element size at each tip [mm].

    Returns
    -------
    leader : str
        The tip whose pending advance reaches a whole segment first; empty where no tip grows.
    chosen : list of str
        The leader, and all tips whose pending advance is then half a segment or more. Each tip is
        thus at the node nearest to its position by the law.
    """
    cycles = {
        name: max(0.0, segments[name] - pending.get(name, 0.0)) / rate
        for name, rate in rates.items()
        if rate > 0.0
    }
    if not cycles:
        return "", []
    leader = min(cycles, key=cycles.__getitem__)
    late = cycles[leader]
    return leader, [
        name
        for name in cycles
        if name == leader or pending.get(name, 0.0) + rates[name] * late >= 0.5 * segments[name]
    ]


def _mean(start: float, end: float) -> float:
    """Harmonic mean, the trapezoidal rule for 1 / rate; half of the other rate if one is zero."""
    if start > 0.0 and end > 0.0:
        return 2.0 * start * end / (start + end)
    return 0.5 * (start + end)
