"""A linear solver that another package adds: LAPACK's Cholesky of the whole matrix."""

from __future__ import annotations

from pathlib import Path

import pytest
from foreign_package import install, run

ENTRIES = """
from cfmpm.registry.solvers import SolverEntry

DENSE = SolverEntry("foreign.dense:Dense")
MISSING = SolverEntry("foreign.missing:Missing", package="not_installed")
"""
DENSE = """
import numpy as np
from scipy.linalg import cho_factor, cho_solve

from cfmpm.linear.engine import NotPositiveDefiniteError


class Dense:
    direct = True
    solved = 0

    def __init__(self, K, modes):
        pass

    def factor(self, K):
        try:
            self._factor = cho_factor(K.toarray())
        except np.linalg.LinAlgError as error:
            raise NotPositiveDefiniteError(str(error)) from error

    def solve(self, b, tolerance=0.0):
        Dense.solved += 1
        return cho_solve(self._factor, b), ()
"""
CODE = """
import numpy as np

import cfmpm
from cfmpm.linear.solvers import select
from foreign.dense import Dense

plate = {
    "name": "plate",
    "family": {
        "kind": "single_edge", "width": 50, "height": 100, "crack_length": 20, "traction": 10
    },
    "material": {"E": 210e3, "nu": 0.3},
    "mesh": {"size": 10},
}


def solve(solver):
    return cfmpm.run(cfmpm.scene_from_dict(plate | {"solver": solver})).history


ours, known = solve("dense"), solve("superlu")
assert Dense.solved > 0
assert ours.attrs["solver"] == "dense"
np.testing.assert_allclose(ours.K_I, known.K_I, rtol=1e-10)

try:
    solve("missing")
except cfmpm.SolveError as error:
    assert "pip install not_installed" in str(error), error
else:
    raise AssertionError("a package that is not installed")
assert select(10**7).name not in ("dense", "missing")
"""


@pytest.mark.slow
def test_dense(tmp_path: Path) -> None:
    files = {"foreign/__init__.py": ENTRIES, "foreign/dense.py": DENSE}
    points = "[cfmpm.solvers]\ndense = foreign:DENSE\nmissing = foreign:MISSING\n"
    install(tmp_path, files, points)
    run(tmp_path, CODE)
