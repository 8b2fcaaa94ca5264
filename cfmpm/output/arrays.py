"""Reading of .npz files that may be damaged, in no more memory than the size of the file."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZIP_STORED, BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from cfmpm.input_file import open_file

# What reading shows of a damaged file besides BadZipFile: of the archive, and of an array in it.
_DAMAGE = (
    *(BadZipFile, EOFError, NotImplementedError, RuntimeError, struct.error),
    *(ValueError, TypeError, LookupError, OverflowError, SyntaxError, MemoryError),
)


class DamagedError(ValueError):
    """A file that is no .npz file as cfmpm writes them; says why."""


class Arrays:
    """The arrays of an open file, each read and checked by its sum when it is asked for."""

    def __init__(self, archive: ZipFile) -> None:
        self._archive = archive
        self.names = [name.removesuffix(".npy") for name in archive.namelist()]

    def __getitem__(self, name: str) -> NDArray[Any]:
        try:
            content = BytesIO(self._archive.read(f"{name}.npy"))
            array: NDArray[Any] = np.lib.format.read_array(content, allow_pickle=False)
        except _DAMAGE as error:
            raise DamagedError(f"{name}: {error}") from None
        return array


@contextmanager
def opened_arrays(path: Path) -> Iterator[Arrays]:
    """Open a file that `numpy.savez` has written.

    Parameters
    ----------
    path : Path

    Raises
    ------
    OSError
        Where there is no such file.
    DamagedError
        Where it is no archive of arrays as they are. One whose parts are compressed, or overlap,
        could stand for any amount of memory.
    """
    with open_file(path) as file:
        size = os.fstat(file.fileno()).st_size
        try:
            archive = ZipFile(file)
        except _DAMAGE as error:
            raise DamagedError(str(error)) from None
        with archive:
            parts = archive.infolist()
            if any(part.compress_type != ZIP_STORED for part in parts):
                raise DamagedError("its arrays are compressed")
            if sum(part.file_size for part in parts) > size:
                raise DamagedError("its arrays are larger than the file")
            yield Arrays(archive)
