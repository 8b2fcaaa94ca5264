"""The command line: run, resume, check, plot, export, study, schema.

Large packages (numba, gmsh, xarray, matplotlib) are imported within the commands, so that
``cfmpm --help`` is fast and a run without figures does not load matplotlib.
"""

from __future__ import annotations

import os
import sys

# The order of the commands in the help.
from cfmpm.cli import looking, running, studying  # noqa: F401
from cfmpm.cli.app import app


def main() -> None:
    """Run the command line."""
    _open_streams()
    app(prog_name="cfmpm")


def _open_streams() -> None:
    """Open the standard streams that are closed, as by ``2>&-`` or a daemon: to nothing.

    Otherwise the next file that is opened, such as the history, takes the place of stderr, and
    libraries write their messages into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # takes the lowest number
    sys.stdout = sys.stdout or open(os.devnull, "w")  # noqa: SIM115 - open to the end
    sys.stderr = sys.stderr or open(os.devnull, "w")  # noqa: SIM115
