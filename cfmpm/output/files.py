"""Safe writing of files: aside, then renamed."""

from __future__ import annotations

import os
import secrets
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import xarray as xr

from cfmpm.interruption import held_back


def write_dataset(dataset: xr.Dataset, path: Path) -> None:
    """Write a dataset to netCDF aside and rename it, so that no half file is ever seen.

    Parameters
    ----------
    dataset : xarray.Dataset
    path : Path
        Its folder is made if needed.

    Raises
    ------
    OSError
        Where the folder cannot be written; `path` is then untouched.
    """
    with written_aside(path) as aside:
        store(dataset, aside)


def store(dataset: xr.Dataset, path: Path) -> None:
    """Write a dataset to netCDF in place: into what `written_aside` gives."""
    # Coordinates have no missing values; NaN marks them everywhere else.
    encoding = {str(c): {"_FillValue": None} for c in dataset.coords}
    dataset.to_netcdf(path, engine="netcdf4", encoding=encoding)


@contextmanager
def written_aside(path: Path) -> Iterator[Path]:
    """Give a place to write to, which becomes `path` when the ``with`` block ends well.

    Requests to end wait for that.

    Parameters
    ----------
    path : Path
        Its folder is made if needed.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        # Unlike tempfile's, with the permissions that any new file of this process gets.
        os.close(os.open(aside, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        with held_back():
            yield aside
            with aside.open("rb+") as file:
                os.fsync(file.fileno())
            aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)


@contextmanager
def written_aside_by_name(path: Path) -> Iterator[Path]:
    """As `written_aside`, for writers that go by the name of the file: aside is in a folder.

    Parameters
    ----------
    path : Path
        Its folder is made if needed.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as folder:
        aside = Path(folder) / path.name
        yield aside
        aside.replace(path)


def remove_asides(folder: Path, name: str) -> None:
    """Take away what processes that were killed had begun to write aside.

    Parameters
    ----------
    folder : Path
    name : str
        What the files were to be called; a pattern.
    """
    for path in Path(folder).glob(f".{name}.{'[0-9a-f]' * 8}.part"):
        path.unlink(missing_ok=True)
