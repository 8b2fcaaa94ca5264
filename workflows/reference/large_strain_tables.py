"""Reference results at large strain: the single edge crack of section 5.1, pulled far.

``python -m workflows.reference.large_strain_tables`` writes ``large_strain_fem.csv`` and
``large_strain_dead_load.csv`` beside itself (an hour).
"""

from __future__ import annotations

import csv
import logging
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cfmpm.body.grid import build_grid
from cfmpm.meshing import triangulate
from cfmpm.scene import expand
from cfmpm.scene.reading import scene_from_dict
from workflows.reference import total_lagrangian as fem
from workflows.reference.total_lagrangian import Floats, Ints

WIDTH, HEIGHT, CRACK = 500.0, 1000.0, 100.0
E, NU = 210e3, 0.3
RING = 50.0
ELONGATIONS = [*(0.05 * k for k in range(1, 11)), 1.0]
TRACTIONS = [10.0, 100.0, 1e3, *(5e3 * k for k in range(1, 21))]
log = logging.getLogger(__name__)
FOLDER = Path(__file__).parent
PROBLEM = """\
# Single edge crack of section 5.1: 500 x 1000 mm, a = 100 mm, E = 210e3 MPa, nu = 0.3, plane
# strain, 1 mm thick. Computed by workflows/reference/total_lagrangian (scikit-fem): one point
# (T3), three (T6), ring of J from 25 to 50 mm in the reference configuration; far size 50 mm.
"""


@dataclass(frozen=True)
class EdgeCrack:
    """The cracked plate as a mesh.

    Attributes
    ----------
    nodes, elements
        As in `total_lagrangian.Solid`.
    tip : int
        Node at the tip.
    """

    nodes: Floats
    elements: Ints
    tip: int

    @property
    def plateau(self) -> Floats:
        """Weight of the ring of J."""
        return fem.ring_plateau(self.nodes, self.nodes[self.tip], RING)

    @property
    def anchor(self) -> int:
        """The node where the ligament meets the right side, or the next to it."""
        away = self.nodes - np.array([WIDTH, HEIGHT / 2])
        return int(np.argmin(np.hypot(*away.T)))

    def at(self, y: float) -> Ints:
        """Nodes of an end."""
        return np.flatnonzero(np.isclose(self.nodes[:, 1], y))


def edge_crack(
    element: str, tip_size: float, size: float = 50.0, growth: float = 0.05
) -> EdgeCrack:
    """Mesh the plate; sizes in mm."""
    family = {"kind": "single_edge", "width": WIDTH, "height": HEIGHT, "crack_length": CRACK}
    grading = {"tip_size": tip_size, "growth": growth}
    scene = {
        "name": "plate",
        "family": {**family, "traction": 10},
        "material": {"E": E, "nu": NU},
        "mesh": {"element": element, "size": size, "grading": grading},
    }
    grid = build_grid(triangulate(expand(scene_from_dict(scene))), element)
    return EdgeCrack(grid.nodes, grid.elements, grid.tips[0].node)


def pulled(plate: EdgeCrack, solid: fem.Solid) -> fem.Loads:
    """Ends moved apart by the height at factor one, free to move sideways."""
    loads = fem.hold(fem.no_loads(solid), plate.at(0.0), 1, -HEIGHT / 2)
    loads = fem.hold(loads, plate.at(HEIGHT), 1, HEIGHT / 2)
    return fem.hold(loads, plate.anchor, 0)


def under_dead_traction(plate: EdgeCrack, solid: fem.Solid) -> fem.Loads:
    """A dead traction of 1 MPa on both ends at factor one, one node held.

    Nothing holds the rotation but the loads themselves: held at two nodes of an end, which turns
    as the plate bends, the plate would lean against them with a force that changes J by as much
    as its deformation does.
    """
    force = sum(
        fem.traction_force(solid, lambda x, y=y: np.isclose(x[1], y), (0.0, pull))
        for y, pull in ((0.0, -1.0), (HEIGHT, 1.0))
    )
    loads = replace(fem.no_loads(solid), force=force)
    return fem.hold(fem.hold(loads, plate.anchor, 0), plate.anchor, 1)


def first_pull(plate: EdgeCrack, solid: fem.Solid, traction: float) -> fem.Equilibrium:
    """Find the equilibrium under a first dead traction [MPa], where rotation gets its stiffness."""
    loads = under_dead_traction(plate, solid)
    held = fem.newton(solid, fem.hold(loads, plate.tip, 1), traction, fem.at_rest(solid))
    return fem.newton(solid, loads, traction, held)


