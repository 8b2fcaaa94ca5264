"""Claims of sections 5.2 to 5.5 follow the data: values beyond a bound fail."""

from __future__ import annotations

import csv
from dataclasses import replace

import growth_data as made_up
import numpy as np
import pytest
import xarray as xr
from page_parts import program_words

from workflows.growth import beam_claims, claims, edge_claims, holes_claims
from workflows.growth.beam_claims import BEAM
from workflows.growth.datasets import energy_released, steps
from workflows.growth.edge_claims import SHEAR
from workflows.growth.evidence import Evidence
from workflows.growth.holes_claims import HOLES
from workflows.reporting.claim_table import cells


@pytest.fixture(scope="module")
def evidence():
    return Evidence(made_up.edge(), made_up.shear(), made_up.holes(), made_up.beam())


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
    assert [one.claim for one in decided if one.held != "yes"] == []
    assert len({one.claim for one in decided}) == len(decided) > 25


def test_claims_are_told_in_words_of_the_field(evidence):
    lost = replace(
        evidence,
        holes=ended(moved(evidence.holes, "cf", 0, 2 * HOLES), "paper", "arrived_crack"),
        beam=ended(evidence.beam, "cf_10_4", "growing"),
    )
    for one in (*claims.decide(evidence), *claims.decide(lost)):
        assert one.sentence.endswith(".")
        assert program_words(" ".join([*cells(one), one.sentence])) == []


CF_790 = edge_claims.straight, ("CF direction, 790",)
SHEARED = edge_claims.shear_path, ("CF direction, first order (paper)",)
TWO_HOLES = holes_claims.holes_path, ("CF direction (paper)",)
OF_BEAM = beam_claims.beam_paths, ("1.5 in", "CF direction")


def without_arrest(beam):
    """No crack arrives at the bottom hole."""
    return moved(moved(beam, "cf_10_6", 5.0), "hoop_10_6", 5.0)


# Study, what is done to it, the claim, what it is then.
ALTERED = {
    "bends at the end by 2.5 mm": ("edge", moved, ("cf_790", 0, 2.5, 21), CF_790, "no"),
    "ends 2.1 mm off the middle": ("edge", moved, ("cf_790", 0, 2.1), CF_790, "in part"),
    "ends 1.9 mm off the middle": ("edge", moved, ("cf_790", 0, 1.9), CF_790, "yes"),
    "does not come across": ("edge", ended, ("cf_790", "stopped"), CF_790, "in part"),
    "domain scatters more than the tip": (
        *("edge", scaled, ("cf_2584", "cf_tip_y", 0.0), (edge_claims.tip_against_domain, ()), "no"),
    ),
    "G 1.1 % high": ("edge", scaled, ("t6", "G", 1.011), (edge_claims.fixed_grips, ()), "no"),
    "G 0.9 % low": ("edge", scaled, ("t6", "G", 0.991), (edge_claims.fixed_grips, ()), "yes"),
    "0.6 % of the work is lost": (
        *(
            "edge",
            scaled,
            ("crack_control", "external_work", 1.006),
            (edge_claims.snap_back, ()),
            "no",
        ),
    ),
    "below the reference by more than the bar": (
        *("shear", moved, ("cf", 0, -1.05 * SHEAR), SHEARED, "no"),
    ),
    "below the reference by less": ("shear", moved, ("cf", 0, -0.95 * SHEAR), SHEARED, "yes"),
    "another run is off": ("shear", moved, ("paper", 0, -1.05 * SHEAR), SHEARED, "yes"),
    "above the points by more than the bar": (
        *("holes", moved, ("cf", 0, 1.05 * HOLES), TWO_HOLES, "in part"),
    ),
    "above the points by less": ("holes", moved, ("cf", 0, 0.95 * HOLES), TWO_HOLES, "yes"),
    "meets the other crack": ("holes", ended, ("cf", "arrived_crack"), TWO_HOLES, "in part"),
    "another path in stiffer stuff": (
        *("holes", moved, ("stiff", 0, 2e-6), (holes_claims.holes_conditions, ("Young",)), "no"),
    ),
    "enters the near hole elsewhere": (
        *("holes", moved, ("rollers", 0.4), (holes_claims.holes_conditions, ("sideways",)), "no"),
    ),
    "driving force falls below g_c": (
        *(
            "holes",
            scaled,
            ("hoop", "cf_norm", 0.1),
            (holes_claims.holes_conditions, ("to the end",)),
        ),
        "no",
    ),
    "J is 1 % low": (
        "holes",
        scaled,
        ("cf", "J", 0.99),
        (holes_claims.holes_energy, ("fixed",)),
        "no",
    ),
    "work is lost before the arrival": (
        *("holes", scaled, ("crack_control", "external_work", 1.03)),
        *((holes_claims.holes_energy, ("equilibrium path",)), "no"),
    ),
    "beside the reference by more than the bar": (
        *("beam", moved, ("cf_15_5", -1.2 * BEAM), OF_BEAM, "in part"),
    ),
    "beside the reference by less": ("beam", moved, ("cf_15_5", -0.9 * BEAM), OF_BEAM, "yes"),
    "sets out 0.6 deg steeper": ("beam", moved, ("cf_15_5", -0.0212, 0, 2), OF_BEAM, "in part"),
    "comes to the left of the middle hole": (
        *("beam", moved, ("cf_15_5", -20.0), (beam_claims.beam_cases, ("Case I,",)), "no"),
    ),
    "keeps away from the holes": (
        *("beam", moved, ("cf_15_5", 20.0), (beam_claims.beam_cases, ("Case I,",)), "in part"),
    ),
    "is not arrested": (
        *("beam", without_arrest, (), (beam_claims.beam_cases, ("Case II",)), "no"),
    ),
    "the finest passes 0.7 mm further off": (
        *("beam", moved, ("first_3", -0.5, 0.5), (beam_claims.near_miss, ()), "no"),
    ),
    "a coarse one is caught": (
        "beam",
        moved,
        ("first_12", 2.5, -2.5),
        (beam_claims.near_miss, ()),
        "no",
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
    assert set(held(short, edge_claims.shear_path, ())) == {"no"}
    assert "yes" not in held(short, holes_claims.holes_path, ())


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
    names = ("edge", "shear", "holes", "beam")
    for name in names:
        getattr(evidence, name).to_netcdf(tmp_path / f"{name}.nc")
    out = {name: tmp_path / name for name in ("table", "markdown", "page")}
    claims.write_claims({name: tmp_path / f"{name}.nc" for name in names}, **out)
    rows = list(csv.DictReader(out["table"].open(encoding="utf-8")))
    assert [row["claim"] for row in rows] == [one.claim for one in claims.decide(evidence)]
    for row in rows:
        assert row["claim"] in out["markdown"].read_text(encoding="utf-8")
    assert out["page"].read_text(encoding="utf-8").count("<tr") == len(rows) + 1
