"""Reading of netCDF files that may be damaged: in another process, with limits.

On some damaged files the netCDF library crashes, does not return, or takes all the memory. This
process is given the values alone.
"""

from __future__ import annotations

import atexit
import json
import os
import pickle
import select
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import xarray as xr

from cfmpm.input_file import open_file

# Of netCDF 4, which is HDF5.
MAGIC = b"\x89HDF\r\n\x1a\n"
# CPU time of reading a file: these seconds, and one more for so many bytes, which is some ten times
# what a sound one takes.
SECONDS, BYTES_PER_SECOND = 4.0, 20e6
# Wall time is a multiple: machines are busy, and disks far away.
PATIENCE = 30.0


class DamagedError(ValueError):
    """A file that cannot be read as netCDF; says why."""


def read_netcdf(path: Path) -> xr.Dataset:
    """Read a netCDF file into memory, as `xarray.load_dataset` does.

    Parameters
    ----------
    path : Path

    Raises
    ------
    OSError
        Where there is no such file.
    DamagedError
        Where it is damaged, or no netCDF-4.
    """
    with open_file(path) as file:
        start, size = file.read(len(MAGIC)), os.fstat(file.fileno()).st_size
    if start != MAGIC:
        raise DamagedError("it is no netCDF-4 file" if size else "it is empty")
    found = _READER.ask(os.path.abspath(path), size)
    try:
        variables = {
            name: xr.Variable(dims, values, attributes)
            for name, (dims, values, attributes) in found["variables"].items()
        }
        dataset = xr.decode_cf(xr.Dataset(variables, attrs=found["attributes"])).load()
    except (ValueError, TypeError, LookupError, AttributeError, ArithmeticError) as error:
        raise DamagedError(_one_line(error)) from None
    dataset.encoding["source"] = os.path.abspath(path)
    return dataset


class _Reader:
    """A process that reads files, started when it is first needed, and again when it has died."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    def ask(self, path: str, size: int) -> dict[str, Any]:
        """Return the attributes and variables of a file.

        Parameters
        ----------
        path : str
        size : int
            Bytes of the file.

        Raises
        ------
        DamagedError
        """
        seconds = SECONDS + size / BYTES_PER_SECOND
        request = json.dumps({"path": path, "size": size, "seconds": seconds}) + "\n"
        with self._lock:
            process = self._running()
            assert process.stdin is not None
            try:
                process.stdin.write(request.encode())
                process.stdin.flush()
                good, answer = _answer(process, time.monotonic() + PATIENCE * seconds)
            except (EOFError, BrokenPipeError):
                self.stop()
                raise DamagedError("the netCDF library breaks down on it") from None
            except TimeoutError:
                self.stop()
                raise DamagedError("the netCDF library does not come to an end with it") from None
            except BaseException:  # such as Ctrl-C: what it still answers is for nobody
                self.stop()
                raise
        if not good:
            raise DamagedError(answer)
        found: dict[str, Any] = answer
        return found

    def stop(self) -> None:
        """End the process, if there is one."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._process.poll() is not None:
            self.stop()
        if self._process is None:
            paths = os.pathsep.join(path for path in sys.path if path)
            threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
            self._process = subprocess.Popen(
                [sys.executable, "-P", str(Path(__file__).with_name("netcdf_child.py"))],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "PYTHONPATH": paths, **threads},
                start_new_session=True,  # Ctrl-C is for this process
            )
        return self._process


def _answer(process: subprocess.Popen[bytes], deadline: float) -> tuple[bool, Any]:
    (length,) = struct.unpack("<Q", _received(process, 8, deadline))
    good, answer = pickle.loads(_received(process, length, deadline))
    return good, answer


def _received(process: subprocess.Popen[bytes], length: int, deadline: float) -> bytearray:
    assert process.stdout is not None
    pipe, received = process.stdout.fileno(), bytearray()
    while len(received) < length:
        left = deadline - time.monotonic()
        if left <= 0.0 or not select.select([pipe], [], [], left)[0]:
            raise TimeoutError
        part = os.read(pipe, min(length - len(received), 2**20))
        if not part:
            raise EOFError
        received += part
    return received


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:200]


_READER = _Reader()
atexit.register(_READER.stop)
