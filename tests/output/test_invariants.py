"""What holds in every step of a history, and what is said where it does not."""

from __future__ import annotations

import pytest
import xarray as xr
from warned import plate, solved

from cfmpm.output.invariants import violations


@pytest.fixture(scope="module")
def history() -> xr.Dataset:
    return solved(plate(load_steps=3, mesh={"size": 10, "grading": "uniform"}))


def changed(history: xr.Dataset, name: str, step: int, value: float) -> xr.Dataset:
    found = history.copy(deep=True)
    found[name][step] = value
    return found


def test_nothing_is_said_of_a_sound_history(history: xr.Dataset) -> None:
    assert list(violations(history)) == []


def test_forces_out_of_balance(history: xr.Dataset) -> None:
    """But not in a body that has come apart, which carries round-off alone."""
    missed = changed(history, "force_imbalance", 2, 3e-7)
    (text,) = violations(missed)
    assert text.startswith("in step 3 loads and reactions are out of balance by up to 3.0e-07 of")
    largest = float(history["strain_energy"].max())
    assert list(violations(changed(missed, "strain_energy", 2, 1e-19 * largest))) == []
    assert list(violations(changed(missed, "strain_energy", 2, 1e-17 * largest))) == [text]


def test_energy_from_nothing(history: xr.Dataset) -> None:
    stored = float(history["strain_energy"][2])
    assert list(violations(changed(history, "released_energy", 2, -5e-4 * stored))) == []
    (text,) = violations(changed(history, "released_energy", 2, -5e-3 * stored))
    assert text.startswith("in step 3 the last segments have not set energy free but taken up to")
