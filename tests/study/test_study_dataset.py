"""The dataset of a study: dimensions, variables, missing values."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from study_texts import FAILING, GROWING, STUDY, UNCRACKED, write_study

import cfmpm.accessor  # noqa: F401  (``ds.cfmpm``)
from cfmpm import simulation
from cfmpm.errors import SceneError
from cfmpm.meshing.session import gmsh_session
from cfmpm.output.files import write_dataset
from cfmpm.study.collecting import collect
from cfmpm.study.layout import LAST, RESERVED, described
from cfmpm.study.member import Outcome, solve
from cfmpm.study.reading import Plan, load_study


def solved(folder: Path, text: str) -> tuple[Plan, dict[str, Outcome], xr.Dataset]:
    """A study solved in this process, and its dataset opened by xarray."""
    plan = load_study(write_study(folder, text))
    outcomes = {one.key: solve(one.job()) for one in plan.members}
    write_dataset(collect(plan, outcomes), folder / "study.nc")
    return plan, outcomes, xr.load_dataset(folder / "study.nc")


@pytest.fixture(scope="module")
def stationary(tmp_path_factory):
    return solved(tmp_path_factory.mktemp("stationary"), STUDY)


@pytest.fixture(scope="module")
def growing(tmp_path_factory):
    return solved(tmp_path_factory.mktemp("growing"), GROWING)


def test_a_dimension_for_each_parameter(stationary) -> None:
    _, _, dataset = stationary
    assert dict(dataset["G"].sizes) == {"length": 2, "E": 2, "tip": 1}
    assert dataset["length"].values.tolist() == [2, 4]
    assert dataset["E"].values.tolist() == [1e5, 2e5]
    assert dataset["length"].attrs == {"key": "family.crack_length", "units": "mm"}
    assert dataset["E"].attrs == {
        "key": "material.E",
        "units": "MPa",
        "long_name": "Young's modulus",
    }
    assert "step" not in dataset.dims
    assert (dataset["status"] == 0).all()
    assert dataset["status"].attrs["flag_meanings"] == "done failed not_run unstable"


def test_values_are_those_of_the_members(stationary) -> None:
    plan, _, dataset = stationary
    for one in plan.members:
        history = simulation.run(one.scene).history
        for name in ("G", "K_I", "cf_norm", "crack_length", "tip_status", "strain_energy"):
            at = dict(one.values)
            assert (dataset[name].sel(at).values == history[name].values[-1]).all(), name
        # Without growth: the load at fracture of the only tip.
        least = float(history["critical_load_factor"].min())
        assert float(dataset["fracture_load_factor"].sel(at)) == least


def test_all_that_a_history_holds_is_there_with_its_unit(stationary) -> None:
    plan, _, dataset = stationary
    history = simulation.run(plan.members[0].scene).history
    for name in set(history.data_vars) - {"wall_time"}:
        assert dataset[name].attrs.get("units") == history[name].attrs.get("units"), name
        assert dataset[name].attrs["long_name"] == history[name].attrs["long_name"]
    for name, variable in dataset.data_vars.items():
        assert "long_name" in variable.attrs, name
    # A parameter can have no name that the dataset needs.
    assert set(map(str, dataset.variables)) - {"length", "E"} <= RESERVED


def test_the_study_is_in_its_dataset(stationary, tmp_path: Path) -> None:
    plan, _, dataset = stationary
    for name in ("Conventions", "title", "source", "date_created", "versions", "program"):
        assert dataset.attrs[name]
    again = json.loads(dataset.attrs["study"]) | {"base": json.loads(dataset.attrs["base"])}
    path = tmp_path / "again.yaml"
    path.write_text(json.dumps(again))
    assert load_study(path).members == plan.members


def test_one_study_of_the_radius_has_no_common_radii(stationary, tmp_path: Path) -> None:
    _, _, dataset = stationary
    assert "radius" not in dataset.coords  # of each crack length its own
    text = (
        "name: radii\nbase: small.yaml\nreplace: {fracture.radii: [1]}\n"
        'product: {R: {key: "fracture.radii[0]", values: [1, 2]}}\n'
    )
    _, _, dataset = solved(tmp_path, text)
    assert "radius" not in dataset.coords
    assert dataset["domain_radius"].values.ravel().tolist() == [1, 2]
    _, _, dataset = solved(
        tmp_path,
        STUDY.replace("base: small.yaml", "base: small.yaml\nreplace: {fracture.radii: [1]}"),
    )
    assert dataset["radius"].values.tolist() == [1]


def test_values_that_are_no_numbers_become_text(tmp_path: Path) -> None:
    text = (
        "name: words\nbase: small.yaml\nproduct:\n"
        "  element: {key: mesh.element, values: [T3, T6]}\n"
        "  graded: {key: mesh.grading, values: [uniform, {tip_size: 0.5}]}\n"
        "  size: {key: mesh.size, values: {coarse: 2, fine: 1}}\n"
    )
    _, _, dataset = solved(tmp_path, text)
    assert dataset["element"].values.tolist() == ["T3", "T6"]
    assert dataset["graded"].values.tolist() == ["uniform", '{"tip_size": 0.5}']
    assert dataset["graded"].attrs["long_name"].startswith("element size near crack tips")
    nodes = dataset["n_nodes"].sel(element="T6", graded="uniform")
    assert nodes.sel(size="fine") > nodes.sel(size="coarse")


def test_samples_are_one_dimension(tmp_path: Path) -> None:
    text = (
        "name: drawn\nbase: small.yaml\n"
        "latin_hypercube:\n  samples: 4\n  seed: 2\n  parameters:\n"
        "    E: {key: material.E, distribution: norm, arguments: {loc: 2e5, scale: 1e4}}\n"
        "    toughness: {key: material.g_c, distribution: uniform, arguments: {loc: 1}}\n"
    )
    plan, _, dataset = solved(tmp_path, text)
    assert dict(dataset["G"].sizes) == {"sample": 4, "tip": 1}
    assert dataset["E"].dims == dataset["toughness"].dims == ("sample",)
    assert dataset["E"].values.tolist() == [one.values["E"] for one in plan.members]
    # G at a given load goes with 1 / E; the load at fracture with sqrt(g_c E).
    scaled = dataset["fracture_load_factor"] / np.sqrt(dataset["toughness"] * dataset["E"])
    assert np.ptp(scaled.values) < 1e-9 * float(scaled[0])


def test_failed_members_are_marked(tmp_path: Path) -> None:
    plan, outcomes, dataset = solved(tmp_path, FAILING)
    assert dataset["status"].sel(pull=5).values.tolist() == [0, 0]
    assert dataset["status"].sel(pull=6).values.tolist() == [1, 1]
    for one in plan.members:
        at = dict(one.values)
        assert str(dataset["reason"].sel(at).values) == outcomes[one.key].reason
        assert np.isnan(dataset["G"].sel(at)).all() == (one.values["pull"] == 6)
        assert str(dataset["member_key"].sel(at).values) == one.key
    assert "out of balance" in str(dataset["reason"].sel(pull=6, element="T3").values)


def test_members_that_were_not_run(stationary) -> None:
    plan, outcomes, _ = stationary
    some = {one.key: outcomes[one.key] for one in plan.members[:1]}
    dataset = collect(plan, some)
    assert dataset["status"].values.ravel().tolist() == [0, 2, 2, 2]
    assert np.isfinite(dataset["G"].values.ravel()).tolist() == [True, False, False, False]


def test_no_member_went_well(tmp_path: Path) -> None:
    _, _, dataset = solved(tmp_path, FAILING.replace("[5, 6]", "[6, 7]"))
    assert (dataset["status"] == 1).all()
    assert "G" not in dataset


def test_steps_are_filled_up(growing) -> None:
    plan, _, dataset = growing
    assert dict(dataset["G"].sizes) == {"most": 2, "step": 4, "tip": 1}
    assert dataset["step"].values.tolist() == [1, 2, 3, 4]
    for one in plan.members:
        history = simulation.run(one.scene).history
        steps = history.sizes["step"]
        own = dataset.sel(one.values)
        for name in ("G", "tip_x", "load_factor", "tip_status", "strain_energy"):
            np.testing.assert_array_equal(own[name].values[:steps], history[name].values, name)
        assert np.isnan(own["G"].values[steps:]).all()
        assert (own["tip_status"].values[steps:] == -1).all()
    assert dataset["tip_status"].attrs["flag_meanings"].split()[0] == "none"


def test_last_values_and_counts(growing) -> None:
    plan, _, dataset = growing
    for one in plan.members:
        history = simulation.run(one.scene).history
        own = dataset.sel(one.values)
        for name in LAST:
            values = history[name].values.astype(float)
            known = values[np.isfinite(values).reshape(len(values), -1).all(axis=1)]
            assert (own[f"final_{name}"].values == known[-1]).all(), name
        path = np.hypot(np.diff(history["tip_x"][:, 0]), np.diff(history["tip_y"][:, 0])).sum()
        assert float(own["path_length"][0]) == pytest.approx(float(path), rel=1e-14)
        assert float(own["increments"]) == one.values["most"] == history.sizes["step"] - 1
        assert float(own["peak_load_factor"]) == float(history["load_factor"].max())
        first = float(history["critical_load_factor"][0].min())
        assert float(own["fracture_load_factor"]) == first


def test_load_steps_without_growth_are_kept(tmp_path: Path) -> None:
    text = (
        "name: stepped\nbase: small.yaml\nreplace: {load_steps: 3, kinematics: finite}\n"
        "zip: {traction: {key: family.traction, values: [120, 3000]}}\n"
    )
    plan, _, dataset = solved(tmp_path, text)
    assert dict(dataset["J"].sizes) == {"sample": 2, "step": 3, "tip": 1}
    for one in plan.members:
        history = simulation.run(one.scene).history
        own = dataset.isel(sample=one.index[0])
        np.testing.assert_array_equal(own["J"].values, history["J"].values)
        assert float(own["final_J"][0]) == float(history["J"][-1, 0])
        # g_c is 1. The load at fracture is that of another run which has it as its load.
        factor = float(own["fracture_load_factor"])
        at_fracture = one.scene.model_copy(update={"load_steps": [factor]})
        assert float(simulation.run(at_fracture).history["J"][-1, 0]) == pytest.approx(1, rel=0.05)
    assert dataset["load_factor"].values[0].tolist() == [1 / 3, 2 / 3, 1]
    assert (dataset["increments"] == 0).all()
    assert (dataset["path_length"] == 0).all()


def test_loads_without_growth_are_no_increments(tmp_path: Path) -> None:
    text = GROWING.replace("{control: crack}", "{control: load}").replace(
        "  mesh:", "  load_steps: [0.1, 0.2, 9]\n  mesh:"
    )
    _, _, dataset = solved(tmp_path, text)
    own = dataset.isel(most=1)
    x = own["tip_x"].values[:, 0]
    assert own["increments"] == np.count_nonzero(np.diff(x[np.isfinite(x)]))
    assert own["increments"] == np.isfinite(x).sum() - 3


def test_a_body_without_cracks(tmp_path: Path) -> None:
    for steps in (1, 2):
        text = UNCRACKED.replace("load_steps: 1", f"load_steps: {steps}")
        _, _, dataset = solved(tmp_path, text)
        assert (dataset["status"] == 0).all()
        assert dataset.sizes["tip"] == 0
        assert (dataset["strain_energy"] > 0).all()
        assert np.isnan(dataset["fracture_load_factor"]).all()


def test_a_member_that_became_unstable_is_marked(stationary) -> None:
    plan, outcomes, _ = stationary
    torn = replace(outcomes[plan.members[0].key], status="unstable", reason="unstable: it tears")
    dataset = collect(plan, {**outcomes, torn.key: torn})
    assert dataset["status"].values.ravel().tolist() == [3, 0, 0, 0]
    assert dataset["reason"].values.ravel()[0] == "unstable: it tears"
    # Its steps are there, and what README tells to leave out leaves it out.
    assert np.isfinite(dataset["G"].values).all()
    left = dataset["G"].where(dataset["status"] == 0)
    assert np.isnan(left.values.ravel()).tolist() == [True, False, False, False]


def write_mesh(path: Path) -> None:
    """A block of 10 mm by 20 mm as a mesh file."""
    with gmsh_session() as gmsh:
        gmsh.model.occ.addRectangle(0, 0, 0, 10, 20)
        gmsh.model.occ.synchronize()
        for curve, name in ((1, "bottom"), (3, "top")):
            gmsh.model.addPhysicalGroup(1, [curve], name=name)
        gmsh.model.addPhysicalGroup(2, [1], name="body")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 4)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))


def test_the_scene_of_a_member_of_a_mesh_file(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "meshes").mkdir()
    write_mesh(tmp_path / "meshes" / "plate.msh")
    base = UNCRACKED[UNCRACKED.index("  name:") : UNCRACKED.index("product:")]
    geometry = base[base.index("  geometry:") : base.index("  material:")]
    base = base.replace(geometry, "  mesh_file: {file: meshes/plate.msh}\n")
    base = base[: base.index("  mesh: {")]
    text = f"name: meshed\nbase:\n{base}zip: {{nu: {{key: material.nu, values: [0.2, 0.3]}}}}\n"
    plan, _, dataset = solved(tmp_path, text)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert dataset.isel(sample=1).cfmpm.scene == plan.members[1].scene
    with (tmp_path / "meshes" / "plate.msh").open("a") as file:
        file.write("$Comments\n$EndComments\n")
    with pytest.raises(SceneError, match=r"plate\.msh: has changed since the study"):
        dataset.isel(sample=1).cfmpm.scene  # noqa: B018


def test_what_the_scene_says_about_a_key(stationary, growing) -> None:
    scene = stationary[0].members[0].scene
    assert described(scene, "mesh.size") == {
        "key": "mesh.size",
        "units": "mm",
        "long_name": "element size",
    }
    assert described(scene, "family.kind") == {"key": "family.kind"}
    assert described(scene, "growth.increments") == {"key": "growth.increments"}
    assert described(growing[0].members[0].scene, "growth.increments")["long_name"].startswith(
        "largest number of increments"
    )
