from __future__ import annotations

import hashlib
import itertools
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from meshing_scenes import (
    SQUARE,
    STEEL,
    areas,
    as_set,
    assert_sound,
    body,
    lengths,
    plate,
    sides,
    worst_quality,
)

from cfmpm.errors import MeshError
from cfmpm.meshing import expected_triangles, mesh_size, resolved_grading, triangulate
from cfmpm.scene.geometry import BodyShape, body_polygon, snap


def boundary_nodes(t):
    pairs, counts = sides(t)
    return set(pairs[counts == 1].ravel().tolist())


def crack_ends(t, name="crack_1"):
    line = t.cracks[name]
    return line[0, 0], line[-1, 1]


def hole(x, y, radius):
    return {"circle": {"centre": (x, y), "radius": radius}}


def crack(*points):
    return {"points": list(points)}


BODIES = {
    "plate": {},
    "edge crack": {"cracks": [crack((0, 5), (4, 5))]},
    "from a corner": {"cracks": [crack((0, 0), (4, 5))]},
    "internal crack": {"cracks": [crack((3, 3), (7, 6))]},
    "kinked crack": {"cracks": [crack((0, 5), (3, 5), (4, 6), (6, 6))]},
    "crack through": {"cracks": [crack((0, 5), (10, 6))]},
    "cracks from a hole": {
        "holes": [hole(5, 5, 1)],
        "cracks": [crack((6, 5), (8, 5)), crack((0, 5), (4, 5))],
    },
    "several cracks": {"cracks": [crack((0, i), (4, i + 0.5)) for i in (2, 5, 8)]},
    "cracks at a T": {"cracks": [crack((0, 5), (5, 5)), crack((3, 5), (3, 8))]},
    "cracks that cross": {"cracks": [crack((2, 5), (8, 5)), crack((5, 2), (5, 8))]},
    "holes": {
        "holes": [
            hole(2, 2, 0.5),
            {"polygon": [(4, 4), {"at": (6, 4), "through": (7, 5)}, (6, 6), (4, 6)]},
        ]
    },
    "clockwise": {"outline": SQUARE[::-1], "cracks": [crack((0, 5), (4, 5))]},
    "L": {"outline": [(0, 0), (10, 0), (10, 5), (5, 5), (5, 10), (0, 10)]},
    "disc": {
        "outline": [{"at": (0, 0), "through": (1, -1)}, {"at": (2, 0), "through": (1, 1)}],
        "cracks": [crack((0, 0), (1, 0))],
    },
    "thin ligament": {"cracks": [crack((0, 5), (9.99, 5))]},
    "tips that nearly touch": {"cracks": [crack((0, 5), (4.99, 5)), crack((5.01, 5), (10, 5))]},
    "short edge": {"outline": [(0, 0), (10, 0), (10, 10), (5.001, 10), (5, 10.001), (0, 10)]},
    "strip": {"outline": [(0, 0), (10, 0), (10, 0.05), (0, 0.05)]},
    "holes that nearly touch": {"holes": [hole(4, 5, 0.995), hole(6, 5, 0.995)]},
    "tiny hole": {"holes": [hole(5, 5, 0.01)]},
}


@pytest.mark.parametrize("grading", ["auto", "uniform"])
@pytest.mark.parametrize("name", BODIES)
def test_every_body_is_meshed_soundly(name, grading):
    scene = body(**BODIES[name], mesh={"grading": grading})
    t = triangulate(scene)
    assert_sound(t)
    assert worst_quality(t) > 0.25
    polygon = body_polygon(scene)
    curved = "hole" in name or name == "disc"
    assert areas(t).sum() == pytest.approx(polygon.area, rel=0.02 if curved else 1e-12)
    for i, line in enumerate(scene.geometry.cracks, 1):
        first, last = crack_ends(t, f"crack_{i}")
        np.testing.assert_array_equal(t.nodes[[first, last]], [line.points[0], line.points[-1]])
        expected = np.hypot(*np.diff(line.points, axis=0).T).sum()
        assert lengths(t, t.cracks[f"crack_{i}"]).sum() == pytest.approx(expected, rel=1e-12)


