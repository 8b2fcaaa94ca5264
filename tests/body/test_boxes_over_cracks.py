"""A support in a box that contains a crack acts on the boundary, and on neither crack face."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mesh_files import Square, along

import cfmpm
from cfmpm.build import build
from cfmpm.errors import SceneError
from cfmpm.scene import Scene, scene_from_dict

OVER = [[-1, 1], [3, 7]]
MOUTH = [[-1, 1], [0.005, 7]]
PULL = {"edge": "right", "traction": [0, 1]}


def scene_of(folder: Path, body: str, element: str, box: Any, **what: Any) -> Scene:
    """A square of 8 mm with a crack from the middle of its left side, 4 mm long."""
    grip = {"name": "grip", "box": box, **(what or {"displacement": {"x": 0, "y": 0.25}})}
    scene: dict[str, Any] = {
        "name": "square",
        "material": {"E": 1000.0, "nu": 0.3},
        "loads": [grip, PULL],
        "mesh": {"element": element},
    }
    if body == "geometry":
        corners = {"bottom": [0, 0], "right": [8, 0], "top": [8, 8], "left": [0, 8]}
        outline = [{"at": at, "edge": name} for name, at in corners.items()]
        scene["geometry"] = {"outline": outline, "cracks": [{"points": [[0, 4], [4, 4]]}]}
        scene["mesh"] |= {"size": 1, "grading": "uniform"}
    else:
        square = Square()
        square.lines |= {"right": along((8, 0), (8, 8)), "crack_1": along((0, 4), (4, 4))}
        if body == "mesh file, open":
            own = square.open_above([(x, 4) for x in range(4)])
            square.lines["crack_1"] += [
                (own.get(a, a), own.get(b, b)) for a, b in square.lines["crack_1"]
            ]
        path = square.write(folder / "square.msh")
        scene["mesh_file"] = {"file": str(path), "cracks": ["crack_1"]}
    return scene_from_dict(scene)


@pytest.mark.parametrize("element", ["T3", "T6"])
@pytest.mark.parametrize("body", ["geometry", "mesh file", "mesh file, open"])
class TestSupport:
    def test_the_boundary_is_held_and_no_crack_face(
        self, tmp_path: Path, body: str, element: str
    ) -> None:
        built = build(scene_of(tmp_path, body, element, OVER))
        grid, loading = built.grid, built.loading
        x, y = grid.nodes.T
        inside = (x < 1e-9) & (y > 1 - 1e-9) & (y < 7 + 1e-9)
        np.testing.assert_array_equal(loading.prescribed.all(axis=1), inside)
        # Both nodes of the mouth, one on each face; of the faces behind it none.
        faces = (np.abs(y - 4) < 1e-9) & (x < 3)
        assert np.count_nonzero(inside & faces) == 2
        assert np.count_nonzero(faces) >= 6
        np.testing.assert_array_equal(
            loading.proportional.displacement[inside], [[0, 0.25]] * inside.sum()
        )

    def test_the_solution_is_that_of_a_box_at_the_boundary(
        self, tmp_path: Path, body: str, element: str
    ) -> None:
        over, mouth = (
            cfmpm.run(scene_of(tmp_path, body, element, box)).history for box in (OVER, MOUTH)
        )
        for name in ("K_I", "K_II", "J", "reaction_x", "reaction_y"):
            np.testing.assert_allclose(over[name], mouth[name], rtol=1e-9)
        told, not_told = (
            [text for text in json.loads(one.attrs["warnings"]) if "box" in text]
            for one in (over, mouth)
        )
        assert told == [
            "grip: its box contains 3 mm of crack_1; the displacement acts on the boundary in the "
            "box, not on crack faces: end the box at the boundary, or name an edge"
        ]
        assert not not_told


@pytest.mark.parametrize("body", ["geometry", "mesh file"])
class TestRefused:
    def test_tractions_on_crack_faces(self, tmp_path: Path, body: str) -> None:
        with pytest.raises(SceneError) as caught:
            build(scene_of(tmp_path, body, "T3", OVER, traction=[1, 0]))
        (problem,) = caught.value.problems
        assert problem.key == "loads[0].box"
        assert problem.reason == (
            "contains 3 mm of crack_1 and 6 mm of the boundary: a traction cannot act on crack "
            "faces; end the box at the boundary, or use an edge"
        )

    def test_supports_without_boundary(self, tmp_path: Path, body: str) -> None:
        with pytest.raises(SceneError) as caught:
            build(scene_of(tmp_path, body, "T3", [[1, 3], [3, 5]]))
        (problem,) = caught.value.problems
        assert problem.reason == (
            "contains no part of the boundary, only 2 mm of crack_1, whose faces a load cannot act "
            "on"
        )
