"""UGRID files: conformance, readers, values."""

from __future__ import annotations

import warnings
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from growing_scene import growing
from outlines import named_rectangle
from ugrid_rules import broken_rules

from cfmpm.output.fields import build_fields, linear_faces, von_mises
from cfmpm.output.files import store, write_dataset
from cfmpm.scene import scene_from_dict
from cfmpm.simulation import run
from cfmpm.state import Result


def plate(**changes: object) -> dict[str, object]:
    """A plate in tension with an edge crack and an inclusion."""
    return {
        "name": "plate",
        "geometry": {
            "outline": named_rectangle(10, 20),
            "cracks": [{"points": [[0, 10], [4, 10]]}],
            "regions": [
                {
                    "name": "inlay",
                    "polygon": [[2, 14], [6, 14], [6, 17], [2, 17]],
                    "material": {"E": 70e3, "nu": 0.45},
                }
            ],
        },
        "material": {"E": 210e3, "nu": 0.3},
        "loads": [
            {"edge": "top", "traction": [0, 10]},
            {"edge": "bottom", "traction": [0, -10]},
        ],
        "mesh": {"element": "T6", "size": 2, "grading": {"tip_size": 0.4}},
        **changes,
    }


@pytest.fixture(scope="module", params=["T3", "T6"])
def result(request: pytest.FixtureRequest) -> Result:
    mesh = {"element": request.param, "size": 2, "grading": {"tip_size": 0.4}}
    return run(scene_from_dict(plate(mesh=mesh)))


@pytest.fixture(scope="module")
def fields(result: Result) -> xr.Dataset:
    return build_fields(result)


@pytest.fixture
def file(fields: xr.Dataset, tmp_path: Path) -> Path:
    path = tmp_path / "fields.nc"
    write_dataset(fields, path)
    return path


def test_ugrid_rules_hold(file: Path) -> None:
    assert broken_rules(file) == []


@pytest.mark.parametrize(
    ("variable", "attribute", "rule"),
    [
        ("grid", "cf_role", "R101"),
        ("grid", "topology_dimension", "R103"),
        ("grid", "node_coordinates", "R108"),
        ("face_nodes", "start_index", "R309"),
        ("u_x", "location", "R503"),
    ],
)
def test_a_broken_rule_is_seen(file: Path, variable: str, attribute: str, rule: str) -> None:
    with netCDF4.Dataset(file, "a") as opened:
        opened[variable].delncattr(attribute)
    assert any(text.startswith(rule) for text in broken_rules(file))


def test_plain_xarray_reads_back_what_was_written(file: Path, fields: xr.Dataset) -> None:
    with xr.open_dataset(file, mask_and_scale=False) as opened:
        for name in fields.variables:
            np.testing.assert_array_equal(opened[name], fields[name], err_msg=str(name))
        assert opened["face_nodes"].dtype == np.int32


def test_xugrid_reads_the_same_values_without_a_warning(file: Path, fields: xr.Dataset) -> None:
    xugrid = pytest.importorskip("xugrid")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        opened = xugrid.open_dataset(file)
    grid = opened.ugrid.grid
    np.testing.assert_array_equal(grid.node_x, fields["node_x"])
    np.testing.assert_array_equal(grid.face_node_connectivity, fields["face_nodes"])
    for name in ("u_y", "cf_x", "sigma_zz", "von_mises"):
        np.testing.assert_array_equal(opened[name].values, fields[name].values)
    opened.close()


def test_vtk_reads_the_same_values(file: Path, fields: xr.Dataset) -> None:
    netcdf = pytest.importorskip("vtkmodules.vtkIONetCDF")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader = netcdf.vtkNetCDFUGRIDReader()
    reader.SetFileName(str(file))
    reader.Update()
    output = reader.GetOutput()
    assert output.GetNumberOfCells() == fields.sizes["face"]
    points = vtk_to_numpy(output.GetPoints().GetData())
    np.testing.assert_array_equal(points[:, 0], fields["node_x"])
    for name in ("u_x", "u_y", "cf_x", "cf_y"):
        values = vtk_to_numpy(output.GetPointData().GetArray(name))
        np.testing.assert_array_equal(values, fields[name].values[0])
    for name in ("sigma_xx", "von_mises", "energy_density", "element", "region"):
        values = vtk_to_numpy(output.GetCellData().GetArray(name))
        np.testing.assert_array_equal(values, np.atleast_2d(fields[name].values)[0])


