"""Fatigue: how far the tips of cracks get under cycles of load, and which of them run next."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from cfmpm.fracture.criteria.protocols import is_closed
from cfmpm.scene.growth import Fatigue


@dataclass(frozen=True)
class Progress:
    """What a body has been through, and how fast its tips advance.

    Attributes
    ----------
    cycles : float
        Of load, so far.
    ranges : dict of str to float
        dK of each tip of the grid, by its name [MPa mm^0.5].
    rates : dict of str to float
        da/dN of these [mm/cycle]; zero at and below the threshold.
    pending : dict of str to float
        What each has grown by Paris' law less what it has by segments of the grid [mm].
    leader : str
        The tip whose segment tells the number of cycles; empty where no tip advances.
    driving : dict of str to float
        What of its toughness each has reached, G / g_c; nan without a toughness.
    """

    cycles: float
    ranges: dict[str, float]
    rates: dict[str, float]
    pending: dict[str, float]
    leader: str
    driving: dict[str, float]


def stress_range(
    law: Fatigue, k_1: float, k_2: float, least: tuple[float, float] | None = None
) -> float:
    """Return the range dK of the stress intensity in a cycle [MPa mm^0.5].

    Parameters
    ----------
    law : Fatigue
    k_1, k_2 : float
        At the greatest load of the cycle [MPa mm^0.5].
    least : (float, float), optional
        K_I and K_II at the least load of the cycle; default: load_ratio times those at the greatest
        [MPa mm^0.5].

    Returns
    -------
    float
        dK = K_eq of the difference of both ends, (1 - R) K_eq under proportional loads. With
        K_eq = sqrt(K_I^2 + K_II^2) = sqrt(E' G), Irwin's energy release rate (1957): on a path
        that turns to where K_II vanishes every other mixture of the modes gives the same. A K_I
        below zero counts as zero; at an end of the cycle at which the tip is closed both do.

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
    """Count the cycles in which the tips have grown by their last segments.

    Parameters
    ----------
    before : Progress or None
        At the start of these segments; None at the start of the run.
    grown : mapping of str to float
        Their lengths, by the tips that ran [mm].
    rates : mapping of str to float
        At their ends, of the tips that are left [mm/cycle].

    Returns
    -------
    cycles : float
        So far. Those of the last segments are what the leader took for its own, with the mean of
        1 / (da/dN) over both its ends: the trapezoidal rule.
    pending : dict of str to float
        See `Progress`. In the same cycles each tip has grown by its own mean rate.
    """
    if before is None:
        return 0.0, {}
    mean = {name: _mean(rate, rates.get(name, rate)) for name, rate in before.rates.items()}
    spent = 0.0
    if grown:
        # Another tip may have run into the leader before it could.
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
    """Find the tips that run next.

    Parameters
    ----------
    pending, rates : mapping of str to float
        See `Progress`.
    segments : mapping of str to float
        Length of the grid at each tip [mm].

    Returns
    -------
    leader : str
        The tip that is the first to owe a whole segment; empty where no tip advances.
    chosen : list of str
        The leader, and all that will then owe half a segment or more: each place is the nearest
        to that of the law that the grid has.
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
    """The harmonic mean, by which 1 / rate is summed; of a tip that starts or stops, half."""
    if start > 0.0 and end > 0.0:
        return 2.0 * start * end / (start + end)
    return 0.5 * (start + end)
