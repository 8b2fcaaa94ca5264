"""Reading of netCDF files in a process of its own, which a damaged file may hang or break.

It is run as a script, and imports nothing of this package.
"""

from __future__ import annotations

import json
import pickle
import resource
import signal
import struct
import sys
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

MEGA = 2**20
# Values that a file may hold, at least and per byte of the file: parts that were never written
# take no space, and others may compress them.
LEAST_VALUES, VALUES_PER_BYTE = 64 * MEGA, 20
# Memory beyond those of the values and of the process as it has started [bytes].
MEMORY = 256 * MEGA


def serve() -> None:
    """Answer requests, one a line, until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    out = sys.stdout.buffer
    for line in sys.stdin:
        request = json.loads(line)
        try:
            _limit(request["seconds"], request["size"])
            answer = pickle.dumps((True, read(request["path"], request["size"])), protocol=5)
        except Exception as error:
            answer = pickle.dumps((False, _told(error)))
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        out.write(struct.pack("<Q", len(answer)) + answer)
        out.flush()


def read(path: str, size: int) -> dict[str, Any]:
    """Read the variables and attributes of a file as they are stored.

    Parameters
    ----------
    path : str
    size : int
        Of the file [bytes].

    Raises
    ------
    Exception
        Of any kind, where it cannot be read.
    """
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        if file.groups:
            raise ValueError("it has groups")
        values = sum(_bytes_of(variable) for variable in file.variables.values())
        if values > max(LEAST_VALUES, VALUES_PER_BYTE * size):
            raise ValueError(f"it says it holds {values / MEGA:.3g} MB in {size / MEGA:.2g} MB")
        return {
            "attributes": _attributes(file),
            "variables": {
                name: (variable.dimensions, np.asarray(variable[...]), _attributes(variable))
                for name, variable in file.variables.items()
            },
        }


def _bytes_of(variable: Any) -> int:
    if isinstance(variable.dtype, np.dtype):
        return int(variable.size) * int(variable.dtype.itemsize)
    if variable.dtype is str:
        return int(variable.size) * np.dtype(object).itemsize
    raise ValueError(f"{variable.name} is of an unknown type")


def _attributes(of: Any) -> dict[str, Any]:
    return {name: of.getncattr(name) for name in of.ncattrs()}


def _limit(seconds: float, size: int) -> None:
    """Let the system end this process where a request takes too much time or memory."""
    signal.setitimer(signal.ITIMER_PROF, seconds)  # SIGPROF ends a process
    try:
        pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
    except OSError:  # not Linux
        return
    most = pages * resource.getpagesize() + MEMORY + 3 * max(LEAST_VALUES, VALUES_PER_BYTE * size)
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    if hard == resource.RLIM_INFINITY or most <= hard:
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def _told(error: Exception) -> str:
    if isinstance(error, MemoryError):
        return "it takes too much memory"
    return str(getattr(error, "strerror", None) or error) or type(error).__name__


if __name__ == "__main__":
    serve()
