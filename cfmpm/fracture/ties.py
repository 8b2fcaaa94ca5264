"""Ties: tips that reach the toughness at loads that agree within the error of the grid.

Cracks that are mirror images of each other reach the toughness at the same load. Computed values
differ by the error of the grid, and the tip that came first by it would run alone: as it is then
longer, it stays ahead, and the symmetry is lost for good. So tips in a tie grow together, by equal
lengths. A grid does not allow every length: what a tip of a tie is behind is made up before the
driving forces of the tie are compared again.

Each release changes the grid at the tip, so that the error of the grid differs from step to step,
while a difference of the cracks stays. The driving forces of a tie are therefore compared by their
mean over its steps.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from cfmpm.body.grid import Floats

# Lengths that differ by less than this fraction of the element size are equal up to round-off.
LEVEL = 1e-6
# A tip that is behind by more than this part of its element size grows alone, so that every tip is
# at the node nearest to the place of its tie.
BEHIND = 0.5
# Equal segments that are tried, over the mean of those that the grid offers.
LENGTHS = (1.0, 0.9, 1.1, 0.8, 1.2, 0.7, 1.3, 0.6, 1.4, 0.5, 1.5)
# Largest error that is taken for one of the grid. Where J and G differ by more, one of them is
# wrong, which is told (`output.warnings.of_history`), and would tie any tips.
LARGEST = 0.05
# Error of a tip with one value only, of which nothing tells the error.
UNKNOWN = 0.02


def grid_error(values: Mapping[str, Any]) -> Floats:
    """Return the relative error of the energy release rate of each tip.

    Parameters
    ----------
    values : mapping of str to (..., tip, radius) array
        `J_radius` and `G_radius`.

    Returns
    -------
    (..., tip) float
        The range of J and of G from K_I and K_II over all domain radii, divided by the largest
        size of any of them, at most `LARGEST`. All of them are the same quantity on a fine grid.
        `UNKNOWN` where there is one value only, as on an interface with one radius.
    """
    found = np.concatenate(
        [np.asarray(values[name], float) for name in ("J_radius", "G_radius")], axis=-1
    )
    known = np.isfinite(found)
    size = np.where(known, np.abs(found), 0.0).max(-1)
    spread = np.where(known, found, -np.inf).max(-1) - np.where(known, found, np.inf).min(-1)
    error = np.divide(spread, size, out=np.zeros(spread.shape), where=size > 0.0)
    alone = (known.sum(-1) <= 1) | (spread == 0.0)
    return np.where(alone, UNKNOWN, np.minimum(error, LARGEST))


@dataclass(frozen=True)
class Tie:
    """Tips that grow together, by name.

    Attributes
    ----------
    grown : dict of str to float
        Growth of each tip since the tie began [mm].
    excess : dict of str to float
        Sum over the steps at equal growth of the logarithm of the driving ratio, less that of the
        geometric mean over the tips.
    error : dict of str to float
        Sum of `grid_error` over the same steps.
    compared : int
        Number of these steps.
    """

    grown: Mapping[str, float]
    excess: Mapping[str, float] = field(default_factory=dict)
    error: Mapping[str, float] = field(default_factory=dict)
    compared: int = 0

    @property
    def behind(self) -> dict[str, float]:
        """What each tip is behind the first [mm]."""
        front = max(self.grown.values())
        return {name: front - length for name, length in self.grown.items()}

    def is_level(self, sizes: Mapping[str, float]) -> bool:
        """Whether all tips have grown by the same, up to round-off of the element sizes."""
        return max(self.behind.values()) <= LEVEL * min(sizes[name] for name in self.grown)

    def late(self, sizes: Mapping[str, float]) -> list[str]:
        """Return the tips that grow before the others."""
        return [name for name, length in self.behind.items() if length >= BEHIND * sizes[name]]

    def among(self, names: Collection[str]) -> Self:
        """Return the tie of some of its tips."""
        kept = [name for name in self.grown if name in names]
        middle = sum(self.excess.get(name, 0.0) for name in kept) / max(len(kept), 1)
        return type(self)(
            {name: self.grown[name] for name in kept},
            {name: self.excess[name] - middle for name in kept if name in self.excess},
            {name: self.error[name] for name in kept if name in self.error},
            self.compared,
        )

    def advanced(self, released: Mapping[str, float]) -> Self:
        """Add the lengths just released."""
        grown = {name: length + released.get(name, 0.0) for name, length in self.grown.items()}
        return type(self)(grown, self.excess, self.error, self.compared)

    def compare(self, ratio: Mapping[str, float], error: Mapping[str, float]) -> Self:
        """Add the driving ratios of a step at equal growth, all positive, and their errors."""
        mean = sum(math.log(ratio[name]) for name in self.grown) / len(self.grown)
        return type(self)(
            self.grown,
            {n: self.excess.get(n, 0.0) + math.log(ratio[n]) - mean for n in self.grown},
            {n: self.error.get(n, 0.0) + error[n] for n in self.grown},
            self.compared + 1,
        )

    def means(self, ratio: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Return the driving ratio of each tip by its mean excess, and the mean error."""
        middle = math.exp(sum(math.log(ratio[name]) for name in self.grown) / len(self.grown))
        n = self.compared
        return {
            name: (middle * math.exp(self.excess[name] / n), self.error[name] / n)
            for name in self.grown
        }

    def wanted(
        self, running: Sequence[str], offered: Mapping[str, float]
    ) -> list[dict[str, float]]:
        """Give choices of the lengths of the next segments after which all have grown by the same.

        Parameters
        ----------
        running : sequence of str
            The growing tips, all of the tie or those that are late.
        offered : mapping of str to float
            Lengths of the segments that the grid offers to these tips [mm].

        Returns
        -------
        list of dict of str to float
            The best first.
        """
        behind = self.behind
        if len(running) < len(self.grown):
            return [{name: behind[name] for name in running}]
        mean = sum(offered[name] - behind[name] for name in running) / len(running)
        return [
            {name: factor * mean + behind[name] for name in running}
            for factor in LENGTHS
            if factor * mean > 0.0
        ]


