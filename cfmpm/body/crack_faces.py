"""Crack faces: pairs of coincident nodes, and their opening."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cfmpm.body.bends import CORNER, turn
from cfmpm.body.grid import Floats, Grid, Ints


@dataclass(frozen=True)
class FacePairs:
    """The doubled nodes of a crack, one on each face.

    Attributes
    ----------
    left, right : (k,) int
        Coincident nodes of the left and right face of the crack, without tips; twice at a corner.
    normal : (k, 2) float
        Unit normal from the right to the left face: at a corner that of the one edge and of the
        other, at a lesser bend the mean weighted with their lengths, which is the direction of the
        force by a uniform pressure.
    """

    left: Ints
    right: Ints
    normal: Floats

    def opening(self, displacement: Floats) -> Floats:
        """Distance of the nodes along the normal, (k,) [mm]; negative where the faces overlap.

        Parameters
        ----------
        displacement : (n, 2) float
            Displacement of all nodes [mm].
        """
        jump = displacement[self.left] - displacement[self.right]
        return np.einsum("ki,ki->k", jump, self.normal)


@dataclass(frozen=True)
class Turning:
    """Rotation of a crack: the least-squares fit to the deformed edges of its faces.

    Attributes
    ----------
    rotation : complex
        Unit complex number of the rotation.
    nodes : (m,) int
        The nodes at the ends of the edges.
    slope : (m,) complex
        Derivative of the logarithm of rotation and stretch by u_x + i u_y of the nodes [1/mm].
    """

    rotation: complex
    nodes: Ints
    slope: npt.NDArray[np.complex128]

    @property
    def angle_slope(self) -> Floats:
        """Derivative of the angle by the displacement of the nodes [1/mm], (m, 2)."""
        return np.column_stack([self.slope.imag, self.slope.real])

    @property
    def stretch_slope(self) -> Floats:
        """Derivative of the logarithm of the stretch [1/mm], (m, 2)."""
        return np.column_stack([self.slope.real, -self.slope.imag])


def face_pairs(grid: Grid, crack: str, turning: Turning | None = None) -> FacePairs:
    """Pair the nodes on the two faces of a crack.

    Parameters
    ----------
    grid : Grid
    crack : str
    turning : Turning, optional
        Rotation of the normals, at finite deformation; default: none. Variation of the rotation
        along the crack, and sliding by more than an element, are neglected.
    """
    left, right = _edges(grid, crack)
    along = grid.nodes[left[:, 1]] - grid.nodes[left[:, 0]]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    nodes = np.stack([left, right], axis=2).reshape(-1, 2)
    by_edge = np.repeat(across, left.shape[1], axis=0)
    pairs, first, number = np.unique(nodes, axis=0, return_index=True, return_inverse=True)
    normal = np.zeros((len(pairs), 2))
    np.add.at(normal, number.ravel(), by_edge)
    last = len(nodes) - 1 - np.unique(nodes[::-1], axis=0, return_index=True)[1]
    before, behind = by_edge[first], by_edge[last]
    sharp = np.abs(turn(before, behind)) > CORNER
    normal[sharp] = before[sharp]
    pairs = np.concatenate([pairs, pairs[sharp]])
    normal = np.concatenate([normal, behind[sharp]])
    normal /= np.hypot(*normal.T)[:, None]
    if turning is not None:
        turned = turning.rotation * (normal[:, 0] + 1j * normal[:, 1])
        normal = np.column_stack([turned.real, turned.imag])
    doubled = pairs[:, 0] != pairs[:, 1]
    return FacePairs(pairs[doubled, 0], pairs[doubled, 1], normal[doubled])


def turning_of(grid: Grid, crack: str, shape: Floats) -> Turning:
    """Find the rotation of a crack.

    Parameters
    ----------
    grid : Grid
    crack : str
    shape : (n, 2) float
        Displacement of the nodes [mm].

    Notes
    -----
    With the undeformed edges r and the deformed edges m of both faces as complex numbers, the
    minimum of sum |m - s r|^2 is at s proportional to sum conj(r) m. Its argument is the rotation.
    """
    sides = _edges(grid, crack)
    at = shape[:, 0] + 1j * shape[:, 1]
    start, end = sides[0][:, 0], sides[0][:, 1]
    along = grid.nodes[end] - grid.nodes[start]
    rest = along[:, 0] + 1j * along[:, 1]
    fit = sum(complex(np.sum(np.conj(rest) * (rest + at[s[:, 1]] - at[s[:, 0]]))) for s in sides)
    ends = np.concatenate([part for s in sides for part in (s[:, 1], s[:, 0])])
    parts = np.concatenate([np.conj(rest), -np.conj(rest)] * 2) / fit
    nodes, number = np.unique(ends, return_inverse=True)
    slope = np.zeros(len(nodes), complex)
    np.add.at(slope, number, parts)
    return Turning(fit / abs(fit), nodes, slope)


def _edges(grid: Grid, crack: str) -> tuple[Ints, Ints]:
    """Nodes of the edges on the left and on the right face, in the same order."""
    faces = grid.crack_faces[crack]
    left, right = grid.edge_nodes(faces[:, 0]), grid.edge_nodes(faces[:, 1])
    # The edges of the right face have the opposite direction.
    return left, right[:, grid.element.turned]


def smallest_openings(grid: Grid, displacement: Floats, finite: bool = False) -> dict[str, float]:
    """Find the smallest opening of the faces of each crack.

    Parameters
    ----------
    grid : Grid
    displacement : (n, 2) float
        Displacement of the nodes [mm].
    finite : bool
        Whether the normals rotate with the crack.

    Returns
    -------
    dict of str to float
        By crack [mm]: negative if the faces overlap, otherwise zero, the opening at the tip.
    """
    smallest = {}
    for crack in grid.crack_faces:
        turning = turning_of(grid, crack, displacement) if finite else None
        pairs = face_pairs(grid, crack, turning)
        smallest[crack] = float(pairs.opening(displacement).min(initial=0.0))
    return smallest