def reversed_line(corners):
    """The same closed line in the other sense."""
    given = [corner if isinstance(corner, dict) else {"at": corner} for corner in corners]
    return [
        {"at": corner["at"]} | ({"through": to["through"]} if "through" in to else {})
        for corner, to in zip(given[::-1], given[-2::-1] + given[-1:], strict=True)
    ]


ROUND = [(0, 0), {"at": (10, 0), "through": (11, 5)}, (10, 10), (0, 10)]
D = [(4, 4), {"at": (6, 4), "through": (7, 5)}, (6, 6), (4, 6)]
WEDGE = [(2, 7), (3, 7), (3, 8)]
INLAY = [(7, 1), (9, 1), (9, 3)]


@pytest.mark.parametrize("outline", [SQUARE, ROUND], ids=["straight", "with an arc"])
@pytest.mark.parametrize("shift", [0, 3])
def test_either_sense_of_each_closed_line_gives_the_same_body(outline, shift):
    """Outline, holes and regions, from any corner on, with a crack in either sense."""
    line = [(0, 5), (3, 5)]
    senses = itertools.product((list, reversed_line), repeat=4)
    for i, (way, of_hole, of_other, of_region) in enumerate(senses):
        corners = way(outline)
        corners = corners[shift:] + corners[:shift]
        scene = body(
            corners,
            holes=[{"polygon": of_hole(D)}, {"polygon": of_other(WEDGE)}][: i % 3],
            cracks=[crack(*line[:: (-1) ** i])],
            regions=[region("inlay", polygon=of_region(INLAY))],
            mesh={"size": 2},
        )
        t = triangulate(scene)
        assert_sound(t)
        assert lengths(t, t.cracks["crack_1"]).sum() == pytest.approx(3, rel=1e-12)
        assert areas(t)[t.regions == 1].sum() == pytest.approx(2, rel=1e-12)


def test_a_sharp_corner_is_meshed_as_well_as_it_can_be():
    t = triangulate(body([(0, 0), (10, 0), (10, 0.5)]))
    assert_sound(t)
    assert len(t.triangles) < 2000
    assert worst_quality(t) > 0.05


def test_a_grid_is_the_same_in_a_child_process(monkeypatch):
    scene = body(**BODIES["short edge"])
    here = triangulate(scene)
    monkeypatch.setattr("cfmpm.meshing.body.AT_ONCE", 10)
    there = triangulate(scene)
    np.testing.assert_array_equal(there.nodes, here.nodes)
    np.testing.assert_array_equal(there.triangles, here.triangles)


def test_lines_that_nearly_touch_do_not_make_endless_grids(monkeypatch):
    """The rules refuse this scene; without them meshing stops before the grid becomes too fine."""
    monkeypatch.setattr("cfmpm.meshing.body.MOST_ADDED", 5e3)
    beside = region("beside", polygon=[(0, 4.99999), (10, 4.99999), (10, 10), (0, 10)])
    with pytest.raises(MeshError, match=r"e-06 thin near \(.*, 5\).* lines that nearly touch"):
        triangulate(body(regions=[beside], cracks=[crack((0, 5), (3, 5))]))


def test_mouths_are_on_the_boundary_and_tips_inside():
    cracks = [crack((6, 5), (8, 5)), crack((0, 5), (3, 5))]
    t = triangulate(body(holes=[hole(5, 5, 1)], cracks=cracks))
    boundary = boundary_nodes(t)
    for name in t.cracks:
        mouth, tip = crack_ends(t, name)
        assert mouth in boundary
        assert tip not in boundary
    assert crack_ends(t, "crack_1")[0] in t.edges["hole_1"]
    assert crack_ends(t, "crack_2")[0] in t.edges["edge_4"]


