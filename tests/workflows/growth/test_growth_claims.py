"""Claims of sections 5.2 to 5.5 follow the data: values beyond a bound fail."""

from __future__ import annotations

import csv
from dataclasses import replace

import growth_data as made_up
import numpy as np
import pytest
import xarray as xr
from page_parts import program_words

from cfmpm.ending import RUN_STATUS
from workflows.growth import beam_claims, claims, edge_claims, holes_claims, shear_claims
from workflows.growth.beam_claims import BEAM
from workflows.growth.datasets import energy_released, steps
from workflows.growth.evidence import Evidence
from workflows.growth.holes_claims import HOLES, SEEN
from workflows.growth.shear_claims import SHEAR
from workflows.reporting.claim_table import cells


@pytest.fixture(scope="module")
def evidence():
    return Evidence(**{name: getattr(made_up, name)() for name in claims.DATASETS})


moved, scaled, ended = made_up.moved, made_up.scaled, made_up.ended


def held(evidence, claim, words):
    """The verdicts of the claims whose text contains all the words."""
    decided = claim(evidence)
    decided = decided if isinstance(decided, list) else [decided]
    found = [one.held for one in decided if all(word in one.claim for word in words)]
    assert found
    return found


def test_all_hold_on_data_that_are_right(evidence):
    decided = claims.decide(evidence)
    assert {one.key for one in decided if one.held != "yes"} == {
        "holes_phase_field",
        "beam_experiments",
    }
    assert len({one.claim for one in decided}) == len(decided) > 40


def test_claims_are_told_in_words_of_the_field(evidence):
    lost = replace(
        evidence,
        holes=ended(moved(evidence.holes, "best", 0, 2 * HOLES), "as_printed", "arrived_crack"),
        beam=ended(evidence.beam, "as_printed_10_4", "growing"),
    )
    for one in (*claims.decide(evidence), *claims.decide(lost)):
        assert one.sentence.endswith(".")
        assert program_words(" ".join([*cells(one), one.sentence])) == []


def on_one_grid(scatter, dx=0.0, dy=0.0, from_step=1):
    """The same with the paths on the first grid shifted from a step on [mm]."""
    here = (scatter.grid == scatter.grid[0]) & (scatter.step >= from_step)
    return scatter.assign(tip_x=scatter.tip_x + here * dx, tip_y=scatter.tip_y + here * dy)


def on_all_grids(scatter, dx=0.0, dy=0.0, from_step=1):
    here = scatter.step >= from_step
    return scatter.assign(tip_x=scatter.tip_x + here * dx, tip_y=scatter.tip_y + here * dy)


def turned(dataset, variant, angle):
    """CF over the domain turned in one variant [deg]."""
    return dataset.assign(cf_angle=dataset.cf_angle + angle * (dataset.variant == variant))


def lost(dataset, *variants):
    """No stable state follows in some variants."""
    status = np.int8(RUN_STATUS.index("unstable"))
    return dataset.assign(
        run_status=xr.where(dataset.variant.isin(variants), status, dataset.run_status)
    )


RANGE = edge_claims.angles_in_range, ("790",)
STRAIGHT = edge_claims.best_path, ()
MIDDLE = edge_claims.centre_line, ()
SHEARED = shear_claims.shear_path, ("the best",)
TURNS = shear_claims.down_then_flat, ()
FEM = shear_claims.beside_fem, ()
BESIDE, BEST = (holes_claims.beside_fem, ()), (holes_claims.best_paths, ())
OF_BEAM = beam_claims.beam_paths, ("1.5 in", "as printed")
CASE_1, CASE_2 = (beam_claims.case_1, ()), (beam_claims.case_2, ())

