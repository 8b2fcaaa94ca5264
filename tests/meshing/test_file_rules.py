"""Rules of a geometry apply to mesh files; invalid meshes are refused."""

from __future__ import annotations

import re

import numpy as np
import pytest
from mesh_files import PULL, N, Square, along, node, scene_of

from cfmpm.errors import SceneError
from cfmpm.meshing import triangulate
from cfmpm.simulation import run

HALF = N // 2


def refusals(path, **scene) -> dict[str, str]:
    with pytest.raises(SceneError) as caught:
        triangulate(scene_of(path, **scene))
    assert all("\n" not in problem.reason for problem in caught.value.problems)
    return {problem.key: problem.reason for problem in caught.value.problems}


def cracked(**lines) -> Square:
    square = Square()
    square.lines |= {name: along(*places) for name, places in lines.items()}
    return square


CRACKS = {
    "end to end": (
        {"a": [(0, 4), (2, 4)], "b": [(2, 4), (4, 4)]},
        "mesh_file.cracks[1]",
        "meets a end to end",
    ),
    "end to end in an angle": (
        {"a": [(0, 4), (2, 4)], "b": [(2, 4), (4, 6)]},
        "mesh_file.cracks[1]",
        "meets a end to end",
    ),
    "crossing": (
        {"a": [(2, 4), (6, 4)], "b": [(4, 2), (4, 6)]},
        "mesh_file.cracks[1]",
        "crosses or touches a",
    ),
    "branch": (
        {"a": [(0, 4), (6, 4)], "b": [(4, 4), (4, 6)]},
        "mesh_file.cracks[1]",
        "crosses or touches a",
    ),
    "the same twice": (
        {"a": [(0, 4), (3, 4)], "b": [(0, 4), (3, 4)]},
        "mesh_file.cracks[1]",
        "has sides of a too",
    ),
    "a part twice": (
        {"a": [(0, 4), (3, 4)], "b": [(2, 4), (5, 4)]},
        "mesh_file.cracks[1]",
        "has sides of a too",
    ),
    "through": ({"a": [(0, 4), (N, 4)]}, "mesh_file.cracks[0]", "cuts the body in two"),
    "over a corner": ({"a": [(0, 2), (2, 2), (2, 0)]}, "mesh_file.cracks[0]", "cuts the body"),
    "touching the edge": (
        {"a": [(1, 1), (2, 0), (3, 1)]},
        "mesh_file.cracks[0]",
        "touches bottom between its ends",
    ),
}


def usable(square: Square) -> Square:
    """Flip the diagonals of the cells along the cracks above."""
    for x, y in ((1, 0),):
        old = [
            (node(x, y), node(x + 1, y), node(x + 1, y + 1)),
            (node(x, y), node(x + 1, y + 1), node(x, y + 1)),
        ]
        square.triangles = [t for t in square.triangles if t not in old]
        square.triangles += [
            (node(x, y), node(x + 1, y), node(x, y + 1)),
            (node(x + 1, y), node(x + 1, y + 1), node(x, y + 1)),
        ]
    return square


@pytest.mark.parametrize("kind", CRACKS)
def test_cracks_of_a_file_obey_the_rules(tmp_path, kind):
    lines, key, reason = CRACKS[kind]
    path = usable(cracked(**lines)).write(tmp_path / "a.msh")
    assert reason in refusals(path, cracks=list(lines))[key]


@pytest.mark.parametrize(
    ("point", "reason"),
    [
        ((0, 4), "is on a: a load on a crack needs"),
        ((1, 4), "is on a: a load on a crack needs"),
        ((3, 4), "is on a: a load on a crack needs"),
        ((9, 4), "is outside the body"),
        ((5.3, 4.1), "the mesh has no node there; the nearest is at [5, 4]"),
    ],
)
def test_points_of_loads(tmp_path, point, reason):
    path = cracked(a=[(0, 4), (3, 4)]).write(tmp_path / "a.msh")
    loads = [*PULL, {"name": "pin", "point": point, "force": (0, 1)}]
    assert reason in refusals(path, cracks=["a"], loads=loads)["loads[3].point"]


def test_boxes_of_loads(tmp_path):
    path = Square().write(tmp_path / "a.msh")
    loads = [
        {"box": ((2, 2), (3, 3)), "traction": (0, 1)},
        {"box": ((2, 2), (3, 2)), "traction": (0, 1)},
    ]
    reasons = refusals(path, loads=loads)
    assert "contains no part of the boundary" in reasons["loads[0].box"]
    assert "has zero width or height" in reasons["loads[1].box"]
    cut = cracked(a=[(0, 4), (3, 4)]).write(tmp_path / "cut.msh")
    over = [{"box": ((-1, 3.5), (2, 4.5)), "traction": (0, 1)}]
    reason = refusals(cut, cracks=["a"], loads=over)["loads[0].box"]
    assert "contains 2 mm of a and 1 mm of the boundary: a traction cannot act on crack" in reason


