"""Fig. 8: its dataset on a coarse grid, its FEM points, and claims that follow the data."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
import yaml
from page_parts import program_words

from cfmpm.ending import RUN_STATUS
from workflows.large_strain import claims
from workflows.large_strain.datasets import G_AT_10, curve, fem, lefm, write_large_strain
from workflows.large_strain.figures import HENCKY, NEO_HOOKEAN, STRESS, write_fig8
from workflows.reporting.claim_table import cells

MODULUS = 210e3 / (1 - 0.3**2)
LOST = {"hencky_T3_4": 0.14, "hencky_T6_4": 0.11, "hencky_T6_0.5": 0.04}


def made_up() -> xr.Dataset:
    """Synthetic variants: FEM values in place of cfmpm, with the expected ends of the paths."""
    ends = {"hencky_T3_4": 0.7, "hencky_T6_4": 0.36, "hencky_T6_0.5": 0.2, "hencky_dead": 0.33}
    ends |= {"hencky_paper": 0.05, "ciarlet_paper": 0.05, "hencky_following": 0.3}
    at = np.array(list(claims.CONVERGED))
    j, force = np.array(list(claims.CONVERGED.values())).T
    grid = np.sort(np.append(np.linspace(0.025, 1.0, 40), [at[0], at[1]]))
    grid = np.unique(np.round(grid, 9))
    rows = []
    names = list(dict.fromkeys([*HENCKY, *NEO_HOOKEAN, *STRESS]))
    for name in names:
        elongation = np.where(grid <= ends.get(name, 1.0) + 1e-9, grid, np.nan)
        value = np.interp(elongation, np.append(0, at), np.append(0, j))
        stress = np.interp(elongation, np.append(0, at), np.append(0, force / claims.WIDTH))
        if name == "hencky_dead":
            stress = np.linspace(2500.0, 45000.0, len(grid))
            value = lefm(stress / MODULUS, MODULUS) * (1 + claims.BY_100_MPA * stress / 100)
        rows.append(
            xr.Dataset(
                {
                    key: ("step", np.where(np.isnan(elongation), np.nan, column))
                    for key, column in {
                        "elongation": elongation,
                        "J": value,
                        "cf_norm": value,
                        "nominal_stress": stress,
                        "unstable_points": 1.0 * (elongation > LOST.get(name, 2.0)),
                        "empty_elements": 0.0 * elongation,
                    }.items()
                }
            )
        )
    data = xr.concat(rows, xr.Variable("variant", names))
    data["ellipticity_lost"] = ("variant", [LOST.get(name, np.nan) for name in names])
    data.attrs["plane_modulus"] = MODULUS
    return data


def held(data, claim):
    decided = claim(data)
    return [one.held for one in (decided if isinstance(decided, list) else [decided])]


def scaled(data, variant, name, factor):
    data = data.copy(deep=True)
    data[name].loc[{"variant": variant}] *= factor
    return data


def test_what_is_right_and_what_is_wrong_is_said():
    found = {one.claim: one.held for one in claims.decide(made_up())}
    assert list(found.values()) == ["yes", "yes", "no", "no", "no", "no", "misprint", "yes"]
    for one in claims.decide(made_up()):
        assert "8" in one.figures
        assert one.sentence.endswith(".")
        assert program_words(" ".join([*cells(one), one.sentence])) == []


@pytest.mark.parametrize(
    ("variant", "name", "factor", "wanted"),
    [
        ("neo_hookean_T6_0.5", "J", 1.0051, ["no", "yes"]),
        ("neo_hookean_T6_0.5", "J", 0.9951, ["yes", "yes"]),
        ("neo_hookean_T6_0.5", "nominal_stress", 0.994, ["no", "yes"]),
        ("neo_hookean_following", "J", 1.019, ["yes", "yes"]),
        ("neo_hookean_following", "J", 0.979, ["yes", "no"]),
    ],
)
def test_numbers_that_miss_their_bar_have_not_held(variant, name, factor, wanted):
    assert held(scaled(made_up(), variant, name, factor), claims.converged) == wanted


def test_a_departure_that_is_not_that_of_the_fem_has_not_held():
    assert held(scaled(made_up(), "hencky_dead", "J", 1.006), claims.small_loads) == ["no"]


def test_paths_that_would_contradict_the_verdicts_change_them():
    """Verdicts follow the data: paper mode to 50 %, finer grids that go further."""
    data = made_up()
    whole = data.sel(variant="neo_hookean_T3_4")
    for name in ("elongation", "cf_norm", "J"):
        data[name].loc[{"variant": "hencky_paper"}] = whole[name]
    assert held(data, claims.paper_mode) == ["yes", "no"]
    finer = made_up()
    for name in ("elongation", "cf_norm", "J"):
        finer[name].loc[{"variant": "hencky_T6_0.5"}] = whole[name]
    assert held(finer, claims.what_stops) == ["in part"]


@pytest.mark.parametrize("law", ["hencky", "neo_hookean", "ciarlet"])
@pytest.mark.parametrize("element", ["T3", "T6"])
def test_fem_points_are_stable_states(law, element):
    path = fem(law, element, 4.0)
    assert len(path.elongation) >= 5
    assert (np.diff(path.elongation) > 0).all()
    assert (np.diff(path.force) > 0).all()
    assert (path.elongation[-1] == 1.0) == (law != "hencky")


def test_dataset_of_a_coarse_grid(root, tmp_path):
    """One run with each formulation; the paths end with the runs."""
    coarse = {"mesh": {"element": "T3", "size": 100, "grading": {"tip_size": 40}}, "load_steps": 20}
    names = {
        "hencky_T3_4": coarse,
        "neo_hookean_T3_4": {**coarse, "material.law": "neo_hookean"},
        "hencky_paper": {**coarse, "formulation": "updated"},
        "hencky_dead": {**coarse, "loads": [], "family.traction": 1e5},
    }
    study = {
        "name": "coarse",
        "base": str(root / "configs/paper/large_strain.yaml"),
        "measure": "workflows.large_strain.ellipticity:load_of_loss",
        "product": {"variant": {"variants": names}},
    }
    (tmp_path / "study.yaml").write_text(json.dumps(study))
    write_large_strain(str(tmp_path / "study.yaml"), 2, tmp_path / "curves.nc")
    data = xr.load_dataset(tmp_path / "curves.nc")
    assert data.plane_modulus == pytest.approx(MODULUS)
    neo, dead = curve(data, "neo_hookean_T3_4"), curve(data, "hencky_dead")
    assert neo.elongation[-1] == pytest.approx(1.0)
    assert neo.elliptic.all()
    assert dead.stress[-1] < MODULUS / np.e
    assert RUN_STATUS[int(data.run_status.sel(variant="hencky_dead"))] == "unstable"
    known = fem("neo_hookean", "T3", 8.0)
    j = np.interp(known.elongation, neo.elongation, neo.force)
    assert np.abs(j / known.force - 1.0).max() < 0.25  # five times the size at the tip
    lost = float(data.ellipticity_lost.sel(variant="hencky_T3_4"))
    hencky = curve(data, "hencky_T3_4")
    assert hencky.elongation[hencky.elliptic].max() <= lost + 0.05


def test_linear_elasticity_is_that_of_section_5_1(root):
    text = (root / "configs/workflow/section_5_1.yaml").read_text(encoding="utf-8")
    assert yaml.safe_load(text)["section_5_1"]["converged"] == G_AT_10


def test_figure_is_drawn(tmp_path):
    made_up().to_netcdf(tmp_path / "curves.nc")
    write_fig8(tmp_path / "curves.nc", tmp_path / "fig8.png", tmp_path / "fig8.nc")
    assert (tmp_path / "fig8.png").stat().st_size > 20_000
