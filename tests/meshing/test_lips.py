"""Cracks that are open in the mesh file give the same body as closed ones."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_files import N, Square, along, node, scene_of
from meshing_scenes import assert_sound

from cfmpm.errors import SceneError
from cfmpm.meshing import triangulate
from cfmpm.simulation import run

HALF = N // 2


def edge_crack(square: Square, *, mouth: bool = True) -> dict[int, int]:
    """Open the square from the left at half height up to (3, 4); the mouth may stay closed."""
    first = 0 if mouth else 1
    return square.open_above([(x, HALF) for x in range(first, 3)])


def lower_lip(square: Square) -> list[str]:
    edge_crack(square)
    square.lines["crack"] = along((0, HALF), (3, HALF))
    return ["crack"]


def upper_lip(square: Square) -> list[str]:
    own = edge_crack(square)
    lip = along((0, HALF), (3, HALF))
    square.lines["crack"] = [(own.get(a, a), own.get(b, b)) for a, b in lip]
    return ["crack"]


def both_lips(square: Square) -> list[str]:
    upper_lip(square)
    square.lines["crack"] += along((0, HALF), (3, HALF))
    return ["crack"]


def closed_mouth(square: Square) -> list[str]:
    """As gmsh's plugin leaves it without OpenBoundaryPhysicalGroup."""
    edge_crack(square, mouth=False)
    square.lines["crack"] = along((0, HALF), (3, HALF))
    return ["crack"]


def line_beyond_the_lips(square: Square) -> list[str]:
    """Surfaces with common nodes ahead of the crack; crack and border are one curve."""
    edge_crack(square)
    square.lines["crack"] = along((0, HALF), (6, HALF))
    return ["crack"]


def almost_the_same_places(square: Square) -> list[str]:
    own = edge_crack(square)
    for new in own.values():
        x, y = square.nodes[new]
        square.nodes[new] = (x + 2e-9, y - 1e-9)
    square.lines["crack"] = along((0, HALF), (3, HALF))
    return ["crack"]


OPEN = [
    lower_lip,
    upper_lip,
    both_lips,
    closed_mouth,
    line_beyond_the_lips,
    almost_the_same_places,
]


@pytest.mark.parametrize("opened", OPEN, ids=lambda f: f.__name__)
def test_an_open_crack_ends_where_its_lips_meet(tmp_path, opened):
    square = Square()
    cracks = opened(square)
    t = triangulate(scene_of(square.write(tmp_path / "a.msh"), cracks=cracks))
    assert_sound(t)
    (line,) = t.cracks.values()
    places = t.nodes[[*line[:, 0], line[-1, 1]]]
    np.testing.assert_allclose(places, [(x, HALF) for x in range(4)], atol=1e-8)
    assert len(t.nodes) == (N + 1) ** 2


def test_factors_are_those_of_the_closed_file(tmp_path):
    closed, opened = Square(), Square()
    closed.lines["crack"] = along((0, HALF), (3, HALF))
    lower_lip(opened)
    one, other = (
        run(scene_of(square.write(tmp_path / f"{i}.msh"), cracks=["crack"])).history
        for i, square in enumerate((closed, opened))
    )
    assert one["K_I"].item() > 20
    for name in ("K_I", "K_II", "G", "J", "tip_x", "tip_y"):
        np.testing.assert_allclose(other[name], one[name], rtol=1e-9, atol=1e-9)


def test_an_open_crack_inside_has_two_tips(tmp_path):
    square = Square()
    square.open_above([(x, HALF) for x in range(3, 6)])
    square.lines["crack"] = along((2, HALF), (6, HALF))
    t = triangulate(scene_of(square.write(tmp_path / "a.msh"), cracks=["crack"]))
    line = t.cracks["crack"]
    np.testing.assert_array_equal(t.nodes[[line[0, 0], line[-1, 1]]], [(2, HALF), (6, HALF)])


def refusal(path, **scene) -> tuple[str, str]:
    with pytest.raises(SceneError) as caught:
        triangulate(scene_of(path, **scene))
    (problem,) = caught.value.problems
    assert "\n" not in problem.reason
    return problem.key, problem.reason


def test_an_open_crack_that_is_not_listed_is_refused(tmp_path):
    square = Square()
    lower_lip(square)
    key, reason = refusal(square.write(tmp_path / "a.msh"))
    assert key == "mesh_file.file"
    assert "is open along 3 places where nodes coincide, from (0, 4) to (2, 4)" in reason
    assert "list crack in mesh_file.cracks" in reason
    del square.lines["crack"]
    _, reason = refusal(square.write(tmp_path / "a.msh"))
    assert "put it into a physical curve" in reason


def test_surfaces_apart_along_all_their_border_are_refused(tmp_path):
    square = Square()
    square.open_above([(x, HALF) for x in range(N + 1)])
    square.lines["crack"] = along((0, HALF), (3, HALF))
    _, reason = refusal(square.write(tmp_path / "a.msh"), cracks=["crack"])
    assert "is also open along 5 places" in reason
    _, reason = refusal(square.write(tmp_path / "b.msh"))
    assert "is in 2 parts that share no nodes" in reason


def test_lips_with_nodes_of_their_own_are_refused(tmp_path):
    """The side (1, 4) to (2, 4) of the upper face has an additional node at its midpoint."""
    square = Square()
    own = edge_crack(square)
    square.lines["crack"] = along((0, HALF), (3, HALF))
    middle = len(square.nodes)
    square.nodes.append((1.5, HALF))
    a, b = own[node(1, HALF)], own[node(2, HALF)]
    (i,) = [i for i, t in enumerate(square.triangles) if {a, b} <= set(t)]
    (c,) = set(square.triangles[i]) - {a, b}
    square.triangles[i] = (a, middle, c)
    square.triangles.append((middle, b, c))
    key, reason = refusal(square.write(tmp_path / "a.msh"), cracks=["crack"])
    assert key == "mesh_file.cracks[0]"
    assert "its lips do not have the same nodes" in reason


def test_a_part_of_the_outline_is_no_crack(tmp_path):
    square = Square()
    key, reason = refusal(square.write(tmp_path / "a.msh"), cracks=["top"], loads=PUSH)
    assert key == "mesh_file.cracks[0]"
    assert "does not lie inside the body" in reason
    assert "second lip" in reason


PUSH = ({"body_force": (0, 1)},)


def test_a_load_on_a_lip_is_refused_by_its_name(tmp_path):
    square = Square()
    lower_lip(square)
    loads = [{"edge": "crack", "traction": (0, 1)}]
    key, reason = refusal(square.write(tmp_path / "a.msh"), cracks=["crack"], loads=loads)
    assert (key, reason) == ("loads[0].edge", "crack is a crack")
