"""Domains around a crack tip: clearance, and choice of the radii."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cfmpm.body.bends import SHARP, turn
from cfmpm.body.grid import CrackTip, Floats, Grid, Ints
from cfmpm.errors import Problem, SceneError

# Largest domain radius as a fraction of the clearance, so that no node of an obstacle is inside.
FILL = 0.9
# Default of the largest radius: this many element sizes at the tip or, on more strongly graded
# grids, this fraction of the clearance. The T-stress, smaller than the singular stress by sqrt(r),
# is inaccurate closer to the tip.
REACH = 20.0
SHARE = 0.25
# Default around a growing tip [element sizes]: below 2.5 the fields are those of the tip elements,
# above 5 kinks of the crack have an effect (design study, 5.2 to 5.5).
REACH_GROWING = 5.0
# A domain with a smaller radius [element sizes] contains mainly the tip elements, whose fields are
# in error by a tenth and more.
RESOLVED = 4.0
# A growing tip whose domain is smaller [element sizes] keeps its direction. In front of the free
# edge of section 5.2 the error of the direction is the same from 5 elements down to 2.1 (T3 1.4,
# T6 0.4 deg at most, on four grids). Below 1.6 it doubles with each segment, to 2 and then 23 deg.
STEERABLE = 2.0
# Cosine of the angle to the tangent within which the nearest obstacle lies ahead.
AHEAD = np.sqrt(0.5)


@dataclass(frozen=True)
class TipDomain:
    """The domains around one tip.

    Attributes
    ----------
    radii : tuple of float
        Radii, as requested or chosen [mm].
    clearance : float
        Distance from the tip to the nearest object that a domain must not contain [mm].
    cut_back : bool
        Whether requested radii were reduced.
    growing : bool
        Whether the crack grows in this run.
    elements : float
        The largest radius in element sizes at the tip.
    since_bend : float
        Distance to the nearest sharp kink of the crack in element sizes.
    on_border : bool
        Whether a growing tip lies on the interface of two materials. Its field there is not that
        of K_I and K_II.
    runs_at : bool
        Whether the nearest object lies ahead, within 45 degrees.
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
        """Whether the direction of growth of a tip is taken from the domain.

        It is also taken at a tip that passes close to an object, as a hole: the deflection is then
        inaccurate, but real.
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
        Number of radii to choose, or the radii [mm].
    growing : bool
        Whether the crack grows: the domain may then contain sharp kinks of its own crack.

    Returns
    -------
    TipDomain
        The largest chosen radius is 20 element sizes at the tip or a quarter of the clearance,
        whichever is larger, but at most 0.9 of the clearance; the smallest is half of it. Requested
        radii are reduced by a common factor to at most 0.9 of the clearance. Around a growing tip
        the largest chosen radius is 5 element sizes, within which the crack is nearly straight.

    Raises
    ------
    SceneError
        If a stationary tip lies on the interface to another material.
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
    """Vector from a tip to the nearest object that limits its clearance [mm], (2,).

    Objects are the outline, holes, other cracks, the other end of its own crack and parts of it
    that come back to the tip, the interface to another material, and points of forces and supports;
    for a stationary tip also a sharp kink of its own crack.
    """
    x = grid.nodes[tip.node]
    ways = [tip.path[-1] - x, _to_own_flank(tip)]
    if not growing:
        # The fields are singular there; where a crack is curved they are smooth.
        ways.append(_to_sharp_bend(tip))
    obstacles = [edges[:, :2] for edges in grid.edges.values()]
    for name, faces in grid.crack_faces.items():
        if name != tip.crack:
            obstacles.append(grid.edge_nodes(faces[:, 0])[:, :2])
    borders = _borders(grid)
    meeting = (borders == tip.node).any()
    if meeting and not growing:
        reason = (
            f"the tip {tip.name} lies on the interface to another material, where its field is "
            "not that of K_I and K_II, and which is not supported; end the crack off the interface"
        )
        raise SceneError([Problem(reason, "geometry.cracks")])
    # A crack that crosses an interface ends on it for one increment; its domain has both materials.
    if not meeting:
        obstacles.append(borders)
    ways += [_to_segments(x, grid.nodes[edges]) for edges in obstacles if len(edges)]
    points = [node for node in grid.points.values() if node != tip.node]
    if points:
        ways.append(min(grid.nodes[points] - x, key=lambda way: np.hypot(*way)))
    return min(ways, key=lambda way: np.hypot(*way))


def _borders(grid: Grid) -> Ints:
    """Node pairs on material interfaces, (k, 2)."""
    if len(grid.region_names) == 1:
        return np.empty((0, 2), np.int64)
    element, side = np.nonzero(grid.twins >= 0)
    across = grid.regions[grid.twins[element, side] // 3]
    border = across != grid.regions[element]
    return grid.edge_nodes(3 * element[border] + side[border])[:, :2]


def sharp_bend(tip: CrackTip) -> float:
    """Return the distance from a tip to the nearest sharp kink of its crack [mm], or infinity.

    The fields are singular there. Unless the grid is graded towards the kink too, the flux through
    the adjacent crack faces is not accurate.
    """
    return float(np.hypot(*_to_sharp_bend(tip)))


def _to_sharp_bend(tip: CrackTip) -> Floats:
    """Vector from a tip to the nearest sharp kink of its crack; infinite without one, (2,)."""
    heading = -np.diff(tip.path, axis=0)
    ahead, behind = heading[:-1], heading[1:]
    corners = tip.path[1:-1][np.abs(turn(behind, ahead)) > SHARP] - tip.path[0]
    if not len(corners):
        return np.full(2, np.inf)
    return corners[np.argmin(np.hypot(*corners.T))]


def _to_own_flank(tip: CrackTip) -> Floats:
    """Vector from a tip to a part of its own crack that returns to it; else infinite, (2,)."""
    away = tip.path - tip.path[0]
    distance = np.hypot(*away.T)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(away, axis=0).T))])
    # Such a part is more than twice as far along the crack as in a straight line.
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
