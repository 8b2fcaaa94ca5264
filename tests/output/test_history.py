from __future__ import annotations

import errno
import json
import os

import numpy as np
import pytest
import xarray as xr
from growing_scene import growing

import cfmpm
from cfmpm.ending import RUN_STATUS, Ending
from cfmpm.output import files, variables
from cfmpm.output.history import StepRecord, build_history
from cfmpm.scene.growth import Growth
from cfmpm.scene.reading import scene_from_dict
from cfmpm.simulation import run

ENDING = Ending("solved", "solved: all of it")


@pytest.fixture(scope="module")
def history():
    scene = scene_from_dict(
        {
            "name": "plate",
            "family": {
                "kind": "centre_crack",
                "width": 50,
                "height": 80,
                "crack_length": 12,
                "traction": 10,
            },
            "material": {"E": 1e4, "nu": 0.3},
            "mesh": {"element": "T3", "size": 8, "grading": {"tip_size": 1, "growth": 0.5}},
            "fracture": {"radii": [1.0, 2.0]},
        }
    )
    return cfmpm.run(scene).history


def test_round_trip_through_netcdf(history, tmp_path):
    path = tmp_path / "deep" / "history.nc"
    files.write_dataset(history, path)
    with xr.open_dataset(path) as read:
        for name in history.variables:
            np.testing.assert_array_equal(read[name].values, history[name].values)
            assert read[name].attrs["long_name"] == history[name].attrs["long_name"]
    assert [p.name for p in path.parent.iterdir()] == ["history.nc"]


@pytest.mark.parametrize("entries", [[], ["one"], ["one", "two µ"]], ids=len)
def test_attributes_keep_their_kind_in_the_file(history, tmp_path, entries):
    scene = scene_from_dict(json.loads(history.attrs["config"]))
    notes = {"warnings": entries, "domain_clearance": [0.1], "solver": "amg", "iterations": 3}
    made = build_history(scene, [], ENDING, tips=[], radii=[], boundaries=[], notes=notes)
    files.write_dataset(made, tmp_path / "history.nc")
    with xr.open_dataset(tmp_path / "history.nc") as read:
        assert {k: type(v)(read.attrs[k]) for k, v in made.attrs.items()} == made.attrs
        assert {k for k, v in made.attrs.items() if isinstance(v, str)} == {
            k for k, v in read.attrs.items() if isinstance(v, str)
        }
        assert json.loads(read.attrs["warnings"]) == entries
        assert json.loads(read.attrs["domain_clearance"]) == [0.1]


def test_a_run_states_its_threads_and_keeps_lists_as_text(history):
    assert history.attrs["threads"] >= 1
    for name in ("warnings", "left_out", "domain_clearance", "domain_cut_back"):
        assert isinstance(json.loads(history.attrs[name]), list)
    assert not any(isinstance(value, list) for value in history.attrs.values())


def test_a_file_gets_the_permissions_of_any_other(history, tmp_path):
    before = os.umask(0o027)
    try:
        files.write_dataset(history, tmp_path / "history.nc")
    finally:
        os.umask(before)
    assert (tmp_path / "history.nc").stat().st_mode & 0o777 == 0o640


def test_the_effective_configuration_is_inside(history, tmp_path):
    path = tmp_path / "history.nc"
    files.write_dataset(history, path)
    with xr.open_dataset(path) as read:
        again = scene_from_dict(json.loads(read.attrs["config"]))
        assert read.attrs["config_hash"] == cfmpm.scene.config_hash(again)
        assert json.loads(read.attrs["versions"])["cfmpm"] == cfmpm.__version__
    second = cfmpm.run(again).history
    xr.testing.assert_identical(
        history.drop_vars("wall_time").drop_attrs(), second.drop_vars("wall_time").drop_attrs()
    )


def test_a_failed_write_leaves_the_old_file_and_no_other(history, tmp_path, monkeypatch):
    path = tmp_path / "history.nc"
    files.write_dataset(history, path)
    before = path.read_bytes()

    def broken(self, path, **_):
        path.write_bytes(before[: len(before) // 2])
        raise OSError(errno.ENOSPC, "disk full")

    monkeypatch.setattr(xr.Dataset, "to_netcdf", broken)
    with pytest.raises(OSError, match=r"disk full.*history\.nc"):
        files.write_dataset(history, path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["history.nc"]


def test_time_stamps_follow_source_date_epoch(history, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    scene = scene_from_dict(json.loads(history.attrs["config"]))
    empty = build_history(scene, [], ENDING, tips=[], radii=[], boundaries=[], notes={})
    assert empty.attrs["date_created"] == "1970-01-01T00:00:00Z"


def test_what_was_not_computed_is_nan(history):
    assert np.isnan(history.critical_load_factor).all()
    assert history.tip_status.dtype == np.int8


def test_how_a_run_ended_is_a_flag_and_an_attribute(history):
    words = history.run_status.attrs["flag_meanings"].split()
    assert words == list(RUN_STATUS)
    assert words[int(history.run_status)] == history.attrs["run_status"] == "solved"


def test_spread_is_the_range_over_radii(history):
    for name in variables.SPREAD:
        expected = np.ptp(history[f"{name}_radius"].values, axis=2)
        np.testing.assert_array_equal(history[f"{name}_spread"].values, expected)


def test_angles_that_go_past_half_a_turn_are_not_far_apart(history):
    """Angles of a force that points against the crack, near +-180 degrees."""
    scene = scene_from_dict(json.loads(history.attrs["config"]))
    step = StepRecord(1.0, {"cf_angle_radius": np.array([[178.0, -178.0, 176.0]])}, {})
    built = build_history(
        scene, [step], ENDING, tips=["tip"], radii=[1.0, 2.0, 3.0], boundaries=[], notes={}
    )
    assert float(built.cf_angle_spread[0, 0]) == 6.0


@pytest.mark.parametrize(
    ("name", "values", "spread"),
    [
        ("cf_angle", [10.0, 110.0, 200.0], 190.0),
        ("cf_angle", [-179.0, 179.0, -175.0], 6.0),
        ("K_I", [100.0, 400.0, 800.0], 700.0),
        ("T_stress", [-300.0, 300.0, 0.0], 600.0),
    ],
)
def test_whole_turns_are_taken_off_angles_alone(history, name, values, spread):
    """Only multiples of 360 degrees are subtracted, and from angles only."""
    scene = scene_from_dict(json.loads(history.attrs["config"]))
    step = StepRecord(1.0, {f"{name}_radius": np.array([values])}, {})
    built = build_history(
        scene, [step], ENDING, tips=["tip"], radii=[1.0, 2.0, 3.0], boundaries=[], notes={}
    )
    assert float(built[f"{name}_spread"][0, 0]) == pytest.approx(spread)


def test_one_radius_has_no_spread(history):
    scene = scene_from_dict(json.loads(history.attrs["config"]))
    step = StepRecord(1.0, {"J_radius": np.array([[2.0]])}, {})
    built = build_history(scene, [step], ENDING, tips=["a"], radii=[1.0], boundaries=[], notes={})
    assert np.isnan(built.J_spread[0, 0])


def test_growth_that_the_default_number_of_increments_ends_is_warned_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It comes first, since the user did not set this limit; a limit in the scene gives none."""
    scene = scene_from_dict(growing() | {"growth": {"control": "crack", "increments": 2}})
    assert not any("growth.increments" in text for text in json.loads(run(scene).history.warnings))
    monkeypatch.setattr(Growth.model_fields["increments"], "default", 2)
    first, *_ = json.loads(run(scene).history.warnings)
    assert first.startswith("the run ended after 2 increments, the default of growth.increments")
