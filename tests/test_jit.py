from __future__ import annotations

import os
import subprocess
import sys


def test_old_caches_are_removed_when_a_new_one_is_made(tmp_path):
    for age in range(5):
        folder = tmp_path / f"kernels-{age}"
        folder.mkdir()
        (folder / "index.nbi").touch()
        os.utime(folder, (1000 - age, 1000 - age))
    (tmp_path / "other").mkdir()
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    program = "from cfmpm._jit import cache_folder; import cfmpm.kernels.basis;"
    program += "print(cache_folder().name)"
    for _ in range(2):
        made = subprocess.run(
            [sys.executable, "-c", program],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        left = {path.name for path in tmp_path.iterdir()}
        assert left == {made, "kernels-0", "kernels-1", "other"}