def test_nodes_of_straight_edges_and_cracks_lie_exactly_on_them():
    t = triangulate(plate())
    for name, axis, value in [
        ("bottom", 1, 0),
        ("right", 0, 500),
        ("top", 1, 1000),
        ("left", 0, 0),
    ]:
        assert (t.nodes[t.edges[name], axis] == value).all()
    assert (t.nodes[t.cracks["crack_1"], 1] == 500).all()


def test_areas_and_lengths_of_arcs_converge_with_second_order():
    errors = []
    for size in (0.1, 0.05, 0.025):
        t = triangulate(body(**BODIES["disc"], mesh={"size": size, "grading": "uniform"}))
        errors.append(
            [np.pi - areas(t).sum(), 2 * np.pi - sum(lengths(t, e).sum() for e in t.edges.values())]
        )
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(rates, 2, atol=0.2)


def test_a_hole_keeps_its_shape_however_coarse_the_grid():
    t = triangulate(body(holes=[hole(5, 5, 0.1)], mesh={"size": 3}))
    assert 24 <= len(t.edges["hole_1"]) <= 34
    np.testing.assert_allclose(np.hypot(*(t.nodes[t.edges["hole_1"]] - 5).T), 0.1, rtol=1e-9)


def region(name, **shape):
    return {"name": name, "material": STEEL, **shape}


def test_regions_are_cut_out_conformingly():
    upper = region("upper", polygon=[(0, 5), (10, 5), (10, 10), (0, 10)])
    disc = region("disc", circle={"centre": (5, 2.5), "radius": 1})
    t = triangulate(body(regions=[upper, disc], cracks=[crack((0, 5), (4, 5))]))
    assert_sound(t)
    assert t.region_names == ("body", "upper", "disc")
    by_region = np.bincount(t.regions, areas(t))
    assert by_region[1] == pytest.approx(50, rel=1e-12)
    assert by_region[2] == pytest.approx(np.pi, rel=0.02)
    # The crack runs along the border: one triangle of each side at each of its edges.
    for pair in t.cracks["crack_1"]:
        beside = np.isin(t.triangles, pair).sum(axis=1) == 2
        assert sorted(t.regions[beside]) == [0, 1]


def test_a_crack_may_cross_a_region_and_a_region_may_leave_the_body():
    inclusion = region("inclusion", circle={"centre": (5, 5), "radius": 2})
    beyond = region("beyond", polygon=[(8, -5), (15, -5), (15, 15), (8, 15)])
    t = triangulate(body(regions=[inclusion, beyond], cracks=[crack((0, 5), (6, 5))]))
    assert_sound(t)
    by_region = np.bincount(t.regions, areas(t))
    assert by_region[1] == pytest.approx(4 * np.pi, rel=0.01)
    assert by_region[2] == pytest.approx(20, rel=1e-12)
    assert by_region.sum() == pytest.approx(100, rel=1e-12)


def test_a_ring_around_a_hole_is_a_region():
    ring = region("ring", circle={"centre": (5, 5), "radius": 2})
    t = triangulate(body(holes=[hole(5, 5, 1)], regions=[ring]))
    assert_sound(t)
    assert np.bincount(t.regions, areas(t))[1] == pytest.approx(3 * np.pi, rel=0.02)


def test_load_points_become_nodes():
    at = {"inside": (2.3, 7.1), "edge": (10, 3.3), "corner": (0, 10), "again": (2.3, 7.1)}
    loads = [{"name": name, "point": point, "force": (1, 0)} for name, point in at.items()]
    scene = body(loads=loads, cracks=[crack((0, 5), (4, 5))])
    t = triangulate(scene)
    assert_sound(t)
    for load in snap(scene).loads:
        assert tuple(t.nodes[t.points[load.name]]) == load.point
    assert t.points["inside"] == t.points["again"]
    assert t.points["edge"] in t.edges["edge_2"]


