"""Any text as a name in a mesh file: in figures, file names and flags of datasets."""

from __future__ import annotations

from pathlib import Path

import gmsh
import pytest

from cfmpm.output.fields import build_fields
from cfmpm.output.files import in_file_name
from cfmpm.plotting import files
from cfmpm.plotting.style import as_label
from cfmpm.scene import scene_from_dict
from cfmpm.simulation import run

CRACK, TOP, BOTTOM = 'é $x$/../1st "a"', "_top.edge 日本", "2 bottom; $HOME"


def write(path: Path) -> None:
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1)
    cad = gmsh.model.geo
    at = [(0, 0), (10, 0), (10, 10), (0, 10), (0, 5), (4, 5)]
    a, b, c, d, mouth, tip = (cad.addPoint(*place, 0) for place in at)
    lines = [cad.addLine(*ends) for ends in [(a, b), (b, c), (c, d), (d, mouth), (mouth, a)]]
    crack = cad.addLine(mouth, tip)
    cad.addPlaneSurface([cad.addCurveLoop(lines)])
    cad.synchronize()
    gmsh.model.mesh.embed(1, [crack], 2, 1)
    for name, curve in {BOTTOM: lines[0], TOP: lines[2], CRACK: crack}.items():
        gmsh.model.addPhysicalGroup(1, [curve], name=name)
    gmsh.model.addPhysicalGroup(2, [1], name="a plate")
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))
    gmsh.finalize()


@pytest.mark.filterwarnings("error")
def test_odd_names_from_the_file_to_the_pictures(tmp_path: Path) -> None:
    write(tmp_path / "a.msh")
    steel = {"E": 210e3, "nu": 0.3, "g_c": 1.0}
    scene = scene_from_dict(
        {
            "name": "odd",
            "mesh_file": {
                "file": str(tmp_path / "a.msh"),
                "cracks": [CRACK],
                "regions": [{"name": "a plate", "material": steel}],
            },
            "material": steel,
            "loads": [
                {"edge": BOTTOM, "displacement": {"x": 0, "y": 0}},
                {"edge": TOP, "traction": [0, 10]},
            ],
            "load_steps": 2,
            "fracture": {"radii": 2},
        }
    )
    result = run(scene)
    history, body = result.history, result.body
    assert history["tip"].values.tolist() == [CRACK]
    assert history["boundary"].values.tolist() == [BOTTOM, TOP]
    fields = build_fields(result)
    assert fields["region"].attrs["flag_meanings"] == "body a_plate"
    assert " " not in fields["crack"].attrs["flag_meanings"]
    written = [
        files.save_scene(tmp_path, scene, body),
        *files.save_tip_points(tmp_path, body),
        *files.save_radii(tmp_path, history),
        *files.save_tip_forces(tmp_path, fields, history),
        *files.save_steps(tmp_path, history),
    ]
    assert {path.parent for path in written} == {tmp_path}
    assert len({path.name for path in written}) == len(written) >= 6
    assert all(path.is_file() for path in written)


def test_names_that_differ_have_files_that_differ() -> None:
    names = ["a", "a b", "a/b", "a%2Fb", "a\\b", "é", "..", "a:b", "a_b"]
    assert len({in_file_name(name) for name in names}) == len(names)
    assert in_file_name("../a") == "..%2Fa"
    assert as_label("_a$b") == r" _a\$b"