def elongation_rows(
    law: str, element: str, tip_size: float, elongations: Sequence[float] = ELONGATIONS
) -> Iterator[dict[str, object]]:
    """Pull the plate; one row an elongation, the last where stability is lost."""
    plate = edge_crack(element, tip_size)
    solid = fem.make_solid(plate.nodes, plate.elements, law, E, NU)
    path = fem.follow(solid, pulled(plate, solid), elongations, first_step=0.01, resolution=1e-5)
    for state in _until_lost(path):
        yield {
            "law": law,
            "element": element,
            "tip_size": tip_size,
            "elongation": f"{state.factor:.5g}",
            "J": f"{fem.j_integral(solid, state.displacement, plate.plateau):.8g}",
            "force": f"{state.reaction[plate.at(HEIGHT), 1].sum():.8g}",
            "unknowns": plate.nodes.size,
            **_stability(solid, state),
        }


def traction_rows(
    law: str, element: str, tip_size: float, tractions: Sequence[float] = TRACTIONS
) -> Iterator[dict[str, object]]:
    """Pull the plate by dead tractions; one row a traction, the last where stability is lost."""
    plate = edge_crack(element, tip_size)
    solid = fem.make_solid(plate.nodes, plate.elements, law, E, NU)
    small = first_pull(plate, solid, 1e-2)
    linear = fem.j_integral(solid, small.displacement, plate.plateau) * 1e4
    start = first_pull(plate, solid, tractions[0])
    path = fem.follow(
        solid,
        under_dead_traction(plate, solid),
        tractions,
        first_step=tractions[0],
        resolution=1e-3 * tractions[0],
        start=start,
    )
    for state in _until_lost(path):
        v = state.displacement[:, 1]
        ends = v[plate.at(HEIGHT)].mean() - v[plate.at(0.0)].mean()
        yield {
            "law": law,
            "element": element,
            "tip_size": tip_size,
            "traction": f"{state.factor:.6g}",
            "elongation": f"{ends / HEIGHT:.6g}",
            "J": f"{fem.j_integral(solid, state.displacement, plate.plateau):.8g}",
            "J_linear": f"{linear * state.factor**2:.8g}",
            "unknowns": plate.nodes.size,
            **_stability(solid, state),
        }


def _until_lost(path: Iterator[fem.Equilibrium]) -> Iterator[fem.Equilibrium]:
    """Pass on the wanted states; where stability is lost, the last stable one and the next."""
    try:
        yield from path
    except fem.StabilityLostError as lost:
        log.info("%s", lost)
        yield lost.last
        if lost.unstable is not None:
            yield lost.unstable


def _stability(solid: fem.Solid, state: fem.Equilibrium) -> dict[str, object]:
    H = solid.displacement_gradient(state.displacement)
    least = fem.least_acoustic(solid.law, solid.lame, H).min() / solid.lame[1]
    return {
        "negative_pivots": state.negative_pivots,
        "acoustic": f"{least:.4f}",
        "stretch": f"{state.stretch:.4f}",
    }


def write(path: Path, comment: str, rows: Iterable[dict[str, object]]) -> None:
    """Write rows as CSV below a comment, each as soon as it is there."""
    with path.open("w", newline="") as file:
        file.write(PROBLEM + comment)
        writer = None
        for row in rows:
            if writer is None:
                writer = csv.DictWriter(file, list(row), lineterminator="\n")
                writer.writeheader()
            writer.writerow(row)
            file.flush()


COLUMNS = """\
# Columns: elongation = distance of the ends over height - 1, J [N/mm], force on the top [N/mm],
# unknowns of the mesh, negative pivots of the tangent, smallest eigenvalue over mu of the acoustic
# tensor N A N at any point, N a unit vector in the reference configuration (negative: not
# elliptic), largest stretch. Where it is negative the state depends on the mesh. A curve ends where
# no stable state follows within 1e-5 of the elongation, the largest stretch growing by a tenth at
# most; its last rows are the last stable state and, if one was found, the next with its negative
# pivots.
"""
DEAD = """\
# Dead traction [MPa] on both ends, the plate free to turn. J_linear is that of the same mesh at
# small strain. Other columns and the end of a curve as in large_strain_fem.csv; on the last mesh
# 10 and 100 MPa only.
"""


def main() -> None:
    """Write the tables."""
    logging.basicConfig(format="%(message)s")
    log.setLevel(logging.INFO)
    meshes = [(element, tip_size) for element in ("T3", "T6") for tip_size in (8.0, 4.0)]
    write(
        FOLDER / "large_strain_fem.csv",
        COLUMNS,
        (row for law in fem.LAWS for mesh in meshes for row in elongation_rows(law, *mesh)),
    )
    write(
        FOLDER / "large_strain_dead_load.csv",
        DEAD,
        (
            row
            for element, tip_size, tractions in (
                *((*mesh, TRACTIONS) for mesh in meshes),
                ("T6", 0.01, TRACTIONS[:2]),
            )
            for row in traction_rows("hencky", element, tip_size, tractions)
        ),
    )


if __name__ == "__main__":
    main()
