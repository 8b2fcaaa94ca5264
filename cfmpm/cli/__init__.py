"""The command line: run, resume, check, plot, export, study, schema.

All that is heavy (numba, gmsh, xarray, matplotlib) is imported within the commands, so that
``cfmpm --help`` answers at once and a run without pictures never loads matplotlib.
"""

from __future__ import annotations

# The order of the commands in the help.
from cfmpm.cli import looking, running, studying  # noqa: F401
from cfmpm.cli.app import app


def main() -> None:
    """Run the command line."""
    app(prog_name="cfmpm")
