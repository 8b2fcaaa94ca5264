"""Refused sizes, counts, radii and mesh files."""

from __future__ import annotations

from pathlib import Path

import pytest
from scene_texts import LINE, assert_refused_once, plate, refused

from cfmpm.scene import config_hash, effective_config, expand, load_scene, scene_from_dict

CRACK = "[{points: [[0, 30], [50, 30]]}]"
SIZES = [
    (
        "mesh",
        "{size: 61}",
        "mesh.size",
        "61 mm is larger than the body, whose smaller extent is 60 mm",
    ),
    ("mesh", "{size: 1.0e+5}", "mesh.size", "larger than the body"),
    ("mesh", "{grading: {tip_size: 70}}", "mesh.grading.tip_size", "larger than the body"),
    ("mesh", "{grading: {tip_size: 1.0e+5}}", "mesh.grading.tip_size", "larger than the body"),
    ("mesh", "{size: 5, grading: {tip_size: 6}}", "mesh.grading.tip_size", "at most mesh.size, 5"),
    ("mesh", "{size: 5, grading: {tip_size: 5.1}}", "mesh.grading.tip_size", "at most mesh.size"),
    ("mesh", "{size: 5, hole_size: 6}", "mesh.hole_size", "at most mesh.size, 5"),
    ("mesh", "{hole_size: 61}", "mesh.hole_size", "larger than the body"),
    ("mesh", "{size: 0.01}", "mesh.size", "about 1e+08 triangles; the limit is 2e+07"),
    ("mesh", "{size: 1.0e-300}", "mesh.size", "about inf triangles"),
    (
        "mesh",
        "{grading: {tip_size: 0.001, growth: 1.0e-4}}",
        "mesh.grading",
        "triangles; the limit",
    ),
    (
        "mesh",
        "{grading: {tip_size: 1.0e-9, growth: 1.0e-9}}",
        "mesh.grading",
        "triangles; the limit",
    ),
    (
        "fracture",
        "{radii: [5, 101]}",
        "fracture.radii[1]",
        "101 mm is larger than the body, 100 mm",
    ),
    ("fracture", "{radii: [1.0e+6]}", "fracture.radii[0]", "larger than the body"),
    ("fracture", "{radii: [5, 5]}", "fracture.radii", "must differ from each other"),
    ("fracture", "{radii: [1, 2, 1.0]}", "fracture.radii", "must differ from each other"),
]


@pytest.mark.parametrize(("part", "text", "key", "fragment"), SIZES)
def test_sizes_refused(part: str, text: str, key: str, fragment: str, tmp_path: Path) -> None:
    scene = plate(cracks=CRACK, **{part: text})
    assert_refused_once(scene, tmp_path, key, LINE[part], fragment)


def test_too_many_triangles_at_holes(tmp_path: Path) -> None:
    text = plate(holes="[{circle: {centre: [80, 30], radius: 5}}]", mesh="{hole_size: 1.0e-9}")
    assert_refused_once(text, tmp_path, "mesh.hole_size", LINE["mesh"], "the limit is 2e+07")