# Dataset, what is done to it, the claim, what it is then.
ALTERED = {
    "another radius": (
        *("edge", scaled, ("as_printed_790", "domain_radius", 0.9)),
        *((edge_claims.set_up, ()), "in part"),
    ),
    "bends beyond the range on one grid": (
        *("edge_grids", on_one_grid, (0.0, 12.0, 21), RANGE, "in part"),
    ),
    "bends on all grids but the paper's": (
        *("edge_grids", on_all_grids, (0.0, 12.0, 21), RANGE, "in part"),
    ),
    "runs without bends": (
        *("edge", moved, ("as_printed_790", 0.0, np.nan), (edge_claims.no_convergence, ()), "no"),
    ),
    "the finer one bends more": (
        *("edge", moved, ("as_printed_2584", 0.0, 5.0, 11), (edge_claims.finer_is_better, ())),
        "in part",
    ),
    "leans on one grid": (
        *("edge_grids", on_one_grid, (0.0, 4.0, 2), (edge_claims.mean_angle, ()), "in part"),
    ),
    "ends 2.1 mm off the middle on one grid": (
        *("edge_grids", on_one_grid, (0.0, 2.1), MIDDLE, "in part"),
    ),
    "ends 1.9 mm off the middle on one grid": (
        *("edge_grids", on_one_grid, (0.0, 1.9), MIDDLE, "yes"),
    ),
    "ends off the middle on all grids": ("edge_grids", on_all_grids, (0.0, 2.1), MIDDLE, "no"),
    "the best ends 0.11 mm off": ("edge", moved, ("best", 0.0, 0.11), STRAIGHT, "no"),
    "the best does not come across": ("edge", ended, ("best", "stopped"), STRAIGHT, "no"),
    "domain scatters more than the tip": (
        *("edge", turned, ("as_printed_2584", 9.0)),
        *((edge_claims.tip_against_domain, ()), "in part"),
    ),
    "resets end the run": (
        *("edge", lost, ("reset_790",), (edge_claims.whole_loop, ()), "in part"),
    ),
    "G 1.1 % high": ("edge", scaled, ("t6", "G", 1.011), (edge_claims.fixed_grips, ()), "no"),
    "G 0.9 % low": ("edge", scaled, ("t6", "G", 0.991), (edge_claims.fixed_grips, ()), "yes"),
    "0.6 % of the work is lost": (
        *("edge", scaled, ("crack_control", "external_work", 1.006)),
        *((edge_claims.snap_back, ()), "no"),
    ),
    "another load": (
        *("shear", scaled, ("best", "J", 1.02), (shear_claims.unit_of_stress, ()), "no"),
    ),
    "no smaller triangles at the tip": (
        *("shear", scaled, ("as_printed", "tip_size", 2.0), (shear_claims.points, ()), "in part"),
    ),
    "below the reference by more than the bar": (
        *("shear", moved, ("best", 0, -1.05 * SHEAR), SHEARED, "no"),
    ),
    "below the reference by less": ("shear", moved, ("best", 0, -0.95 * SHEAR), SHEARED, "yes"),
    "another run is off": ("shear", moved, ("as_printed", 0, -1.05 * SHEAR), SHEARED, "yes"),
    "off FEM": ("shear", moved, ("as_printed", 0, -1.5), FEM, "in part"),
    "off FEM on all other grids": ("shear_grids", on_all_grids, (0, -1.5), FEM, "in part"),
    "does not flatten on one grid": ("shear_grids", on_one_grid, (0, -1.0, 16), TURNS, "in part"),
    "another toughness": (
        *("holes", scaled, ("as_printed", "fracture_energy", 2.0)),
        *((holes_claims.set_up, ()), "in part"),
    ),
    "stands still behind its start": (
        *("holes", scaled, ("as_printed", "tip_x", 0.0), (holes_claims.attracted, ()), "in part"),
    ),
    "above the points by more than is seen": (
        *("holes", moved, ("as_printed", 0, 1.05 * SEEN), BESIDE, "in part"),
    ),
    "above the points by more than the bar": (
        *("holes", moved, ("best", 0, 1.05 * HOLES), BEST, "in part"),
    ),
    "above the points by less": ("holes", moved, ("best", 0, 0.95 * HOLES), BEST, "yes"),
    "meets the other crack": ("holes", ended, ("best", "arrived_crack"), BEST, "in part"),
    "off FEM on one grid": ("holes_grids", on_one_grid, (0, 1.05 * SEEN), BESIDE, "in part"),
    "another path in stiffer stuff": (
        *("holes", moved, ("stiff", 0, 2e-6), (holes_claims.holes_conditions, ("Young",)), "no"),
    ),
    "enters the near hole elsewhere": (
        *("holes", moved, ("rollers", 0.4), (holes_claims.holes_conditions, ("sideways",)), "no"),
    ),
    "driving force falls below g_c": (
        *("holes", scaled, ("best", "cf_norm", 0.1)),
        *((holes_claims.holes_conditions, ("to the end",)), "no"),
    ),
    "J is 1 % low": (
        *("holes", scaled, ("cf", "J", 0.99), (holes_claims.holes_energy, ("fixed",)), "no"),
    ),
    "work is lost before the arrival": (
        *("holes", scaled, ("crack_control", "external_work", 1.03)),
        *((holes_claims.holes_energy, ("equilibrium path",)), "no"),
    ),
    "another force": (
        *("beam", scaled, ("as_printed_15_5", "reaction_y", 0.9), (beam_claims.set_up, ()), "no"),
    ),
    "other points": (
        *("beam", scaled, ("as_printed_10_6", "n_points", 1.1), (beam_claims.points, ())),
        "in part",
    ),
    "beside the reference by more than the bar": (
        *("beam", moved, ("as_printed_15_5", -1.2 * BEAM), OF_BEAM, "in part"),
    ),
    "beside the reference by less": (
        *("beam", moved, ("as_printed_15_5", -0.9 * BEAM), OF_BEAM, "yes"),
    ),
    "sets out 0.6 deg steeper": (
        *("beam", moved, ("as_printed_15_5", -0.0212, 0, 2), OF_BEAM, "in part"),
    ),
    "off the literature": (
        *("beam", moved, ("as_printed_10_4", 2.0 * BEAM), (beam_claims.all_paths, ()), "in part"),
    ),
    "comes to the left of the middle hole": ("beam_grids", on_all_grids, (-20.0,), CASE_1, "no"),
    "keeps away on one grid": ("beam_grids", on_one_grid, (20.0,), CASE_1, "in part"),
    "is arrested on one grid alone": ("beam_grids", on_one_grid, (5.0,), CASE_2, "in part"),
    "is not arrested": ("beam_grids", on_all_grids, (5.0,), CASE_2, "no"),
    "the finest passes 0.7 mm further off": (
        *("beam", moved, ("first_3", -0.5, 0.5), (beam_claims.near_miss, ()), "no"),
    ),
    "a coarse one is caught": (
        *("beam", moved, ("first_12", 2.5, -2.5), (beam_claims.near_miss, ()), "no"),
    ),
}


