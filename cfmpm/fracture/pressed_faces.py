"""Crack faces that press on each other behind a tip: their pressure, and whether they close it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cfmpm.body.bends import CORNER, turn
from cfmpm.body.crack_faces import Turning
from cfmpm.body.grid import CrackTip, Floats, Grid, Ints, lengths_of
from cfmpm.body.tip_domains import sharp_bend
from cfmpm.kernels import eshelby

# Element sizes behind a tip over which the faces tell whether it is closed. A single pair is not
# enough: where shear is far larger than what opens the tip or shuts it, the error of the singular
# stress in the tip elements opens or closes the first pair.
NEAR = 3.0
# Gauss points of an edge of a face, from -1 to 1, and their weights.
ABSCISSAE, WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class PressedFaces:
    """The faces of a crack that press on each other, from one of its tips on.

    Attributes
    ----------
    links : (k, 2) int
        Neighbouring nodes on the left face, from the tip on.
    place : (k, 2) float
        Their distances from the tip along the crack [mm].
    normal : (k, 2) float
        Unit normal of each link, out of the body on the right of the crack.
    pressure : (k, 2) float
        At both nodes of each link [MPa].
    closed : bool
        Whether the faces press on each other up to the tip: over more than half of the first
        `NEAR` element sizes.
    """

    links: Ints
    place: Floats
    normal: Floats
    pressure: Floats
    closed: bool

    @classmethod
    def behind(
        cls,
        grid: Grid,
        contact_force: Floats,
        tip: CrackTip,
        turning: Turning | None = None,
    ) -> Self:
        """Turn the contact forces on the left face of a crack into a pressure.

        Parameters
        ----------
        grid : Grid
            With all of its cracks.
        contact_force : (n, 2) float
            That crack faces exert on each other [N/mm].
        tip : CrackTip
        turning : Turning, optional
            Rotation of the crack at finite deformation, by which the forces have turned.

        Notes
        -----
        A node bears what a uniform pressure makes of the edges on both of its sides; at a corner
        each side has a pressure of its own. The pressure is linear between nodes. Tips, which are
        no pair, have that of the next node.
        """
        faces = grid.crack_faces[tip.crack]
        left, right = grid.edge_nodes(faces[:, 0]), grid.edge_nodes(faces[:, 1])
        along = grid.nodes[left[:, 1]] - grid.nodes[left[:, 0]]
        across = np.column_stack([-along[:, 1], along[:, 0]])
        # Force on each node by a unit pressure.
        unit = np.zeros((len(grid.nodes), 2))
        weights = np.outer(grid.element.side_weights, np.ones(len(left))).T
        np.add.at(unit, left, weights[:, :, None] * across[:, None, :])
        order = grid.element.along
        links = np.stack([left[:, order[:-1]], left[:, order[1:]]], axis=2).reshape(-1, 2)
        if turning is not None:
            # Back into the reference configuration.
            back = contact_force @ [1.0, 1.0j] * np.conj(turning.rotation)
            contact_force = np.column_stack([back.real, back.imag])
        at_node = np.zeros(len(grid.nodes))
        nodes = np.unique(left)
        # Without friction it acts along the normal.
        at_node[nodes] = np.hypot(*contact_force[nodes].T) / np.hypot(*unit[nodes].T)
        pressure = at_node[links]
        _divide_at_corners(pressure, contact_force, left, weights[0, 1] * across)
        normal = np.repeat(across / np.hypot(*across.T)[:, None], grid.element.order, axis=0)
        if tip.end == -1:
            links, normal, pressure = links[::-1, ::-1], normal[::-1], pressure[::-1, ::-1]
        paired = ~np.isin(links, np.intersect1d(left, right))
        pressure = pressure.copy()
        for one, other in ((0, 1), (1, 0)):
            alone = ~paired[:, one] & paired[:, other]
            pressure[alone, one] = pressure[alone, other]
        length = lengths_of(grid.nodes, links)
        end = np.cumsum(length)
        place = np.stack([end - length, end], axis=1)
        return cls(links, place, normal, pressure, _reaches_tip(tip, place, pressure))

    def opened(self) -> Self:
        """Return them with the tip open: there is no pressure at it."""
        pressure = self.pressure.copy()
        pressure[0, 0] = 0.0
        return replace(self, pressure=pressure)

    def mean(self, weight: Floats) -> float:
        """Mean of the pressure over the faces by a weight of the nodes, (n,) [MPa]."""
        share = weight[self.links] * np.diff(self.place, axis=1)
        return float((share * self.pressure).sum() / max(share.sum(), 1e-300))

    def work(
        self, nodes: Floats, tip: CrackTip, q: Floats, lame: Floats, uniform: Floats
    ) -> Floats:
        """Integrate t_i [a_i,1] q, traction times jump of the auxiliary fields, over the faces.

        Parameters
        ----------
        nodes : (n, 2) float
        tip : CrackTip
        q : (n,) float
        lame : (2,) float
        uniform : (2, 2) float
            Stress in the frame of the tip whose traction is left out [MPa].

        Returns
        -------
        (2,) float
            Of modes I and II, per auxiliary unit [N/mm]. The point force of the T-stress has no
            jump, nor has the solution itself where its faces are closed, so that J needs no such
            term.
        """
        inside = (q[self.links] > 0.0).any(axis=1)
        links, (start, end) = self.links[inside], self.place[inside].T
        # Gauss points in the root of the distance from the tip, in which the fields are smooth.
        low, high = np.sqrt(start)[:, None], np.sqrt(end)[:, None]
        root = 0.5 * (low + high) + 0.5 * (high - low) * ABSCISSAE
        part = (root**2 - start[:, None]) / (end - start)[:, None]
        shape = np.stack([1.0 - part, part], axis=2)
        q_ds = np.einsum("lgn,ln->lg", shape, q[links]) * root * (high - low) * WEIGHTS
        frame = np.array([tip.tangent, [-tip.tangent[1], tip.tangent[0]]])
        away = (shape @ nodes[links] - tip.path[0]).reshape(-1, 2)
        along, across = np.einsum("ij,gj->ig", frame, away)
        r, theta = np.hypot(along, across), np.mod(np.arctan2(across, along), 2.0 * np.pi)
        slope = np.array(
            [
                [
                    eshelby.auxiliary_gradient(mode, *at, *lame)[::2]
                    for at in zip(r, theta, strict=True)
                ]
                for mode in (0, 1)
            ]
        ).reshape(2, -1, 2)
        # On the other face, one turn away, the fields have the other sign.
        jump = 2.0 * slope if tip.end == -1 else -2.0 * slope
        normal = self.normal[inside] @ frame.T
        pressure = np.einsum("lgn,ln->lg", shape, self.pressure[inside])
        # The left face is that of the body whose outer normal is - n.
        t = pressure[:, :, None] * normal[:, None, :] + (normal @ uniform)[:, None, :]
        return np.einsum("mgi,gi,g->m", jump, t.reshape(-1, 2), q_ds.ravel())


def _divide_at_corners(pressure: Floats, force: Floats, left: Ints, end_force: Floats) -> None:
    """Divide the force of the node at a corner between the edges on both sides, in place.

    Parameters
    ----------
    pressure : (k, 2) float
        At both nodes of each link, first point to last [MPa].
    force : (n, 2) float
        [N/mm].
    left : (e, p + 1) int
    end_force : (e, 2) float
        On the node at an end of each edge by a unit pressure on the edge [mm].
    """
    ahead, behind = end_force[:-1], end_force[1:]
    sharp = np.flatnonzero(np.abs(turn(ahead, behind)) > CORNER)
    links = len(pressure) // max(len(left), 1)
    for edge in sharp:
        parts = np.linalg.solve(np.column_stack([ahead[edge], behind[edge]]), force[left[edge, 1]])
        pressure[links * edge + links - 1, 1], pressure[links * (edge + 1), 0] = parts.clip(0.0)


def _reaches_tip(tip: CrackTip, place: Floats, pressure: Floats) -> bool:
    """Whether faces are closed over more than half of the first element sizes behind a tip.

    What lies beyond a sharp bend says nothing of the tip: kinks open on cracks that are closed.
    """
    reach = min(NEAR * tip.h, 0.5 * place[-1, 1], sharp_bend(tip))
    near: NDArray[np.bool_] = place[:, 1] <= reach * (1.0 + 1e-9)
    near[0] = True
    share = np.diff(place[near], axis=1)[:, 0]
    pressed = (pressure[near] > 0.0).mean(axis=1)
    return bool(share @ pressed > 0.5 * share.sum())
