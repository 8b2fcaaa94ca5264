from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec

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


LATER = """
from threadpoolctl import threadpool_info, threadpool_limits
from cfmpm.threads import one_blas_thread
with one_blas_thread():
    from cfmpm.linear import cholmod
    cholmod._library()
with threadpool_limits(2, "blas"), one_blas_thread():
    blas = [one for one in threadpool_info() if one["user_api"] == "blas"]
    print({one["num_threads"] for one in blas}, any("kvxopt" in one["filepath"] for one in blas))
from cfmpm.threads import _libraries
print(any("kvxopt" in one.filepath for one in _libraries().lib_controllers))
"""


def test_a_blas_that_is_loaded_within_a_run_is_limited_in_the_next():
    if not find_spec("kvxopt"):
        pytest.skip("kvxopt is not installed")
    command = [sys.executable, "-c", LATER]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["{1}", "True", "True"]


def test_a_run_has_one_thread_from_its_grid_to_its_last_step():
    plate = {"kind": "single_edge", "width": 5, "height": 8, "crack_length": 2, "traction": 1}
    scene = {"name": "plate", "family": plate, "material": {"E": 1e3, "nu": 0.3}}
    seen = []
    # The first run loads the solver's BLAS, unless another test has.
    cfmpm.run(scene_from_dict({**scene, "mesh": {"size": 2}}))
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
