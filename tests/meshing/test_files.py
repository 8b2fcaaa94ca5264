from __future__ import annotations

import json

import gmsh
import numpy as np
import pytest
from meshing_scenes import STEEL, areas, as_set, assert_sound, lengths

from cfmpm.errors import SceneError
from cfmpm.meshing import mesh_size, resolved_grading, triangulate
from cfmpm.output.checkpoint import read_checkpoint
from cfmpm.output.run_folder import CHECKPOINT
from cfmpm.output.run_writer import RunWriter
from cfmpm.scene import changed_keys, scene_from_dict
from cfmpm.scene.model import Scene
from cfmpm.simulation import run


def write(
    path, *, order=1, version=4.1, binary=0, clockwise=False, tilt=0.0, quads=False, extrude=False
):
    """A square of side 10, a crack of 4 from the left at half height, the upper half a surface.

    The crack runs from right to left in the file; the border of the halves ahead of it is `seam`,
    and `inner` the part of it without contact with boundary and crack.
    """
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1)
    cad = gmsh.model.geo
    corners = [(0, 0), (10, 0), (10, 5), (10, 10), (0, 10), (0, 5), (4, 5), (6, 5), (8, 5)]
    a, b, c, d, e, mouth, tip, left, right = (cad.addPoint(x, y, 3 + tilt * x) for x, y in corners)
    bottom, low_right, high_right = cad.addLine(a, b), cad.addLine(b, c), cad.addLine(c, d)
    top, high_left, low_left = cad.addLine(d, e), cad.addLine(e, mouth), cad.addLine(mouth, a)
    crack, inner = cad.addLine(tip, mouth), cad.addLine(right, left)
    seam = [cad.addLine(c, right), inner, cad.addLine(left, tip)]
    back = [-line for line in reversed(seam)]
    low = cad.addPlaneSurface([cad.addCurveLoop([bottom, low_right, *seam, crack, low_left])])
    high = cad.addPlaneSurface([cad.addCurveLoop([high_right, top, high_left, -crack, *back])])
    if extrude:
        cad.extrude([(2, low)], 0, 0, 1)
    cad.synchronize()
    if clockwise:
        gmsh.model.mesh.setReverse(2, low)
    if quads:
        gmsh.model.mesh.setRecombine(2, low)
    groups = {
        "bottom": [bottom],
        "right": [low_right, high_right],
        "top": [top],
        "left": [low_left, high_left],
        "slit": [crack],
        "seam": seam,
        "inner": [inner],
        "forked": [crack, *seam, top],
        "whole_border": [crack, *seam],
    }
    for name, curves in groups.items():
        gmsh.model.addPhysicalGroup(1, curves, name=name)
    gmsh.model.addPhysicalGroup(1, [bottom], tag=77)
    gmsh.model.addPhysicalGroup(2, [low], name="lower")
    gmsh.model.addPhysicalGroup(2, [high], name="upper")
    if extrude:
        gmsh.model.addPhysicalGroup(3, [1], name="block")
    gmsh.model.mesh.generate(3 if extrude else 2)
    gmsh.model.mesh.setOrder(order)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.write(str(path))
    gmsh.finalize()


def scene_of(path, *, cracks=(), regions=(), loads=({"edge": "top", "traction": (0, 1)},)):
    return Scene(
        name="test",
        mesh_file={
            "file": str(path),
            "cracks": list(cracks),
            "regions": [{"name": name, "material": STEEL} for name in regions],
        },
        material=STEEL,
        loads=list(loads),
    )


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("clockwise", [False, True])
def test_names_of_a_mesh_file(tmp_path, order, clockwise):
    write(tmp_path / "a.msh", order=order, clockwise=clockwise)
    loads = [
        {"edge": "top", "traction": (0, 1)},
        {"name": "pin", "point": (10, 5), "displacement": {"x": 0}},
    ]
    t = triangulate(scene_of(tmp_path / "a.msh", cracks=["slit"], regions=["upper"], loads=loads))
    assert t.edges.keys() == {"bottom", "right", "top", "left", "curve_77"}
    np.testing.assert_array_equal(t.edges.pop("curve_77"), t.edges["bottom"])
    assert_sound(t)
    assert areas(t).sum() == pytest.approx(100, rel=1e-12)
    assert t.region_names == ("body", "upper")
    np.testing.assert_allclose(np.bincount(t.regions, areas(t)), 50, rtol=1e-12)
    line = t.cracks["slit"]
    np.testing.assert_allclose(t.nodes[[line[0, 0], line[-1, 1]]], [(0, 5), (4, 5)], atol=1e-12)
    assert lengths(t, line).sum() == pytest.approx(4, rel=1e-12)
    np.testing.assert_allclose(t.nodes[t.points["pin"]], (10, 5), atol=1e-12)


