"""Atomic writing of files: to a temporary file, which is then renamed."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import xarray as xr

from cfmpm.interruption import held_back

# Bytes of a name of a scene in a file name; file systems allow 255 for all of that.
LONGEST_NAME = 120
# Bytes that are written at once.
CHUNK = 2**20


def write_dataset(dataset: xr.Dataset, path: Path) -> None:
    """Write a dataset to netCDF atomically, so that `path` is never an incomplete file.

    Parameters
    ----------
    dataset : xarray.Dataset
    path : Path
        Its folder is made if needed.

    Raises
    ------
    OSError
        If the folder cannot be written; `path` is then unchanged.
    """
    with written_aside(path) as aside:
        store(dataset, aside)


def store(dataset: xr.Dataset, path: Path) -> None:
    """Write a dataset to netCDF in place, into a temporary file of `written_aside`.

    The space is taken before the netCDF library writes: on a full disk that tells no reason, and
    may end the process.

    Parameters
    ----------
    dataset : xarray.Dataset
    path : Path

    Raises
    ------
    OSError
        Where the file cannot be written, with the reason of the system.
    """
    # Coordinates have no missing values; in all other variables NaN marks them.
    encoding = {str(c): {"_FillValue": None} for c in dataset.coords}
    with file_named(path):
        _take_space(path, _size(dataset))
        dataset.to_netcdf(path, engine="netcdf4", encoding=encoding)


def _take_space(path: Path, size: int) -> None:
    """Make a file of zeros [bytes], with the system's error where there is no space for it."""
    with path.open("wb") as file:
        for begin in range(0, size, CHUNK):
            file.write(bytes(min(CHUNK, size - begin)))


def _size(dataset: xr.Dataset) -> int:
    """Return what a dataset takes on disk at most [bytes]."""
    attributes = [dataset.attrs, *(variable.attrs for variable in dataset.variables.values())]
    numbers = sum(value.nbytes for value in dataset.variables.values() if value.dtype != object)
    words = sum(
        len(str(word)) + 16
        for value in dataset.variables.values()
        if value.dtype == object
        for word in value.values.ravel()
    )
    return (
        numbers + words + 4 * sum(len(str(a)) for a in attributes) + 4096 * len(attributes) + 2**16
    )


@contextmanager
def file_named(path: Path) -> Iterator[None]:
    """Let errors of writing say of which file they are: those of an open file do not."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(path)
        raise


@contextmanager
def written_aside(path: Path) -> Iterator[Path]:
    """Yield a temporary file, which is renamed to `path` if the ``with`` block has no error.

    Interrupts are delayed until then.

    Parameters
    ----------
    path : Path
        Its folder is made if needed.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        # Unlike tempfile, this gives the default permissions of new files.
        os.close(os.open(aside, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        with held_back():
            yield aside
            with file_named(aside), aside.open("rb+") as file:
                os.fsync(file.fileno())
            aside.replace(path)
    except OSError as error:
        if error.filename == str(aside):  # the user knows the file by its name alone
            error.filename = str(path)
        raise
    finally:
        aside.unlink(missing_ok=True)


@contextmanager
def written_aside_by_name(path: Path) -> Iterator[Path]:
    """As `written_aside`, for writers that depend on the file name: it is in a temporary folder.

    Parameters
    ----------
    path : Path
        Its folder is made if needed.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    prefix = f".{path.name}."
    try:
        with tempfile.TemporaryDirectory(prefix=prefix, dir=path.parent) as folder:
            aside = Path(folder) / path.name
            yield aside
            aside.replace(path)
    except OSError as error:
        if error.filename is None or prefix in str(error.filename):  # only ours has such a name
            error.filename = str(path)
        raise


def in_file_name(name: object) -> str:
    """A name of a scene as a part of a file name: letters, digits, blanks, dots and dashes.

    Names that are too long for a file system are cut, and end with a hash of what they are.
    """
    text = re.sub(r"[^\w .+-]", lambda odd: f"%{ord(odd[0]):02X}", str(name))
    whole = text.encode()
    if len(whole) <= LONGEST_NAME:
        return text
    digest = hashlib.sha256(whole).hexdigest()[:16]
    return f"{whole[: LONGEST_NAME - 17].decode(errors='ignore')}-{digest}"


def remove_asides(folder: Path, name: str) -> None:
    """Remove temporary files of processes that were killed.

    Parameters
    ----------
    folder : Path
    name : str
        Name of the intended files; a pattern.
    """
    for path in Path(folder).glob(f".{name}.{'[0-9a-f]' * 8}.part"):
        path.unlink(missing_ok=True)