@pytest.mark.parametrize("name", ALTERED)
def test_claims_follow_the_data(evidence, name):
    study, change, how, (claim, words), expected = ALTERED[name]
    altered = change(getattr(evidence, study), *how)
    assert held(replace(evidence, **{study: altered}), claim, words) == [expected]


def test_a_path_that_ends_before_the_points_has_not_held(evidence):
    shear, holes = (getattr(evidence, study).isel(step=slice(0, 3)) for study in ("shear", "holes"))
    short = replace(evidence, shear=shear, holes=holes)
    assert set(held(short, shear_claims.shear_path, ())) == {"no"}
    assert "yes" not in held(short, holes_claims.best_paths, ())
    assert "yes" not in held(short, holes_claims.beside_fem, ())


def test_the_last_ligament_must_break_by_itself(evidence):
    """If it released less than g_c needs, the loss at the arrival would not be a jump."""
    slow = xr.where(evidence.holes.variant == "crack_control", 0.02, evidence.holes.load_factor)
    calm = evidence.holes.assign(load_factor=slow)
    calm = scaled(calm, "crack_control", "strain_energy", xr.where(calm.step < 6, 1.0, 10.0 / 27.0))
    assert held(replace(evidence, holes=calm), holes_claims.holes_energy, ("equilibrium",)) == [
        "no"
    ]


def test_released_energy_ends_where_a_tip_has_no_j():
    run = steps(made_up.holes(), "cf")
    new = np.hypot(*np.diff(np.stack([run.tip_x, run.tip_y]), axis=1)).sum(axis=1)
    exact = np.append(0.0, np.cumsum(300.0 * new))
    np.testing.assert_allclose(energy_released(run), exact, rtol=1e-12)
    gone = run.assign(J=run.J.where((run.step < 5) | (run.tip == "right_crack")))
    np.testing.assert_array_equal(np.isfinite(energy_released(gone)), run.step < 5)


def test_table(evidence, tmp_path):
    names = claims.DATASETS
    for name in names:
        getattr(evidence, name).to_netcdf(tmp_path / f"{name}.nc")
    out = {name: tmp_path / name for name in ("table", "markdown", "page")}
    claims.write_claims({name: tmp_path / f"{name}.nc" for name in names}, **out)
    rows = list(csv.DictReader(out["table"].open(encoding="utf-8")))
    assert [row["claim"] for row in rows] == [one.claim for one in claims.decide(evidence)]
    for row in rows:
        assert row["claim"] in out["markdown"].read_text(encoding="utf-8")
    # Two tables, with a head each.
    assert out["page"].read_text(encoding="utf-8").count("<tr") == len(rows) + 2
