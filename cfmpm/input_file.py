"""Reading of files that others have made: nothing that blocks, and no more than is expected."""

from __future__ import annotations

import errno
import os
import stat
from io import BufferedReader

# Bytes of a scene, a study or a Python file. An outline of ten thousand corners has a fifth of it.
MOST_TEXT = 2**21

_KINDS = {
    stat.S_IFIFO: "a named pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def open_file(path: str | os.PathLike[str]) -> BufferedReader:
    """Open a regular file to read it.

    Parameters
    ----------
    path : path-like

    Raises
    ------
    OSError
        Where there is none. A folder, a named pipe or a device is none, nor is it waited for.
    """
    _require_regular(os.stat(path), path)
    # A pipe that has come to stand there meanwhile would block.
    file = os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb")
    try:
        _require_regular(os.fstat(file.fileno()), path)
    except OSError:
        file.close()
        raise
    return file


def read_file(path: str | os.PathLike[str], most: int) -> bytes:
    """Read a regular file of at most so many bytes.

    Parameters
    ----------
    path : path-like
    most : int
        Bytes.

    Raises
    ------
    OSError
        As `open_file`; where the file is larger, too.
    """
    with open_file(path) as file:
        content = file.read(most + 1)
        if len(content) > most:
            size = max(os.fstat(file.fileno()).st_size, len(content))
            reason = f"it has {size / 2**20:.3g} MB, more than {most / 2**20:.3g} MB"
            raise OSError(errno.EFBIG, reason, os.fspath(path))
    return content


def _require_regular(status: os.stat_result, path: str | os.PathLike[str]) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "something else")
        raise OSError(errno.EINVAL, f"it is {kind}, not a file", os.fspath(path))
