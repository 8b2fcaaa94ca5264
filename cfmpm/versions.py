"""Versions of what results depend on, found without importing it."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from cfmpm._version import __version__

# Packages of which another version may give other bits. Which of the solvers are installed decides
# which one is chosen.
DECIDING = (
    *("gmsh", "llvmlite", "numba", "numpy", "scipy", "shapely"),
    *("kvxopt", "rslab", "pyamg"),
)


@cache
def versions() -> dict[str, str]:
    """Versions by package, as far as they are installed, and that of Python."""
    found = {"python": platform.python_version(), "cfmpm": __version__}
    for name in (*DECIDING, "xarray", "netCDF4"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
