"""The command line: run, resume, check, plot, export, study, schema.

Large packages (numba, gmsh, xarray, matplotlib) are imported within the commands, so that
``cfmpm --help`` is fast and a run without figures does not load matplotlib.
"""

from __future__ import annotations

# The order of the commands in the help.
from cfmpm.cli import looking, running, studying  # noqa: F401
from cfmpm.cli.app import app


def main() -> None:
    """Run the command line."""
    app(prog_name="cfmpm")
