"""Domains around a crack tip: how large they may be, and which radii are taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cfmpm.body.grid import CrackTip, Floats, Grid, Ints
from cfmpm.errors import Problem, SceneError

# Part of the clearance of a tip that a domain may fill: the nodes on what lies there stay out.
FILL = 0.9
# Radii chosen by the program reach to this many element sizes at the tip, and on grids graded
# beyond that to this part of the clearance: the T-stress, smaller than the singular stress by
# sqrt(r), loses its digits closer to the tip.
REACH = 20.0
SHARE = 0.25
# Around a running tip: below 2.5 sizes the fields are those of the tip elements, above 5 the bends
# of the crack count (design study, 5.2 to 5.5).
REACH_GROWING = 5.0
# A domain of fewer element sizes than this holds little but the tip elements, whose fields are
# wrong by a tenth and more.
RESOLVED = 4.0
# A running tip whose domain has fewer than these keeps its direction. In front of the free edge of
# section 5.2 the error of the direction is the same from 5 elements down to 2.1 (T3 1.4, T6 0.4 deg
# at most, on four grids); from 1.6 on it doubles with each segment, to 2 and then 23 deg.
STEERABLE = 2.0
# Cosine of the angle from the tangent within which what is nearest lies ahead.
AHEAD = np.sqrt(0.5)
# A bend of the crack by more than this [rad] counts as a corner.
SHARP = np.radians(20.0)


@dataclass(frozen=True)
class TipDomain:
    """The radii around one tip.

    Attributes
    ----------
    radii : tuple of float
        Ascending as asked for or chosen [mm].
    clearance : float
        Distance from the tip to the nearest thing that a domain must not hold [mm].
    cut_back : bool
        Whether a radius that was asked for was made smaller.
    growing : bool
        Whether the tip runs.
    elements : float
        How many the largest radius reaches over.
    since_bend : float
        How many elements the nearest sharp bend of the crack is away.
    on_border : bool
        Whether a running tip lies on the border of two materials. Its field there is not that of
        K_I and K_II.
    runs_at : bool
        Whether what is nearest lies ahead, within 45 degrees.
    """

    radii: tuple[float, ...]
    clearance: float
    cut_back: bool
    growing: bool = False
    elements: float = np.inf
    since_bend: float = np.inf
    on_border: bool = False
    runs_at: bool = False

    @property
    def steers(self) -> bool:
        """Whether the domain can tell where a running tip turns to.

        A tip that passes something close by is turned by what the domain says even so: that it
        bends towards a hole is coarse then, but true.
        """
        if self.on_border or self.since_bend < STEERABLE:
            return False
        return self.elements >= STEERABLE or not self.runs_at


def choose_domains(
    grid: Grid, tip: CrackTip, wanted: int | Sequence[float], *, growing: bool = False
) -> TipDomain:
    """Choose the domain radii of a tip.

    Parameters
    ----------
    grid : Grid
    tip : CrackTip
    wanted : int or sequence of float
        How many radii are to be chosen, or the radii themselves [mm].
    growing : bool
        Whether the tip runs: its domain then follows a curved crack, and may hold bends of it.

    Returns
    -------
    TipDomain
        Chosen radii end at 20 element sizes of the tip or a quarter of the clearance, whichever
        is larger, but at most at 0.9 of the clearance; they start at half of that. Radii asked
        for are cut back, all by one factor, to 0.9 of the clearance. Around a running tip they
        end at 5 element sizes, as far as one direction of the crack makes sense.

    Raises
    ------
    SceneError
        Where a tip that does not run lies on the border of another material.
    """
    way = _to_obstacle(grid, tip, growing=growing)
    clearance = float(np.hypot(*way))
    largest = FILL * clearance
    cut_back = False
    if isinstance(wanted, int):
        reach = REACH_GROWING * tip.h if growing else max(REACH * tip.h, SHARE * clearance)
        radii = tuple(float(r) for r in min(reach, largest) * _fractions(wanted))
    else:
        factor = min(1.0, largest / max(wanted))
        cut_back = factor < 1.0
        radii = tuple(factor * r for r in wanted)
    return TipDomain(
        radii,
        clearance,
        cut_back,
        growing,
        elements=max(radii) / tip.h,
        since_bend=sharp_bend(tip) / tip.h,
        on_border=bool((_borders(grid) == tip.node).any()),
        runs_at=bool((way * tip.tangent).sum() > AHEAD * clearance),
    )


def _fractions(count: int) -> Floats:
    return np.linspace(0.5, 1.0, count) if count > 1 else np.ones(1)


def _to_obstacle(grid: Grid, tip: CrackTip, *, growing: bool) -> Floats:
    """Vector from a tip to the nearest of what limits its clearance [mm], (2,).

    That is the outline, a hole, another crack, a bend or the other end of its own crack, the
    border of another material, and a point at which a force or a support acts.
    """
    x = grid.nodes[tip.node]
    # A growing crack bends all the time: what counts is the other end of its line.
    ways = [tip.path[-1] - x if growing else -tip.straight * tip.tangent, _to_own_flank(tip)]
    obstacles = [edges[:, :2] for edges in grid.edges.values()]
    for name, faces in grid.crack_faces.items():
        if name != tip.crack:
            obstacles.append(grid.edge_nodes(faces[:, 0])[:, :2])
    borders = _borders(grid)
    meeting = (borders == tip.node).any()
    if meeting and not growing:
        reason = (
            f"the tip {tip.name} lies on the border of another material, where its field is "
            "not that of K_I and K_II, which cfmpm knows; end the crack off the border"
        )
        raise SceneError([Problem(reason, "geometry.cracks")])
    # A crack that crosses a border ends on it for one increment, and sees both materials.
    if not meeting:
        obstacles.append(borders)
    ways += [_to_segments(x, grid.nodes[edges]) for edges in obstacles if len(edges)]
    points = [node for node in grid.points.values() if node != tip.node]
    if points:
        ways.append(min(grid.nodes[points] - x, key=lambda way: np.hypot(*way)))
    return min(ways, key=lambda way: np.hypot(*way))


def _borders(grid: Grid) -> Ints:
    """Node pairs on the borders of materials, (k, 2)."""
    if len(grid.region_names) == 1:
        return np.empty((0, 2), np.int64)
    element, side = np.nonzero(grid.twins >= 0)
    across = grid.regions[grid.twins[element, side] // 3]
    border = across != grid.regions[element]
    return grid.edge_nodes(3 * element[border] + side[border])[:, :2]


def sharp_bend(tip: CrackTip) -> float:
    """Return the distance from a tip to the nearest sharp bend of its crack [mm], or infinity.

    The fields are singular there, and unless the grid is graded towards it too the energy that the
    faces beside it let out of a ring is not known.
    """
    heading = -np.diff(tip.path, axis=0)
    ahead, behind = heading[:-1], heading[1:]
    cross = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    turn = np.abs(np.arctan2(cross, (ahead * behind).sum(axis=1)))
    corners = tip.path[1:-1][turn > SHARP] - tip.path[0]
    return float(np.hypot(*corners.T).min(initial=np.inf))


def _to_own_flank(tip: CrackTip) -> Floats:
    """Vector from a tip to a part of its own crack that comes back to it; else infinite, (2,)."""
    away = tip.path - tip.path[0]
    distance = np.hypot(*away.T)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(away, axis=0).T))])
    # What is twice as far by the crack as it is straight across lies on another flank.
    back = np.flatnonzero(along > 2.0 * distance * (1.0 + 1e-9))
    if back.size == 0:
        return np.full(2, np.inf)
    return away[back[np.argmin(distance[back])]]


def _to_segments(x: Floats, segments: Floats) -> Floats:
    """Vector from a point to the nearest point of segments (k, 2, 2), (2,)."""
    a, d = segments[:, 0], segments[:, 1] - segments[:, 0]
    along = np.clip(((x - a) * d).sum(axis=1) / (d * d).sum(axis=1), 0.0, 1.0)
    ways = a + along[:, None] * d - x
    return ways[np.argmin(np.hypot(*ways.T))]
