"""The faces of cracks: pairs of coincident nodes, and their opening."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cfmpm.grid import Floats, Grid, Ints


@dataclass(frozen=True)
class FacePairs:
    """The nodes of a crack that are doubled, one on each face.

    Attributes
    ----------
    left, right : (k,) int
        Coincident nodes of the faces on the left and right of the crack. Tips are no pair.
    normal : (k, 2) float
        Unit normal from the right face to the left one: where the crack is bent, the mean of the
        edges on both sides by their length, along which a uniform pressure acts on the node.
    """

    left: Ints
    right: Ints
    normal: Floats

    def opening(self, displacement: Floats) -> Floats:
        """Distance of the nodes along the normal, (k,); negative where the faces overlap.

        Parameters
        ----------
        displacement : (n, 2) float
            Of all nodes [mm].
        """
        jump = displacement[self.left] - displacement[self.right]
        return np.einsum("ki,ki->k", jump, self.normal)


def face_pairs(grid: Grid, crack: str, shape: Floats | None = None) -> FacePairs:
    """Pair the nodes on the two faces of a crack.

    Parameters
    ----------
    grid : Grid
    crack : str
    shape : (n, 2) float, optional
        Displacement of the nodes [mm] with which the faces turn: normals are then those of the
        middle between the faces; default: as the faces lie at rest.
    """
    faces = grid.crack_faces[crack]
    left, right = grid.edge_nodes(faces[:, 0]), grid.edge_nodes(faces[:, 1])
    # The right face runs the other way: its ends change places.
    right[:, [0, 1]] = right[:, [1, 0]]
    along = grid.nodes[left[:, 1]] - grid.nodes[left[:, 0]]
    if shape is not None:
        for face in (left, right):
            along = along + 0.5 * (shape[face[:, 1]] - shape[face[:, 0]])
    turned = np.column_stack([-along[:, 1], along[:, 0]])
    nodes = np.stack([left, right], axis=2).reshape(-1, 2)
    pairs, number = np.unique(nodes, axis=0, return_inverse=True)
    normal = np.zeros((len(pairs), 2))
    np.add.at(normal, number.ravel(), np.repeat(turned, left.shape[1], axis=0))
    normal /= np.hypot(*normal.T)[:, None]
    doubled = pairs[:, 0] != pairs[:, 1]
    return FacePairs(pairs[doubled, 0], pairs[doubled, 1], normal[doubled])


def smallest_openings(
    grid: Grid, displacement: Floats, shape: Floats | None = None
) -> dict[str, float]:
    """Find the smallest opening of the faces of each crack.

    Parameters
    ----------
    grid : Grid
    displacement : (n, 2) float
        Of the nodes [mm].
    shape : (n, 2) float, optional
        As in `face_pairs`.

    Returns
    -------
    dict of str to float
        By crack [mm]: zero where the faces do not overlap, as at a tip; negative where they do.
    """
    return {
        crack: float(face_pairs(grid, crack, shape).opening(displacement).min(initial=0.0))
        for crack in grid.crack_faces
    }