def first_tips(ratio: Mapping[str, float], error: Mapping[str, float]) -> list[str]:
    """Find the tips whose driving ratio is the largest one within the error of the grid.

    Two ratios agree that differ by less than the errors of both. Tips that agree with one that
    comes first come first too: otherwise a limit amid the twins of a pair would part them.

    Parameters
    ----------
    ratio : mapping of str to float
        Driving force over toughness of each tip, by its name.
    error : mapping of str to float
        Relative error of `ratio`; that of the load at which it is one is half of it.

    Returns
    -------
    list of str
        Empty if no ratio is positive.

    Examples
    --------
    >>> first_tips({"a": 1.0, "b": 0.99, "c": 0.9}, {"a": 0.01, "b": 0.005, "c": 0.0})
    ['a', 'b']
    """
    order = sorted(ratio, key=ratio.__getitem__, reverse=True)
    first = order[:1] if ratio[order[0]] > 0.0 else []
    for name in order[1:] if first else []:
        value = ratio[name] * (1.0 + error[name])
        if not any(value >= ratio[other] * (1.0 - error[other]) for other in first):
            break
        first.append(name)
    return [name for name in ratio if name in first]


def growing_tips(
    ratio: Mapping[str, float],
    error: Mapping[str, float],
    sizes: Mapping[str, float],
    before: Sequence[Tie] = (),
    released: Mapping[str, float] | None = None,
) -> tuple[list[str], list[str], tuple[Tie, ...]]:
    """Select the tips that grow next, and keep account of the ties.

    Parameters
    ----------
    ratio, error : mapping of str to float
        As in `first_tips`; the largest ratio is positive.
    sizes : mapping of str to float
        Element size at each tip [mm].
    before : sequence of Tie
        The ties so far.
    released : mapping of str to float, optional
        Lengths of the segments just released [mm].

    Returns
    -------
    first : list of str
        The tips that reach the toughness first, within the error of the grid.
    names : list of str
        The growing tips: `first`; of a tie whose tips have not grown by the same all tips, or
        those that are late by half an element.
    ties : tuple of Tie
        The first is that of the growing tips, if they are in one.

    Examples
    --------
    >>> ratio, error, sizes = ({"a": x, "b": y} for x, y in ((1.0, 0.9), (0.01, 0.01), (1.0, 1.0)))
    >>> growing_tips(ratio, error, sizes, [Tie({"a": 1.2, "b": 1.0})])[1]
    ['a', 'b']
    >>> growing_tips(ratio, error, sizes, [Tie({"a": 1.2, "b": 0.5})])[1]
    ['b']
    >>> growing_tips(ratio, error, sizes, [Tie({"a": 1.2, "b": 1.2})])[1]
    ['a']
    """
    able = [name for name in ratio if ratio[name] > 0.0]
    ties = [tie.among(able).advanced(released or {}) for tie in before]
    ties = [tie for tie in ties if len(tie.grown) > 1]
    level = [tie.is_level(sizes) for tie in ties]
    ties = [
        tie.compare(ratio, error) if even else tie for tie, even in zip(ties, level, strict=True)
    ]
    mean = {name: (ratio[name], error[name]) for name in ratio}
    for tie, even in zip(ties, level, strict=True):
        mean |= tie.means(ratio) if even else {}
    first = first_tips(*({name: pair[k] for name, pair in mean.items()} for k in (0, 1)))
    leader = max(ratio, key=ratio.__getitem__)
    first = [name for name in ratio if name in first or name == leader]
    for tie, even in zip(ties, level, strict=True):
        if not even and set(tie.grown) & set(first):
            others = (other for other in ties if other is not tie)
            return list(tie.grown), tie.late(sizes) or list(tie.grown), (tie, *others)
    apart = [tie.among(set(tie.grown) - set(first)) for tie in ties]
    together = [tie.among(first) for tie in ties if set(first) <= set(tie.grown)]
    if not together:
        together = [Tie(dict.fromkeys(first, 0.0)).compare(ratio, error)]
    return first, first, tuple(tie for tie in (*together, *apart) if len(tie.grown) > 1)