def test_uniform_sizes():
    t = triangulate(plate(size=25, grading="uniform"))
    side = np.sqrt(areas(t) * 4 / np.sqrt(3))
    assert np.median(side) == pytest.approx(25, rel=0.05)
    assert side.min() > 15
    assert side.max() < 35
    assert resolved_grading(plate(size=25, grading="uniform")) is None


@pytest.mark.parametrize("tip_size", [1.0, 1e-2, 2e-5])
def test_grading_is_obeyed_at_every_distance(tip_size):
    t = triangulate(plate(size=20, grading={"tip_size": tip_size, "growth": 0.3}))
    assert_sound(t)
    side = np.sqrt(areas(t) * 4 / np.sqrt(3))
    r = np.hypot(*(t.nodes[t.triangles].mean(axis=1) - [100, 500]).T)
    wanted = np.minimum(20, tip_size + 0.3 * r)
    bands = np.geomspace(tip_size, 500, 12)
    for low, high in zip([0, *bands[:-1]], bands, strict=True):
        here = (low <= r) & (r < high)
        assert here.sum() >= 4
        assert np.median(side[here] / wanted[here]) == pytest.approx(1, abs=0.35)
    # The crack line follows the grading too.
    assert lengths(t, t.cracks["crack_1"])[-1] == pytest.approx(1.15 * tip_size, rel=0.35)


@pytest.mark.parametrize("grading", ["uniform", {"tip_size": 0.1, "growth": 0.15}])
def test_small_elements_at_holes(grading):
    """A ligament of three hole sizes gets three elements, and the grid coarsens away from it."""
    window = {"polygon": [(1, 1), (2, 1), (2, 2), (1, 2)]}
    scene = body(
        holes=[hole(6, 5, 1), window],
        cracks=[crack((0, 8), (1, 8))],
        mesh={"size": 1.0, "grading": grading, "hole_size": 0.1},
    )
    t = triangulate(scene)
    assert_sound(t, scene)
    for name in ("hole_1", "hole_2"):
        here = lengths(t, t.edges[name])
        assert 0.08 < here.mean() < 0.11
        assert here.max() < 0.13
    growth = 0.3 if grading == "uniform" else 0.15
    centre = t.nodes[t.triangles].mean(axis=1)
    away = np.hypot(*(centre - (6, 5)).T) - 1.0
    size = np.sqrt(areas(t) / 0.433)
    near = (away < 0.8) & (centre[:, 0] > 5)
    assert (size[near] < 1.5 * (0.1 + growth * away[near])).all()
    assert np.median(size[near] / (0.1 + growth * away[near])) == pytest.approx(1.0, abs=0.15)


def test_default_sizes():
    scene = plate()
    assert mesh_size(scene) == pytest.approx(np.sqrt(500e3) / 20)
    assert resolved_grading(scene).tip_size == pytest.approx(mesh_size(scene) / 300)
    short = body(cracks=[crack((0, 5), (0.1, 5))])
    assert resolved_grading(short).tip_size == pytest.approx(0.1 / 150)
    assert resolved_grading(body()) is None
    assert 800 < len(triangulate(scene).triangles) < 3000


def test_the_body_is_made_the_same_few_times_for_any_number_of_tips(monkeypatch):
    made = []
    make = BodyShape.of.__func__
    monkeypatch.setattr(
        BodyShape, "of", classmethod(lambda cls, scene: made.append(1) or make(cls, scene))
    )
    for n in (1, 4):
        made.clear()
        triangulate(body(cracks=[crack((0, 2 * i), (4, 2 * i + 0.5)) for i in range(1, n + 1)]))
        assert len(made) == 2


