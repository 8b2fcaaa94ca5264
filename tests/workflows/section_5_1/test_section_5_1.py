"""Values of section 5.1, and claims that depend on them."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from page_parts import program_words

import cfmpm
from workflows.configuration.scene_with_grid import scene_with
from workflows.reporting.claim_table import cells
from workflows.section_5_1 import claims, datasets, figures
from workflows.section_5_1.settings import SERIES

CONVERGED = 0.2547822
RADII = [10.0, 50.0, 70.0, 90.0]


def uniform(element, *sizes):
    return {
        f"{element}_{round(1.155e6 / size**2)}": {
            "element": element,
            "size": size,
            "grading": "uniform",
        }
        for size in sizes
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory, scene_file):
    """The study on coarse grids: files by series, the file of the grids, the T3 sizes."""
    folder = tmp_path_factory.mktemp("section_5_1")
    T3 = uniform("T3", 40, 25, 15)
    graded = {"element": "T6", "size": 60, "grading": {"tip_size": 0.05, "growth": 0.3}}
    meshes = {**T3, **uniform("T6", 40, 25, 15), "T6_graded_1400": graded}
    study = {
        "name": "coarse",
        "base": scene_file,
        "replace": {"fracture.radii": RADII},
        "measure": "workflows.section_5_1.fem_beside:fem_on_the_same_grid",
        "product": {"grid": {"key": "mesh", "values": meshes}},
    }
    (folder / "study.yaml").write_text(json.dumps(study), encoding="utf-8")
    files = {name: folder / f"{name}.nc" for name in SERIES}
    names = [int(name.removeprefix("T3_")) for name in T3][:2]
    grids = folder / "grids.nc"
    datasets.write_datasets(str(folder / "study.yaml"), names, 2, files, grids)
    return files, grids, names


@pytest.fixture(scope="module")
def files(made):
    return made[0]


@pytest.fixture(scope="module")
def evidence(files):
    T3, T6, graded = (xr.load_dataset(path) for path in files.values())
    return claims.Evidence(
        T3, T6, graded, 50.0, CONVERGED, (int(T3.grid[1]), int(T3.grid[2])), 100.0, 1000.0
    )


def test_handbook_value_is_the_256_newton_of_the_paper(scene_file):
    value = datasets.handbook_energy_release_rate(cfmpm.load_scene(scene_file))
    assert value == pytest.approx(0.25576, abs=5e-6)
    assert round(1000 * value) == 256


@pytest.mark.parametrize("name", ["T3", "T6"])
def test_equals_fem_of_its_own(files, name):
    series = xr.load_dataset(files[name])
    assert float(series.cf_difference.max()) < 1e-10
    for quantity in ("cf_norm", "cf_tip_norm", "J", "strain_energy"):
        mpm, fem = series[quantity].sel(scheme="MPM"), series[quantity].sel(scheme="FEM")
        np.testing.assert_allclose(mpm, fem, rtol=1e-10)


def test_error_at_about_2581_triangles(scene_file):
    """-11.4 % of the handbook's 0.2558, the value of an earlier study on one such grid.

    The norm for R = 50 mm, 2.4 elements, depends on which nodes are in the disc: grids of nearly
    equal size scatter by one per cent. Hence the mean of five grids, within one per cent.
    """
    norms = []
    for size in (21.2, 21.3, 21.4, 21.5, 21.6):
        mesh = {"element": "T3", "size": size, "grading": "uniform"}
        history = cfmpm.run(scene_with(scene_file, mesh, [50.0])).history
        assert float(history.n_points[0]) == pytest.approx(2581, rel=0.04)
        norms.append(float(history.cf_norm[0, 0]))
    errors = 100 * (np.array(norms) / 0.2558 - 1)
    assert errors.mean() == pytest.approx(-11.4, abs=1.0)
    np.testing.assert_allclose(errors, -11.4, atol=2.0)


def test_a_disc_smaller_than_an_element_holds_the_tip_alone(files):
    series = xr.load_dataset(files["T3"])
    np.testing.assert_allclose(series.cf_norm.sel(radius=10.0), series.cf_tip_norm, rtol=1e-12)


def test_graded_grid_is_near_the_plate_not_the_handbook(files):
    J = xr.load_dataset(files["T6_graded"]).J.sel(scheme="MPM", radius=90.0).isel(grid=0)
    assert float(J) == pytest.approx(CONVERGED, rel=5e-4)
    assert abs(float(J) / 0.25576 - 1) > 3e-3


def test_claims(evidence):
    held = {claim.claim: claim.held for claim in claims.decide(evidence)}
    assert held["MPM agrees with FEM on the same mesh"] == "yes"
    assert held["T6 with three points is better than T3 with one"] == "yes"
    assert held["R = 50 mm is one-twentieth of the crack length"] == "misprint"
    assert held["CF is path-dependent for a linear elastic material"] == "misprint"
    assert held["CF converges to the analytical value"] == "no"
    for claim in claims.decide(evidence):
        assert claim.sentence.endswith(".")
        assert program_words(" ".join([*cells(claim), claim.sentence])) == []


def test_claims_follow_the_data(evidence):
    """Changed data change the verdicts."""
    fem = evidence.T3.scheme == "FEM"
    off = evidence.T3.assign(J=evidence.T3.J * xr.where(fem, 1 + 1e-6, 1.0))
    assert claims.equals_fem(replace(evidence, T3=off)).held == "no"
    assert claims.t6_beats_t3(replace(evidence, T3=evidence.T6, T6=evidence.T3)).held == "no"
    assert claims.one_twentieth(replace(evidence, crack_length=1000.0)).held == "yes"
    wild = evidence.graded.assign(cf_norm=evidence.graded.cf_norm * (1 + evidence.T3.radius / 90))
    assert claims.path_dependent(replace(evidence, graded=wild)).held == "yes"
    tip = evidence.T3.cf_tip_norm
    exact = evidence.T3.assign(cf_tip_norm=xr.full_like(tip, CONVERGED))
    assert claims.domain_beats_tip(replace(evidence, T3=exact)).held == "no"


def test_table(files, scene_file, tmp_path, evidence):
    out = {name: tmp_path / name for name in ("table", "markdown", "page")}
    claims.write_claims(
        files, scene_file, radius=50.0, converged=CONVERGED, swept=list(evidence.swept), **out
    )
    rows = list(csv.DictReader(out["table"].open(encoding="utf-8")))
    assert len(rows) == len(claims.CLAIMS)
    for row in rows:
        assert row["claim"] in out["markdown"].read_text(encoding="utf-8")
    assert out["page"].read_text(encoding="utf-8").count("<tr") == len(rows) + 1


def test_figures_come_with_their_data(made, tmp_path):
    files, grids, names = made

    def out(name):
        return tmp_path / f"{name}.png", tmp_path / f"{name}.nc"

    figures.write_fig4(grids, names, *out("fig4"))
    figures.write_fig5(files["T3"], 50.0, CONVERGED, *out("fig5"))
    figures.write_fig6(files["T3"], grids, names, 50.0, CONVERGED, *out("fig6"))
    figures.write_fig7(files, 50.0, CONVERGED, *out("fig7"))
    for name in ("fig4", "fig5", "fig6", "fig7"):
        picture, data = out(name)
        assert picture.stat().st_size > 10_000
        assert xr.load_dataset(data).sizes
    assert dict(xr.load_dataset(out("fig6")[1]).cf_norm.sizes) == {"grid": 2, "radius": 4}
    assert xr.load_dataset(out("fig7")[1]).cf_norm.dims[0] == "element"