def test_regions_that_overlap(tmp_path):
    square = Square(surfaces={"one": [0, 1, 2, 3], "two": [3, 4], "three": [7]})
    path = square.write(tmp_path / "a.msh")
    reasons = refusals(path, regions=["one", "three", "two"])
    assert reasons == {"mesh_file.regions[2]": "overlaps region one, in 1 triangles"}
    t = triangulate(scene_of(path, regions=["one", "three"]))
    np.testing.assert_array_equal(np.bincount(t.regions), [2 * N * N - 5, 4, 1])


def test_one_curve_in_two_groups_of_loads(tmp_path):
    """Supports must agree; a traction that a support carries is refused; tractions add up."""
    square = Square()
    square.lines["right"] = along((N, 0), (N, N))
    square.lines["middle"] = along((6, N), (2, N))
    square.lines["all"] = square.lines["top"] + square.lines["right"]
    path = square.write(tmp_path / "a.msh")
    held = [
        {"edge": "all", "displacement": {"y": 0}},
        {"edge": "middle", "traction": (0, 5)},
    ]
    assert "has no effect: loads[0]" in refusals(path, loads=held)["loads[1].traction"]
    both = [*PULL[1:], {"edge": "top", "displacement": {"y": 1}}]
    both.append({"edge": "middle", "displacement": {"y": 2}})
    with pytest.raises(SceneError, match="prescribes u_y = 2 mm where"):
        run(scene_of(path, loads=both))
    added = run(scene_of(path, loads=[*PULL, {"edge": "middle", "traction": (0, 5)}]))
    total = added.history["reaction_y"].sel(boundary="bottom").item()
    assert total == pytest.approx(-(10 * N + 5 * 4), rel=1e-9)


def test_further_rules_of_a_geometry(tmp_path):
    path = cracked(a=[(0, 4), (3, 4)]).write(tmp_path / "a.msh")
    reasons = refusals(path, cracks=["a"], fracture={"radii": [1.0, 20.0]})
    assert reasons == {"fracture.radii[1]": "20 mm is larger than the body, 8 mm"}


def test_warnings_do_not_advise_keys_that_a_file_has_no_use_for(tmp_path):
    """A coarse grid at a crack, and a slot with a sharp root."""
    square = cracked(a=[(0, 4), (1, 4)])
    for new in square.open_above([(x, 6) for x in range(4)]).values():
        x, y = square.nodes[new]
        square.nodes[new] = (x, y + 0.02 * (4 - x))
    history = run(scene_of(square.write(tmp_path / "a.msh"), cracks=["a"])).history
    told = history.attrs["warnings"]
    assert "below 4 element sizes: give the mesh file elements of at most" in told
    assert "or at a kink of the crack: give the mesh file elements of at most" in told
    assert "sharp notch" in told
    assert "with a physical curve from (0, 6.04) to (4, 6) that mesh_file.cracks lists" in told
    for key in ("mesh.size", "mesh.grading", "geometry."):
        assert key not in told


def halved(square):
    """Each triangle of a grid cut into four."""
    nodes, middles = list(square.nodes), {}

    def middle(a, b):
        pair = (min(a, b), max(a, b))
        if pair not in middles:
            middles[pair] = len(nodes)
            nodes.append(tuple(np.mean([square.nodes[a], square.nodes[b]], axis=0).tolist()))
        return middles[pair]

    triangles = []
    for a, b, c in square.triangles:
        d, e, f = middle(a, b), middle(b, c), middle(c, a)
        triangles += [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]
    lines = {
        name: [half for a, b in pairs for half in ((a, middle(a, b)), (middle(a, b), b))]
        for name, pairs in square.lines.items()
    }
    return Square(nodes, triangles, lines)


def test_what_is_advised_for_a_file_helps(tmp_path):
    """Elements of the size that is advised, and a crack in place of a notch."""
    square, h = cracked(a=[(0, 4), (3, 4)], b=[(0, 6), (4, 6)]), 1.0
    for _ in range(3):
        history = run(scene_of(square.write(tmp_path / "a.msh"), cracks=["a", "b"])).history
        assert "sharp notch" not in history.attrs["warnings"]
        assert np.isfinite(history["K_I"]).all()
        sizes = re.findall(r"elements of at most ([\d.]+) mm there", history.attrs["warnings"])
        if not sizes:
            break
        assert min(map(float, sizes)) < h
        square, h = halved(square), 0.5 * h
    assert not sizes
    assert h < 1.0