def test_a_file_takes_additions(file: Path) -> None:
    """By netCDF and by xarray, as when a user adds computed variables."""
    xr.Dataset({"mine": ("x", [1.0, 2.0])}).to_netcdf(file, mode="a")
    with xr.open_dataset(file) as opened:
        assert opened["mine"].values.tolist() == [1.0, 2.0]
        assert "u_x" in opened


def test_nodes_of_faces_are_read_as_integers(fields: xr.Dataset, tmp_path: Path) -> None:
    """Also by xarray alone, which reads integers with a fill value as floats."""
    store(fields, tmp_path / "fields.nc")
    with xr.open_dataset(tmp_path / "fields.nc") as read:
        assert read["face_nodes"].dtype == np.int32
        assert "_FillValue" not in read["face_nodes"].encoding
        np.testing.assert_array_equal(read["face_nodes"], fields["face_nodes"])


def test_faces_fill_the_body_and_use_every_node(result: Result) -> None:
    faces, element = linear_faces(result.grid)
    a, b, c = (result.grid.nodes[faces[:, k]] for k in range(3))
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert area.min() > 0.0
    np.testing.assert_allclose(np.bincount(element, area), result.grid.areas)
    np.testing.assert_array_equal(np.unique(faces), np.arange(len(result.grid.nodes)))


def test_a_face_carries_the_point_in_its_middle(result: Result, fields: xr.Dataset) -> None:
    faces, _ = linear_faces(result.grid)
    centre = result.grid.nodes[faces].mean(axis=1)
    stress = fields["sigma_yy"].values[0]
    if result.grid.elements.shape[1] == 6:
        middle = stress.reshape(-1, 4)
        np.testing.assert_allclose(middle[:, 3], middle[:, :3].mean(axis=1))
        corner = np.arange(len(faces)) % 4 < 3
        centre, stress = centre[corner], stress[corner]
    np.testing.assert_allclose(centre, result.points.position, atol=1e-12)
    np.testing.assert_array_equal(stress, result.points.stress[:, 1])


def test_energy_of_the_points_is_that_of_the_body(result: Result, fields: xr.Dataset) -> None:
    energy = float((fields["point_volume"] * fields["point_energy_density"]).sum())
    assert energy == pytest.approx(float(result.history["strain_energy"][-1]), rel=1e-12)


def test_sigma_zz_is_that_of_the_region_in_plane_strain(fields: xr.Dataset) -> None:
    nu = np.where(fields["region"] == 1, 0.45, 0.3)
    in_plane = fields["sigma_xx"] + fields["sigma_yy"]
    np.testing.assert_allclose(fields["sigma_zz"], nu * in_plane, rtol=1e-12, atol=1e-12)
    assert set(np.unique(fields["region"])) == {0, 1}


def test_sigma_zz_vanishes_in_plane_stress() -> None:
    fields = build_fields(run(scene_from_dict(plate(plane="stress"))))
    assert not fields["sigma_zz"].values.any()


@pytest.mark.parametrize("law", ["hencky", "neo_hookean", "ciarlet", "j2"])
@pytest.mark.parametrize("nu", [0.3, 0.499])
def test_sigma_zz_of_finite_deformation(law: str, nu: float) -> None:
    """lambda U'(J) with J averaged over patches, plus the out-of-plane elastic part."""
    material = {"E": 1e3, "nu": nu, "law": law}
    if law == "j2":
        material |= {"yield_stress": 10, "hardening": 20}
    geometry = {"outline": [[0, 0], [20, 0], [20, 10], [0, 10]]}
    loads = [
        {"edge": "edge_4", "displacement": {"x": 0, "y": 0}},
        {"edge": "edge_2", "displacement": {"x": 3, "y": 1}},
    ]
    mesh = {"element": "T3", "size": 3}
    scene = plate(geometry=geometry, material=material, loads=loads, mesh=mesh, kinematics="finite")
    result = run(scene_from_dict(scene))
    points, patches = result.points, result.body.patches
    assert (patches is not None) == (nu > 0.45 or law == "j2")
    lam, mu = 1e3 * nu / ((1 + nu) * (1 - 2 * nu)), 0.5e3 / (1 + nu)
    J = mean = np.linalg.det(np.eye(2) + points.displacement_gradient)
    if patches is not None:
        patch = patches.of_triangle[points.element]
        mean = (np.bincount(patch, points.volume * J) / np.bincount(patch, points.volume))[patch]
    expected = lam * (0.5 * (mean - 1 / mean) if law == "ciarlet" else np.log(mean) / mean)
    if law == "j2":
        flowed = points.internal_variables[:, 3]
        assert np.abs(flowed).max() > 0.01
        expected += mu * np.log1p(flowed) / J
    fields = build_fields(result)
    for name in ("sigma_zz", "point_sigma_zz"):
        np.testing.assert_allclose(fields[name].values[0], expected, atol=1e-9 * lam)
    in_plane = [fields[f"sigma_{name}"].values[0] for name in ("xx", "yy", "xy")]
    np.testing.assert_allclose(
        fields["von_mises"].values[0], von_mises(np.column_stack([*in_plane, expected])), rtol=1e-6
    )


