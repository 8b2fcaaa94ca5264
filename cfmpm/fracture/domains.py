"""Domains around a crack tip: how large they may be, and which radii are taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cfmpm.errors import Problem, SceneError
from cfmpm.grid import CrackTip, Floats, Grid

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
# A bend of the crack by more than this [rad] counts as a corner.
SHARP = np.radians(20.0)


@dataclass(frozen=True)
class Domains:
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
        How many elements the largest radius reaches over that is also free of sharp bends.
    """

    radii: tuple[float, ...]
    clearance: float
    cut_back: bool
    growing: bool = False
    elements: float = np.inf

    @property
    def steers(self) -> bool:
        """Whether the domain can tell where a running tip turns to."""
        return self.elements >= STEERABLE


def choose_domains(
    grid: Grid, tip: CrackTip, wanted: int | Sequence[float], *, growing: bool = False
) -> Domains:
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
    Domains
        Chosen radii end at 20 element sizes of the tip or a quarter of the clearance, whichever
        is larger, but at most at 0.9 of the clearance; they start at half of that. Radii asked
        for are cut back, all by one factor, to 0.9 of the clearance. Around a running tip they
        end at 5 element sizes, as far as one direction of the crack makes sense.

    Raises
    ------
    SceneError
        Where a tip that does not run lies on the border of another material.
    """
    clearance = tip_clearance(grid, tip, growing=growing)
    largest = FILL * clearance
    cut_back = False
    if isinstance(wanted, int):
        reach = REACH_GROWING * tip.h if growing else max(REACH * tip.h, SHARE * clearance)
        radii = tuple(float(r) for r in min(reach, largest) * _fractions(wanted))
    else:
        factor = min(1.0, largest / max(wanted))
        cut_back = factor < 1.0
        radii = tuple(factor * r for r in wanted)
    elements = min(max(radii), FILL * sharp_bend(tip)) / tip.h
    return Domains(radii, clearance, cut_back, growing, elements)


def _fractions(count: int) -> Floats:
    return np.linspace(0.5, 1.0, count) if count > 1 else np.ones(1)


def tip_clearance(grid: Grid, tip: CrackTip, *, growing: bool = False) -> float:
    """Return the distance from a tip to what a domain around it must not hold [mm].

    That is the outline, a hole, another crack, a bend or the other end of its own crack, the
    border of another material, and a point at which a force or a support acts.
    """
    x = grid.nodes[tip.node]
    # A growing crack bends all the time: what counts is the other end of its line.
    distances = [float(np.hypot(*(tip.path[-1] - x))) if growing else tip.straight]
    distances.append(_distance_to_own_flank(tip))
    obstacles = [edges[:, :2] for edges in grid.edges.values()]
    for name, faces in grid.crack_faces.items():
        if name != tip.crack:
            obstacles.append(grid.edge_nodes(faces[:, 0])[:, :2])
    if len(grid.region_names) > 1:
        element, side = np.nonzero(grid.twins >= 0)
        across = grid.regions[grid.twins[element, side] // 3]
        border = across != grid.regions[element]
        borders = grid.edge_nodes(3 * element[border] + side[border])[:, :2]
        meeting = (borders == tip.node).any(axis=1)
        if meeting.any() and not growing:
            reason = (
                f"the tip {tip.name} lies on the border of another material, where its field is "
                "not that of K_I and K_II, which cfmpm knows; end the crack off the border"
            )
            raise SceneError([Problem(reason, "geometry.cracks")])
        # A crack that crosses a border ends on it for one increment, and sees both materials.
        if not meeting.any():
            obstacles.append(borders)
    for edges in obstacles:
        if len(edges):
            distances.append(_distance_to_segments(x, grid.nodes[edges]))
    points = [node for node in grid.points.values() if node != tip.node]
    if points:
        distances.append(float(np.hypot(*(grid.nodes[points] - x).T).min()))
    return float(min(distances))


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


def _distance_to_own_flank(tip: CrackTip) -> float:
    """Distance from a tip to a part of its own crack that comes back to it; else infinite."""
    away = tip.path - tip.path[0]
    distance = np.hypot(*away.T)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(away, axis=0).T))])
    # What is twice as far by the crack as it is straight across lies on another flank.
    back = np.flatnonzero(along > 2.0 * distance * (1.0 + 1e-9))
    return float(distance[back].min(initial=np.inf))


def _distance_to_segments(x: Floats, segments: Floats) -> float:
    """Smallest distance from a point to segments (k, 2, 2)."""
    a, d = segments[:, 0], segments[:, 1] - segments[:, 0]
    along = np.clip(((x - a) * d).sum(axis=1) / (d * d).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(a + along[:, None] * d - x).T).min())