@pytest.mark.parametrize(
    "mesh", ["{}", "{size: 60}", "{size: 5, grading: {tip_size: 1.0e-9}}", "{grading: uniform}"]
)
def test_sizes_accepted(mesh: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(plate(cracks=CRACK, mesh=mesh))
    assert load_scene(path).mesh.element == "T6"


def test_growth_needs_the_toughness_of_every_material(tmp_path: Path) -> None:
    patch = "[{name: patch, circle: {centre: [80, 30], radius: 5}, material: {E: 1, nu: 0.3}}]"
    text = plate(cracks=CRACK, regions=patch)
    assert [problem.key for problem in refused(text + "growth: {}\n", tmp_path)] == [
        "material.g_c",
        "geometry.regions[0].material.g_c",
    ]


@pytest.mark.parametrize(
    ("growth", "fragment"),
    [("", "needs growth"), ("growth: {transfer: paper}\n", "needs growth.transfer: domains")],
)
def test_refinement_needs_growth_by_domains(growth: str, fragment: str, tmp_path: Path) -> None:
    text = plate(cracks=CRACK, fracture="{refine: 1}") + growth
    text = text.replace("nu: 0.3}", "nu: 0.3, g_c: 1}")
    assert_refused_once(text, tmp_path, "fracture.refine", LINE["fracture"], fragment)


def mesh_scene(mesh_file: str, loads: str = "[{edge: top, traction: [0, 1]}]") -> str:
    return f"name: m\nmaterial: {{E: 1, nu: 0}}\nmesh_file: {{{mesh_file}}}\nloads: {loads}\n"


MESH_FILES = [
    ("file: none.msh", "mesh_file.file", "no such file: "),
    ("file: folder.msh", "mesh_file.file", "no such file: "),
    ("file: plate.vtu", "mesh_file.file", "must end in .msh"),
    ("file: .", "mesh_file.file", "must end in .msh"),
    ("file: ''", "mesh_file.file", "must not be empty"),
    ("file: 3", "mesh_file.file", "must be text"),
    ("cracks: [a]", "mesh_file.file", "is missing"),
    ("file: a.msh, cracks: [a, b, a]", "mesh_file.cracks[2]", "a is a name already in use"),
    ("file: a.msh, cracks: [a, a]", "mesh_file.cracks[1]", "a is a name already in use"),
    (
        "file: a.msh, regions: [{name: b, material: {E: 1, nu: 0}}, "
        "{name: b, material: {E: 2, nu: 0}}]",
        "mesh_file.regions[1].name",
        "b is a name already in use",
    ),
    (
        "file: a.msh, regions: [{name: body, material: {E: 1, nu: 0}}]",
        "mesh_file.regions[0].name",
        "body is a name already in use",
    ),
    (
        "file: a.msh, regions: [{name: b, material: {E: 1, nu: 0}, "
        "circle: {centre: [0, 0], radius: 1}}]",
        "mesh_file.regions[0]",
        "takes its shape from the mesh file",
    ),
    (
        "file: a.msh, regions: [{name: b, material: {E: 1, nu: 0}, "
        "polygon: [[0, 0], [1, 0], [1, 1]]}]",
        "mesh_file.regions[0]",
        "takes its shape from the mesh file",
    ),
]


@pytest.mark.parametrize(
    ("keys", "key"),
    [
        ("size: 2", "mesh.size"),
        ("grading: uniform", "mesh.grading"),
        ("grading: {tip_size: 0.1}", "mesh.grading"),
        ("hole_size: 0.5", "mesh.hole_size"),
        ("element: T3, size: 2", "mesh.size"),
    ],
)
def test_sizes_beside_a_mesh_file_refused(keys: str, key: str, tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text("mesh")
    text = mesh_scene("file: a.msh") + f"mesh: {{{keys}}}\n"
    assert_refused_once(text, tmp_path, key, 5, "has no effect with mesh_file")


def test_the_element_of_a_mesh_file_is_a_choice(tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text("mesh")
    (tmp_path / "scene.yaml").write_text(mesh_scene("file: a.msh") + "mesh: {element: T3}\n")
    assert load_scene(tmp_path / "scene.yaml").mesh.element == "T3"


@pytest.mark.parametrize("name", ["top edge", "1st", "a.b", "Größe", "x/y $z$", "-", "a: b"])
def test_names_of_groups_are_free(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text("mesh")
    region = f"{{name: '{name}', material: {{E: 1, nu: 0}}}}"
    mesh = f"file: a.msh, cracks: ['{name}'], regions: [{region}]"
    loads = f"[{{edge: '{name}', traction: [0, 1]}}]"
    (tmp_path / "scene.yaml").write_text(mesh_scene(mesh, loads))
    scene = load_scene(tmp_path / "scene.yaml")
    assert scene.mesh_file is not None
    assert scene.mesh_file.cracks == [name]
    assert expand(scene).loads[0].name == name
    assert scene_from_dict(effective_config(scene)) == scene


def test_accents_of_names_count_alike_however_they_are_made_up(tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text("mesh")
    (tmp_path / "scene.yaml").write_text(mesh_scene('file: a.msh, cracks: ["e\\u0301"]'))
    scene = load_scene(tmp_path / "scene.yaml")
    assert scene.mesh_file is not None
    assert scene.mesh_file.cracks == ["é"]


@pytest.mark.parametrize("name", ["a\\nb", "\\0", "\\u202e", "\\e[1m"])
def test_names_with_control_characters_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.msh").write_text("mesh")
    text = mesh_scene(f'file: a.msh, cracks: ["{name}"]')
    assert_refused_once(text, tmp_path, "mesh_file.cracks[0]", 3, "without control characters")


@pytest.mark.parametrize(("mesh_file", "key", "fragment"), MESH_FILES)
def test_mesh_file_refused(mesh_file: str, key: str, fragment: str, tmp_path: Path) -> None:
    (tmp_path / "a.msh").touch()
    (tmp_path / "folder.msh").mkdir()
    assert_refused_once(mesh_scene(mesh_file), tmp_path, key, 3, fragment)


def test_loads_of_a_mesh_file_contradict(tmp_path: Path) -> None:
    (tmp_path / "a.msh").touch()
    loads = "[{edge: a, displacement: {x: 0}}, {edge: a, displacement: {x: 1}}]"
    problems = refused(mesh_scene("file: a.msh", loads), tmp_path)
    assert [p.key for p in problems] == ["loads[1].displacement.x"]


def test_mesh_file_is_relative_to_the_scene(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "grids").mkdir()
    (tmp_path / "grids" / "a.msh").touch()
    (tmp_path / "scene.yaml").write_text(mesh_scene("file: grids/a.msh"))
    scene = load_scene(tmp_path / "scene.yaml")
    assert scene.mesh_file is not None
    assert scene.mesh_file.file == "grids/a.msh"
    assert scene.mesh_file.path == str(tmp_path / "grids" / "a.msh")
    monkeypatch.chdir(tmp_path)
    data = {"name": "m", "material": {"E": 1, "nu": 0}, "mesh_file": {"file": "grids/a.msh"}}
    assert scene_from_dict(data | {"loads": scene.loads}).mesh_file == scene.mesh_file


def test_a_stored_scene_finds_its_mesh_file_from_anywhere(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "a.msh").touch()
    (tmp_path / "scene.yaml").write_text(mesh_scene("file: a.msh"))
    monkeypatch.chdir(tmp_path)
    scene = load_scene("scene.yaml")
    monkeypatch.chdir("/")
    assert scene_from_dict(effective_config(scene)) == scene


def test_a_mesh_file_counts_by_its_content(tmp_path: Path) -> None:
    hashes = []
    for folder, name, content in [("a", "x", "1"), ("b", "y", "1"), ("b", "x", "2")]:
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / f"{name}.msh").write_text(content)
        scene = tmp_path / folder / "scene.yaml"
        scene.write_text(mesh_scene(f"file: {name}.msh"))
        hashes.append(config_hash(load_scene(scene)))
    assert hashes[0] == hashes[1] != hashes[2]


def test_all_problems_at_once(tmp_path: Path) -> None:
    text = plate(
        holes="[{circle: {centre: [100, 30], radius: 5}}, {circle: {centre: [50, 90], radius: 5}}]",
        cracks="[{points: [[0, 10], [100, 10]]}]",
        loads="[{edge: tpo, traction: [0, 1]}, {point: [200, 0], force: [0, 1]}]",
        mesh="{size: 80}",
    )
    assert [p.key for p in refused(text, tmp_path)] == [
        "geometry.holes[0]",
        "geometry.holes[1]",
        "geometry.cracks[0]",
        "loads[0].edge",
        "loads[1].point",
        "mesh.size",
    ]


@pytest.mark.parametrize(
    "cracks", ["[]", "[{points: [[0, 30], [45, 30]]}]"], ids=["none", "from edge to hole"]
)
def test_growth_needs_a_tip(cracks: str, tmp_path: Path) -> None:
    holes = "[{circle: {centre: [50, 30], radius: 5}}]"
    text = plate(cracks=cracks, holes=holes).replace("nu: 0.3", "nu: 0.3, g_c: 1")
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    assert load_scene(path).growth is None
    (problem,) = refused(text + "growth: {control: crack}\n", tmp_path)
    assert problem.key == "growth"
    assert "needs a crack that ends inside the body" in problem.reason