def test_an_older_format(tmp_path):
    write(tmp_path / "new.msh")
    write(tmp_path / "old.msh", version=2.2, binary=1)
    new, old = (
        triangulate(scene_of(tmp_path / name, cracks=["slit"], regions=["upper"]))
        for name in ("new.msh", "old.msh")
    )
    for name in ("bottom", "right", "top", "left"):
        assert lengths(old, old.edges[name]).sum() == pytest.approx(10, rel=1e-9)
    assert len(old.nodes) == len(new.nodes)
    np.testing.assert_allclose(np.bincount(old.regions, areas(old)), 50, rtol=1e-9)


def test_a_crack_without_a_mouth_begins_at_its_left_end(tmp_path):
    write(tmp_path / "a.msh")
    t = triangulate(scene_of(tmp_path / "a.msh", cracks=["inner"]))
    line = t.nodes[t.cracks["inner"][:, 0]]
    assert (np.diff(line[:, 0]) > 0).all()


def test_a_mesh_file_has_its_own_sizes(tmp_path):
    scene = scene_of(tmp_path / "a.msh")
    assert mesh_size(scene) is None
    assert resolved_grading(scene) is None


def refusals(scene):
    with pytest.raises(SceneError) as caught:
        triangulate(scene)
    return {problem.key: problem.reason for problem in caught.value.problems}


def test_all_unknown_names_are_told_at_once(tmp_path):
    write(tmp_path / "a.msh")
    loads = [
        {"edge": "tpo", "traction": (0, 1)},
        {"edge": "seam", "traction": (0, 1)},
        {"point": (5.5, 5.2), "force": (0, 1)},
    ]
    reasons = refusals(
        scene_of(
            tmp_path / "a.msh",
            cracks=["slitt", "top", "forked"],
            regions=["uper"],
            loads=loads,
        )
    )
    assert "did you mean slit?" in reasons["mesh_file.cracks[0]"]
    assert "known: bottom, curve_77" in reasons["mesh_file.cracks[0]"]
    assert "inside" in reasons["mesh_file.cracks[1]"]
    assert "inside" in reasons["mesh_file.cracks[2]"]
    assert "did you mean upper?" in reasons["mesh_file.regions[0].name"]
    assert "did you mean top?" in reasons["loads[0].edge"]
    assert "not part of the boundary" in reasons["loads[1].edge"]
    assert "the nearest is at [" in reasons["loads[2].point"]


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"quads": True}, "has quadrilaterals"),
        ({"extrude": True}, "has tetrahedra"),
        ({"tilt": 0.1}, "is not plane"),
    ],
)
def test_meshes_of_other_kinds_are_refused(tmp_path, options, reason):
    write(tmp_path / "a.msh", **options)
    assert reason in refusals(scene_of(tmp_path / "a.msh"))["mesh_file.file"]


def test_files_that_are_no_meshes_are_refused(tmp_path):
    path = tmp_path / "a.msh"
    assert "cannot be read" in refusals(scene_of(path))["mesh_file.file"]
    path.write_text("Point(1) = {0, 0, 0};\n")
    assert "is not a gmsh mesh" in refusals(scene_of(path))["mesh_file.file"]
    path.write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\nnonsense\n")
    assert "ends within $Nodes" in refusals(scene_of(path))["mesh_file.file"]
    path.write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n")
    assert "has no triangles" in refusals(scene_of(path))["mesh_file.file"]


def write_by_hand(path, nodes, triangles, lines=()):
    """Format 2.2; lines are (physical tag, node, node)."""
    elements = [f"1 2 {g} {g} {a} {b}" for g, a, b in lines]
    elements += [f"2 2 1 1 {a} {b} {c}" for a, b, c in triangles]
    path.write_text(
        "\n".join(
            [
                "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes",
                str(len(nodes)),
                *(f"{i} {x} {y} 0" for i, (x, y) in enumerate(nodes, 1)),
                "$EndNodes\n$Elements",
                str(len(elements)),
                *(f"{i} {e}" for i, e in enumerate(elements, 1)),
                "$EndElements\n",
            ]
        )
    )


