"""Random invalid input: a tenth of the cases of the script `tests/hostile.py`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

# How many, in how many processes: each begins anew with its memory.
CASES = {"scenes": 1000, "grids": 100, "studies": 100, "results": 100}


@pytest.mark.slow
@pytest.mark.parametrize("kind", CASES)
def test_no_traceback_no_hang_no_crash(kind: str) -> None:
    script = Path(__file__).with_name("hostile.py")
    done = subprocess.run(
        [sys.executable, str(script), kind, str(CASES[kind])],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
