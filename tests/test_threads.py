from __future__ import annotations

import pytest
import scipy.linalg  # noqa: F401
from threadpoolctl import threadpool_info, threadpool_limits

import cfmpm
from cfmpm.scene.reading import scene_from_dict
from cfmpm.threads import one_blas_thread


def threads():
    return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]


def test_one_thread_inside_and_what_was_before_outside():
    with threadpool_limits(2, "blas"):
        before = threads()
        with one_blas_thread():
            assert set(threads()) == {1}
            with one_blas_thread():
                pass
            assert set(threads()) == {1}
        assert threads() == before
        with pytest.raises(ValueError, match="failed"), one_blas_thread():
            raise ValueError("failed")
        assert threads() == before


def test_a_run_has_one_thread_from_its_grid_to_its_last_step():
    plate = {"kind": "single_edge", "width": 5, "height": 8, "crack_length": 2, "traction": 1}
    scene = {"name": "plate", "family": plate, "material": {"E": 1e3, "nu": 0.3}}
    seen = []
    with threadpool_limits(2, "blas"):
        cfmpm.run(
            scene_from_dict({**scene, "mesh": {"size": 2}}),
            announce=lambda phase: seen.append((phase, *threads())),
            observe=lambda state, record: seen.append(("observed", *threads())),
        )
    assert {phase for phase, *_ in seen} >= {
        "grid",
        "points",
        "equilibrium",
        "fracture",
        "observed",
    }
    assert {number for _, *numbers in seen for number in numbers} == {1}