@pytest.mark.slow
def test_the_same_scene_gives_the_same_arrays():
    code = (
        "import sys, hashlib; sys.path.insert(0, sys.argv[1]);"
        "from meshing_scenes import plate; from cfmpm.meshing import triangulate;"
        "t = triangulate(plate());"
        "print(hashlib.sha256(t.nodes.tobytes() + t.triangles.tobytes()).hexdigest())"
    )
    folder = str(__file__).rsplit("test_", 1)[0]
    run = subprocess.run(
        [sys.executable, "-c", code, folder], capture_output=True, text=True, check=True
    )
    triangulate(body(**BODIES["holes"]))  # what came before must not matter
    first, second = triangulate(plate()), triangulate(plate())
    np.testing.assert_array_equal(first.nodes, second.nodes)
    np.testing.assert_array_equal(first.triangles, second.triangles)
    digest = hashlib.sha256(first.nodes.tobytes() + first.triangles.tobytes()).hexdigest()
    assert run.stdout.strip() == digest


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1, 1e3, 1e6])
@pytest.mark.parametrize("shift", [0, 500])
def test_scale_and_place_do_not_matter(scale, shift):
    def placed(*points):
        return [(x * scale + shift * scale, y * scale - shift * scale) for x, y in points]

    scene = body(placed(*SQUARE), cracks=[crack(*placed((0, 5), (4, 6)))])
    t = triangulate(scene)
    assert_sound(t)
    assert len(t.triangles) == pytest.approx(1475, rel=0.1)
    assert areas(t).sum() == pytest.approx(100 * scale**2, rel=1e-9)
    assert tuple(t.nodes[crack_ends(t)[1]]) == placed((4, 6))[0]


def test_a_body_far_from_the_origin():
    t = triangulate(
        body(
            [(x + 1e6, y - 1e6) for x, y in SQUARE],
            cracks=[crack((1e6, 5 - 1e6), (1e6 + 4, 6 - 1e6))],
        )
    )
    assert_sound(t)
    assert areas(t).sum() == pytest.approx(100, rel=1e-8)


@settings(max_examples=25)
@given(
    radii=st.lists(st.floats(0.4, 1), min_size=3, max_size=9),
    mouth=st.integers(0, 8),
    along=st.floats(0, 1),
    depth=st.floats(0.1, 0.9),
    clockwise=st.booleans(),
)
def test_random_polygons_with_a_crack(radii, mouth, along, depth, clockwise):
    n = len(radii)
    z = np.array(radii) * np.exp(2j * np.pi * np.arange(n) / n)
    start = z[mouth % n]
    if 0.01 < along < 0.99:
        start = start + along * (z[(mouth + 1) % n] - start)
    line = [(start.real, start.imag), (start.real * (1 - depth), start.imag * (1 - depth))]
    corners = [(p.real, p.imag) for p in z]
    scene = body(corners[::-1] if clockwise else corners, cracks=[crack(*line)])
    t = triangulate(scene)
    assert_sound(t)
    assert areas(t).sum() == pytest.approx(body_polygon(scene).area, rel=1e-9)
    first, last = crack_ends(t)
    assert first in boundary_nodes(t)
    assert last not in boundary_nodes(t)
    assert tuple(t.nodes[last]) == line[1]
    assert lengths(t, t.cracks["crack_1"]).sum() == pytest.approx(abs(start) * depth, rel=1e-6)
    assert as_set(t.cracks["crack_1"]).isdisjoint(as_set(np.concatenate([*t.edges.values()])))


@pytest.mark.parametrize("mesh", [{}, {"size": 20}, {"size": 20, "grading": "uniform"}])
def test_triangles_are_counted_before_they_are_made(mesh):
    scene = plate(**mesh)
    made = len(triangulate(scene).triangles)
    assert made == pytest.approx(expected_triangles(scene), rel=0.15)


def test_triangles_at_holes_are_counted_too():
    holes = [{"circle": {"centre": [7, 5], "radius": 1}}]
    scene = body(holes=holes, mesh={"size": 0.5, "hole_size": 0.02, "grading": "uniform"})
    made = len(triangulate(scene).triangles)
    assert made == pytest.approx(expected_triangles(scene), rel=0.3)
