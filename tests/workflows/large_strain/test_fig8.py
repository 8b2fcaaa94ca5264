"""Fig. 8: its dataset on a coarse grid, its FEM points, and claims that follow the data."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
import yaml
from page_parts import program_words

from cfmpm.ending import RUN_STATUS
from cfmpm.study.reading import load_study
from workflows.large_strain import claims
from workflows.large_strain.datasets import (
    G_AT_10,
    curve,
    fem,
    lefm,
    reached,
    write_large_strain,
    write_steps,
)
from workflows.large_strain.figures import write_fig8
from workflows.large_strain.laws_figure import write_laws
from workflows.large_strain.settings import PULLED, STEPS
from workflows.reporting.claim_table import cells
from workflows.study.solved import solved

MODULUS = 210e3 / (1 - 0.3**2)
LOST = {"hencky_T3_4": 0.14, "hencky_T6_4": 0.11, "hencky_T6_0.5": 0.04}


def made_up() -> xr.Dataset:
    """Synthetic variants: FEM values in place of cfmpm, with the expected ends of the paths."""
    ends = {"hencky_T3_4": 0.7, "hencky_T6_4": 0.36, "hencky_T6_0.5": 0.2, "hencky_dead": 0.33}
    ends |= {"hencky_domains": 0.1, "hencky_following": 0.3, "hencky_uniform": 0.67}
    at = np.array(list(claims.CONVERGED))
    j, force = np.array(list(claims.CONVERGED.values())).T
    grid = np.sort(np.append(np.linspace(0.025, 1.0, 40), [at[0], at[1]]))
    grid = np.unique(np.round(grid, 9))
    rows = []
    names = list(PULLED)
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
    data.attrs |= {"plane_modulus": MODULUS, "young": 210e3}
    return data


def loads() -> xr.Dataset:
    """Ten loads as printed: reached in one step but for the largest tractions, else ended early."""
    asked = np.array([np.linspace(1e4, 1e5, 10), np.linspace(5.0, 50.0, 10)])
    part = np.array([1.0, 0.5, 0.4, 0.3])
    factor = np.ones((2, 10, 4)) * part
    elongation = np.linspace(0.05, 0.5, 10)[None, :, None] * factor
    factor[0, 6:, 0], elongation[0, 6:, 0] = 0.9, 0.6
    elongation[0, :6, 0] *= np.linspace(1.0, 1.8, 6)
    path = curve(made_up(), "hencky_uniform")
    sizes = ("control", "case", "steps")
    stress = asked[0][:, None] * factor[0]
    return xr.Dataset(
        {
            "asked": (sizes[:2], asked),
            "load_factor": (sizes, factor),
            "elongation": (sizes, elongation),
            "nominal_stress": (sizes, np.array([stress, stress])),
            "cf_norm": (sizes, np.interp(elongation, path.elongation, path.force)),
            "empty_elements": (sizes, np.where(factor < 1.0, 300.0, 0.0)),
            "run_status": (sizes, np.where(factor < 1.0, RUN_STATUS.index("unstable"), 0)),
        },
        {"control": ["dead", "moved"], "steps": list(STEPS)},
    )


def evidence(curves=None, steps=None):
    curves = made_up() if curves is None else curves
    return claims.Evidence(curves, loads() if steps is None else steps)


def held(found, claim):
    decided = claim(found)
    return [one.verdict for one in (decided if isinstance(decided, list) else [decided])]


def scaled(data, variant, name, factor):
    data = data.copy(deep=True)
    data[name].loc[{"variant": variant}] *= factor
    return data


def test_what_is_right_and_what_is_wrong_is_said():
    decided = claims.decide(evidence())
    of_paper = {one.key: one.verdict for one in decided if one.key}
    assert of_paper == {
        "large_agrees": "in part",
        "large_tractions": "no",
        "large_strains": "misprint",
        "large_fracture": "in part",
        "large_fem": "no",
        "large_cpdi": "not tested",
    }
    assert [one.held for one in decided if not one.key] == ["yes", "yes", "no", "yes"]
    for one in decided:
        assert one.sentence.endswith(".") or not one.key
        assert program_words(" ".join([*cells(one), one.sentence])) == []


def all_reached(steps):
    """Every load in every number of steps, with the CF of the FEM."""
    shape = steps.elongation.shape
    elongation = np.broadcast_to(np.linspace(0.05, 0.5, 10)[None, :, None], shape)
    path = fem("hencky", "T6", 4.0)
    far = np.append(path.elongation, 0.6), np.append(path.force, 2e7)
    stress = np.broadcast_to(steps.asked.values[0][:, None], shape)
    return steps.assign(
        load_factor=xr.ones_like(steps.load_factor),
        elongation=steps.elongation.copy(data=elongation),
        cf_norm=steps.cf_norm.copy(data=np.interp(elongation, *far)),
        nominal_stress=steps.nominal_stress.copy(data=stress),
    )


@pytest.mark.parametrize(
    ("claim", "verdict"),
    [
        ("agrees", "yes"),
        ("largest_load", "yes"),
        ("elongations", "yes"),
        ("numerical_fracture", "no"),
    ],
)
def test_loads_that_would_all_be_reached_change_the_verdicts(claim, verdict):
    assert held(evidence(steps=all_reached(loads())), getattr(claims, claim)) == [verdict]


def test_verdicts_on_loads_follow_the_data():
    # No number of steps reaches any.
    none = loads()
    none["load_factor"] = 0.5 * none.load_factor
    assert held(evidence(steps=none), claims.agrees) == ["no"]
    # Every run ends beyond 50 %.
    late = loads()
    late["elongation"] = xr.where(late.load_factor < 1.0, 0.7, late.elongation)
    assert held(evidence(steps=late), claims.numerical_fracture) == ["yes"]
    # Strains that are neither those of the plate nor stress over E.
    soft = made_up().assign_attrs(young=100e3)
    assert held(evidence(soft), claims.elongations) == ["no"]


def test_ends_of_runs_are_told_by_their_status():
    assert {*claims.ENDINGS} < {*RUN_STATUS}
    told = claims.numerical_fracture(evidence()).found
    assert "the stiffness is no longer positive definite" in told
    status = xr.full_like(loads().run_status, RUN_STATUS.index("unsolvable"))
    told = claims.numerical_fracture(evidence(steps=loads().assign(run_status=status))).found
    assert "no equilibrium is found" in told


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
    assert held(evidence(scaled(made_up(), variant, name, factor)), claims.converged) == wanted


def test_a_departure_that_is_not_that_of_the_fem_has_not_held():
    found = evidence(scaled(made_up(), "hencky_dead", "J", 1.006))
    assert held(found, claims.small_loads) == ["no"]


def test_paths_that_would_contradict_the_verdicts_change_them():
    """Verdicts follow the data: domains to 50 %, finer grids that go further."""
    data, finer = made_up(), made_up()
    whole = data.sel(variant="neo_hookean_T3_4")
    for name in ("elongation", "cf_norm", "J"):
        data[name].loc[{"variant": "hencky_domains"}] = whole[name]
        finer[name].loc[{"variant": "hencky_T6_0.5"}] = whole[name]
    assert held(evidence(data), claims.domains) == ["yes"]
    assert held(evidence(finer), claims.what_stops) == ["in part"]


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
        "hencky_domains": {**coarse, "formulation": "updated"},
        "hencky_dead": {**coarse, "loads": [], "family.traction": 1e5},
    }
    study = {
        "name": "coarse",
        "base": str(root / "configs/paper/large_strain.yaml"),
        "measure": "workflows.large_strain.ellipticity:load_of_loss",
        "product": {"variant": {"variants": names}},
    }
    (tmp_path / "study.yaml").write_text(json.dumps(study))
    (solution,) = solved([load_study(tmp_path / "study.yaml")], 2)
    solution.to_netcdf(tmp_path / "study.nc")
    write_large_strain(tmp_path / "study.nc", study["base"], tmp_path / "curves.nc")
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


def test_dataset_of_the_loads(root, tmp_path):
    """Where each load led to, by its number of steps."""
    coarse = {"mesh": {"element": "T3", "size": 100, "grading": "uniform"}}
    ends = {"loads[0].displacement": {"y": -25}, "loads[1].displacement": {"y": 25}}
    named = {"dead_10000": {"loads": [], "family.traction": 1e4}, "moved_5": ends}
    study = {
        "name": "coarse",
        "base": str(root / "configs/paper/large_strain.yaml"),
        "replace": {**coarse, "formulation": "updated"},
        "product": {
            "load": {"variants": named},
            "steps": {"key": "load_steps", "values": [1, 2]},
        },
    }
    (tmp_path / "study.yaml").write_text(json.dumps(study))
    (solution,) = solved([load_study(tmp_path / "study.yaml")], 2)
    solution.to_netcdf(tmp_path / "study.nc")
    write_steps(tmp_path / "study.nc", study["base"], tmp_path / "steps.nc")
    steps = xr.load_dataset(tmp_path / "steps.nc")
    assert dict(steps.cf_norm.sizes) == {"control": 2, "case": 1, "steps": 2}
    assert steps.asked.values.ravel().tolist() == [1e4, 5.0]
    assert bool(reached(steps).sel(steps=1).all())
    moved, dead = (steps.sel(control=name, steps=1) for name in ("moved", "dead"))
    np.testing.assert_allclose(moved.elongation, 0.05, rtol=1e-4)
    np.testing.assert_allclose(dead.nominal_stress, 1e4, rtol=1e-9)


def test_figures_are_drawn(tmp_path):
    made_up().to_netcdf(tmp_path / "curves.nc")
    loads().to_netcdf(tmp_path / "steps.nc")
    figure, laws = ([tmp_path / f"{name}.{kind}" for kind in ("png", "nc")] for name in "ab")
    write_fig8(tmp_path / "curves.nc", tmp_path / "steps.nc", *figure)
    write_laws(tmp_path / "curves.nc", *laws)
    for picture, data in (figure, laws):
        assert picture.stat().st_size > 20_000
        assert xr.load_dataset(data).sizes


def test_the_paper_s_grid_is_that_of_what_is_printed(root):
    """The same grid without reset is compared with."""
    folder = root / "configs/paper"
    study = load_study(folder / "studies/large_strain.yaml").study.product["variant"].variants
    printed = yaml.safe_load((folder / "as_printed.yaml").read_text(encoding="utf-8"))
    best = yaml.safe_load((folder / "best.yaml").read_text(encoding="utf-8"))
    for variant in ("hencky_uniform", "hencky_uniform_dead", "hencky_domains"):
        assert study[variant]["mesh"] == printed["large_strain"]["mesh"]
    assert study["ciarlet_T6_0.5"] == best["large_strain"]