@pytest.mark.parametrize("transfer", ["domains", "paper"])
def test_a_grown_grid_carries_what_its_own_triangles_feel(transfer: str) -> None:
    """Not the values of the points, which do not move with the grid."""
    result = run(scene_from_dict(growing(transfer=transfer, increments=8)))
    grid, fields = result.grid, build_fields(result)
    assert fields.sizes["face"] == len(grid.elements)
    a, b, c = (grid.nodes[grid.elements[:, k]] for k in range(3))
    slopes = np.stack([b - a, c - a], axis=1)
    u_a, u_b, u_c = (result.displacement[grid.elements[:, k]] for k in range(3))
    gradient = np.linalg.solve(slopes, np.stack([u_b - u_a, u_c - u_a], axis=1))
    lam, mu = 210e3 * 0.3 / (1.3 * 0.4), 210e3 / 2.6
    trace = gradient[:, 0, 0] + gradient[:, 1, 1]
    expected = lam * trace + 2.0 * mu * gradient[:, 1, 1]
    # Of the state at load factor one; the last step has another one.
    factor = float(fields["load_factor"][0])
    assert factor == float(result.history["load_factor"][-1]) != 1.0
    np.testing.assert_allclose(
        fields["sigma_yy"].values[0], factor * expected, rtol=0, atol=1e-9 * np.abs(expected).max()
    )


@pytest.mark.parametrize("nu", [0.3, 0.49])
def test_faces_and_points_of_linear_triangles_feel_the_same(nu: float) -> None:
    """Also the volume change averaged over patches."""
    scene = plate(material={"E": 210e3, "nu": nu}, mesh={"element": "T3", "size": 2})
    scene["geometry"] = scene["geometry"] | {"regions": []}
    result = run(scene_from_dict(scene))
    assert (result.body.patches is not None) == (nu > 0.45)
    fields = build_fields(result)
    for name in ("sigma_xx", "sigma_yy", "sigma_xy", "sigma_zz", "energy_density"):
        on_faces, of_points = fields[name].values[0], fields[f"point_{name}"].values[0]
        np.testing.assert_allclose(on_faces, of_points, rtol=0, atol=1e-12 * on_faces.max())


@pytest.mark.slow
def test_fields_of_a_severed_body_are_those_of_its_last_balance() -> None:
    result = run(scene_from_dict(growing(increments=200)))
    history, fields = result.history, build_fields(result)
    assert history.attrs["run_status"] == "severed"
    assert np.isnan(history["load_factor"][-1])
    assert fields["time"].values == history.sizes["step"] - 1
    assert float(fields["load_factor"][0]) == float(history["load_factor"][-2])
    assert float(fields["crack_length"][0]) == pytest.approx(
        float(history["crack_length"][-2, 0]), rel=1e-12
    )


@pytest.mark.parametrize(
    ("stress", "equivalent"),
    [((7, 0, 0, 0), 7), ((0, 0, 2, 0), 2 * np.sqrt(3)), ((5, 5, 0, 5), 0), ((0, 0, 0, -3), 3)],
)
def test_von_mises(stress: tuple[float, ...], equivalent: float) -> None:
    assert von_mises(np.array([stress], float)) == pytest.approx(equivalent)


def test_the_file_says_where_it_comes_from(fields: xr.Dataset, result: Result) -> None:
    assert "UGRID-1.0" in fields.attrs["Conventions"]
    assert fields.attrs["config_hash"] == result.history.attrs["config_hash"]
    assert fields["load_factor"].values == [1.0]
    for name, variable in fields.variables.items():
        assert "long_name" in variable.attrs, name
