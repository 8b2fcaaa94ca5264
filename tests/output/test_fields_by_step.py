"""Fields by step: selection, contents, removal of old files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from growing_scene import growing
from ugrid_rules import broken_rules

from cfmpm.output.fields import build_fields
from cfmpm.output.fields_by_step import INDEX, FieldsByStep, fields_of_last_step, list_fields
from cfmpm.output.variables import LOAD_POWER
from cfmpm.scene import scene_from_dict
from cfmpm.simulation import run
from cfmpm.state import Result


@pytest.fixture(scope="module", params=["T3", "T6", "paper"])
def kept(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Result]:
    """A run of five states with fields of every second one, and of the end."""
    folder = tmp_path_factory.mktemp("fields")
    paper = {"transfer": "paper"} if request.param == "paper" else {}
    scene = growing("T3" if paper else request.param, **paper)
    result = run(scene_from_dict(scene), observe=FieldsByStep(folder, 2).observe)
    return folder, result


def test_the_table_lists_the_files(kept: tuple[Path, Result]) -> None:
    folder, result = kept
    with xr.open_dataset(folder / INDEX) as index:
        assert index["step"].values.tolist() == [1, 3, 5]
        chosen = result.history.isel(step=index["step"].values - 1)
        np.testing.assert_array_equal(index["load_factor"], chosen["load_factor"])
        np.testing.assert_allclose(index["crack_length"], chosen["crack_length"][:, 0], rtol=1e-12)
        files = [folder / name for name in index["file"].values]
    assert list_fields(folder) == files
    assert sorted(folder.iterdir()) == sorted([*files, folder / INDEX])


@pytest.mark.slow
def test_the_last_state_is_kept_too_and_once(tmp_path: Path) -> None:
    scene = scene_from_dict(growing())
    for every, steps in ((3, [1, 4, 5]), (2, [1, 3, 5])):
        folder = tmp_path / str(every)
        fields = FieldsByStep(folder, every)
        run(scene, observe=fields.observe)
        fields.finish()
        fields.finish()
        with xr.open_dataset(folder / INDEX) as index:
            assert index["step"].values.tolist() == steps
        assert [path.name for path in list_fields(folder)] == [f"fields_{n:04}.nc" for n in steps]


def test_the_fields_of_the_last_state_are_found(kept: tuple[Path, Result]) -> None:
    folder, result = kept
    last = fields_of_last_step(folder, result.history)
    assert last is not None
    assert last["time"].values.tolist() == [5.0]
    # Cracks that have severed the body make a step of their own, without a state.
    severed = result.history.reindex(step=np.arange(1, 7))
    assert fields_of_last_step(folder, severed) is not None
    longer = severed.assign(n_unknowns=severed["n_unknowns"].fillna(1.0))
    assert fields_of_last_step(folder, longer) is None


def test_each_file_is_sound(kept: tuple[Path, Result]) -> None:
    folder, result = kept
    for path in list_fields(folder):
        assert broken_rules(path) == []
        with xr.open_dataset(path) as fields:
            assert fields.attrs["config_hash"] == result.history.attrs["config_hash"]


def test_fields_are_those_at_the_load_of_the_step(kept: tuple[Path, Result]) -> None:
    """Reactions and energy of the fields are those of the history, at the same load factor."""
    folder, result = kept
    for path in list_fields(folder):
        with xr.open_dataset(path, mask_and_scale=False) as fields:
            now = result.history.sel(step=int(fields["time"].values[0]))
            assert float(fields["load_factor"].values[0]) == float(now["load_factor"])
            last = fields["crack_node"].size - 1
            end = [float(fields[f"crack_{axis}"][last]) for axis in "xy"]
            assert end == [float(now["tip_x"][0]), float(now["tip_y"][0])]
            energy = float((fields["point_volume"] * fields["point_energy_density"]).sum())
            # The mean over the pieces of a point loses none of its energy.
            assert energy == pytest.approx(float(now["strain_energy"]), rel=1e-9)
            top = fields["node_y"].values > 20 - 1e-9
            u = fields["u_y"].values[0, top]
            motion = float(now["displacement_y"].sel(boundary="top"))
            assert u.min() - 1e-12 <= motion <= u.max() + 1e-12


def test_the_last_fields_grow_with_the_load_factor(kept: tuple[Path, Result]) -> None:
    folder, result = kept
    last, fields = xr.load_dataset(list_fields(folder)[-1]), build_fields(result)
    for name in ("u_x", "sigma_yy", "point_sigma_xy", "cf_x", "energy_density"):
        np.testing.assert_array_equal(last[name], fields[name])
    factor = float(fields["load_factor"].values[0])
    assert factor != 1.0
    np.testing.assert_array_equal(fields["u_y"].values[0], factor * result.displacement[:, 1])
    force = factor ** LOAD_POWER["cf_x"] * result.configurational_force[:, 0]
    np.testing.assert_allclose(fields["cf_x"].values[0], force, rtol=1e-14)


def test_stress_on_the_faces_is_in_balance_with_the_load() -> None:
    """Also after growth: the stress on a section across the body has the force of its top."""
    result = run(scene_from_dict(growing("T6")))
    fields = build_fields(result)
    faces = fields["face_nodes"].values
    y = fields["node_y"].values[faces]
    x = fields["node_x"].values[faces]
    area = 0.5 * np.abs(
        (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    )
    mean = float((fields["sigma_yy"].values[0] * area).sum() / area.sum())
    # The mean stress of a body is given by the tractions on its boundary.
    assert mean == pytest.approx(10.0 * float(fields["load_factor"].values[0]), rel=1e-9)


@pytest.mark.parametrize("every", [1, None])
def test_a_new_run_takes_the_old_files_away(tmp_path: Path, every: int | None) -> None:
    run(scene_from_dict(growing()), observe=FieldsByStep(tmp_path, 1).observe)
    assert len(list_fields(tmp_path)) == 5
    (tmp_path / "fields_mine.nc").write_text("kept")
    FieldsByStep(tmp_path, every)
    assert [path.name for path in tmp_path.iterdir()] == ["fields_mine.nc"]


@pytest.mark.slow
def test_a_resumed_run_keeps_what_was_done(tmp_path: Path) -> None:
    run(scene_from_dict(growing()), observe=FieldsByStep(tmp_path, 1).observe)
    before = xr.load_dataset(tmp_path / INDEX)
    again = FieldsByStep(tmp_path, 1, done=2)
    listed = xr.load_dataset(tmp_path / INDEX)
    xr.testing.assert_identical(listed, before.isel(step=slice(2)))
    assert {path.name for path in tmp_path.iterdir()} == {INDEX, *listed["file"].values}

    def observe(state: Any, record: Any) -> None:
        if len(record.steps) > 2:
            again.observe(state, record)

    run(scene_from_dict(growing()), observe=observe)
    xr.testing.assert_identical(xr.load_dataset(tmp_path / INDEX).drop_attrs(), before.drop_attrs())