def test_an_edge_may_be_called_boundary(tmp_path):
    square = Square()
    square.lines["boundary"] = square.lines.pop("top")
    loads = [{"edge": "boundary", "traction": (0, 10)}, *PULL[1:]]
    t = triangulate(scene_of(square.write(tmp_path / "a.msh"), loads=loads))
    assert {name: len(pairs) for name, pairs in t.edges.items()} == {
        "bottom": N,
        "boundary": N,
        "boundary_2": 2 * N,
    }


@pytest.mark.parametrize(
    ("moved", "to"),
    [
        ((3, 3), (5.5, 3.2)),  # across its neighbours
        ((3, 3), (-1, 3)),  # out of the body
        ((3, 3), (4, 3)),  # onto its neighbour
        ((0, 3), (2.5, 3)),  # from the boundary to the inside
        ((0, 0), (1.2, 1.1)),  # a corner over the only triangle behind it
        ((N, N), (-2, -3)),  # a corner across the whole body
    ],
)
def test_tangled_meshes_are_refused(tmp_path, moved, to):
    square = Square()
    square.nodes[node(*moved)] = tuple(map(float, to))
    reason = refusals(square.write(tmp_path / "a.msh"), loads=PULL[:2])["mesh_file.file"]
    assert "is tangled" in reason or "have no area" in reason


def test_a_body_that_lies_over_itself_is_refused(tmp_path):
    """A strip that runs around twice: every triangle is valid, but the body overlaps itself."""
    square = Square()
    square.nodes = [
        (float((5 + y) * np.cos(1.2 * x)), float((5 + y) * np.sin(1.2 * x)))
        for y in range(N + 1)
        for x in reversed(range(N + 1))
    ]
    loads = ({"edge": "top", "traction": (0, 1)},)
    reason = refusals(square.write(tmp_path / "a.msh"), loads=loads)["mesh_file.file"]
    assert "is tangled" in reason
    assert "triangles lie over each other" in reason


def test_surfaces_that_meet_without_common_nodes_are_refused(tmp_path):
    """They share the ends of their border, but not the nodes along it."""
    square = Square()
    own = square.open_above([(x, HALF) for x in range(1, N)])
    for new in own.values():
        x, y = square.nodes[new]
        square.nodes[new] = (x + 0.3, y)
    reason = refusals(square.write(tmp_path / "a.msh"))["mesh_file.file"]
    assert reason.startswith("hangs together by a single node at (")
    assert "surfaces that meet have to share all nodes" in reason


def test_an_outline_that_touches_itself_is_refused(tmp_path):
    """A strip bent to a ring whose ends coincide but have separate nodes."""
    square = Square()
    square.nodes = []
    for y in range(N + 1):
        for x in range(N + 1):
            r = 5 + y if x < N else 5.55 + 7 * y / N
            angle = -2 * np.pi * x / N
            y_of = float(r * np.sin(angle)) if x % N else 0.0
            square.nodes.append((float(r * np.cos(angle)), y_of))
    loads = ({"edge": "top", "traction": (0, 1)},)
    reason = refusals(square.write(tmp_path / "a.msh"), loads=loads)["mesh_file.file"]
    assert "crosses or touches itself near (" in reason
    assert "surfaces that meet have to share their nodes" in reason


def test_cracks_from_a_hole_to_the_outline(tmp_path):
    """One crack opens the hole, two cut the body in two."""
    square = cracked(left=[(0, 4), (3, 4)], right=[(4, 4), (N, 4)])
    square.triangles = [
        t
        for t in square.triangles
        if not all(3 <= square.nodes[k][0] <= 4 and 3 <= square.nodes[k][1] <= 4 for k in t)
    ]
    path = square.write(tmp_path / "a.msh")
    for name in ("left", "right"):
        assert len(triangulate(scene_of(path, cracks=[name])).cracks[name]) in (3, 4)
    reasons = refusals(path, cracks=["left", "right"])
    assert reasons == {"mesh_file.cracks[1]": "cuts the body in two"}


def test_two_lines_in_one_group_are_no_crack(tmp_path):
    square = cracked(a=[(0, 4), (3, 4)])
    square.lines["a"] += along((5, 4), (7, 4))
    reasons = refusals(square.write(tmp_path / "a.msh"), cracks=["a"])
    assert "each crack needs a physical curve of its own" in reasons["mesh_file.cracks[0]"]


def test_parts_that_share_one_node_are_refused(tmp_path):
    square = Square()
    square.triangles = [
        t
        for t in square.triangles
        if all(square.nodes[k][0] <= 4 and square.nodes[k][1] <= 4 for k in t)
        or all(square.nodes[k][0] >= 4 and square.nodes[k][1] >= 4 for k in t)
    ]
    loads = ({"body_force": (0, 1)},)
    reason = refusals(square.write(tmp_path / "a.msh"), loads=loads)["mesh_file.file"]
    assert reason.startswith("hangs together by a single node at (4, 4)")