def test_orphan_nodes_are_dropped(tmp_path):
    path = tmp_path / "a.msh"
    write_by_hand(path, [(9, 9), (0, 0), (1, 0), (0, 1)], [(2, 3, 4)], [(5, 2, 3)])
    scene = scene_of(path, loads=[{"edge": "curve_5", "traction": (0, 1)}])
    t = triangulate(scene)
    np.testing.assert_array_equal(t.nodes, [(0, 0), (1, 0), (0, 1)])
    assert as_set(t.edges["curve_5"]) == {(0, 1)}
    assert as_set(t.edges["boundary"]) == {(0, 2), (1, 2)}


@pytest.mark.parametrize(
    ("nodes", "triangles", "reason"),
    [
        ([(0, 0), (1, 0), (0, 1), (1, 0), (0, 1), (1, 1)], [(1, 2, 3), (4, 6, 5)], "2 parts"),
        ([(0, 0), (1, 0), (2, 0), (0, 1)], [(1, 2, 3), (1, 2, 4)], "1 triangles have no area"),
        ([(0, 0), (1, 0), (0, 1), (1, 1), (2, 2)], [(1, 2, 3), (2, 4, 3), (2, 5, 3)], "1 edges"),
    ],
)
def test_broken_meshes_are_refused(tmp_path, nodes, triangles, reason):
    path = tmp_path / "a.msh"
    write_by_hand(path, nodes, triangles)
    assert reason in refusals(scene_of(path))["mesh_file.file"]


@pytest.mark.parametrize(
    "lines",
    [
        [(5, 5, 6), (5, 6, 7), (5, 7, 5)],  # closed
        [(5, 5, 6), (5, 5, 7), (5, 5, 1)],  # forked
    ],
    ids=["closed", "forked"],
)
def test_a_crack_must_be_one_line(tmp_path, lines):
    path = tmp_path / "a.msh"
    nodes = [(0, 0), (4, 0), (4, 4), (0, 4), (1, 1), (3, 1), (1, 3)]
    triangles = [
        (5, 6, 7),
        (1, 2, 6),
        (1, 6, 5),
        (2, 3, 6),
        (3, 7, 6),
        (3, 4, 7),
        (4, 1, 7),
        (1, 5, 7),
    ]
    write_by_hand(path, nodes, triangles, lines)
    loads = [{"body_force": (0, 1)}]
    reasons = refusals(scene_of(path, cracks=["curve_5"], loads=loads))
    assert "not a single line" in reasons["mesh_file.cracks[0]"]


def test_a_run_goes_on_without_its_file_and_not_with_another_one(tmp_path, monkeypatch):
    """The grid is in the checkpoint; the scene identifies its file by the contents."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "a.msh")
    data = {
        "name": "halves",
        "mesh_file": {"file": "a.msh", "cracks": ["slit"]},
        "material": {**STEEL, "g_c": 1.0},
        "loads": [
            {"edge": "bottom", "displacement": {"x": 0, "y": 0}},
            {"edge": "top", "traction": [0, 10]},
        ],
        "growth": {"control": "crack", "increments": 4},
    }
    scene = scene_from_dict(data)
    writer = RunWriter(tmp_path)

    class StopHereError(Exception):
        pass

    def observe(state, record):
        writer.observe(state, record)
        if len(record.steps) == 3:
            raise StopHereError

    with pytest.raises(StopHereError):
        run(scene, observe=observe)
    writer.write("stopped")
    whole = run(scene)
    (tmp_path / "a.msh").unlink()
    start = read_checkpoint(tmp_path / CHECKPOINT)
    history = run(start.record.scene, start=start).history
    assert history.attrs["config_hash"] == whole.history.attrs["config_hash"]
    for name in ("tip_x", "K_I", "load_factor"):
        np.testing.assert_array_equal(history[name], whole.history[name])
    config = json.loads(history.attrs["config"])
    with pytest.raises(SceneError, match="no such file"):
        scene_from_dict(config)
    write(tmp_path / "a.msh", clockwise=True)
    with pytest.raises(SceneError, match="has changed since sha256 was taken"):
        scene_from_dict(config)
    assert changed_keys(scene, scene_from_dict(data)) == ["mesh_file"]
