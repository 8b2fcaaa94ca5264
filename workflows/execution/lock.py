"""After a run that was killed: its lock of the working folder, and the files it left aside."""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import socket
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from cfmpm.output.run_folder import is_held

# What follows the name of a file that is written aside, by `output.files.written_aside` and by
# `tempfile`, which pictures are drawn in a folder of.
ASIDE = (f".{'[0-9a-f]' * 8}.part", f".{'[0-9a-z_]' * 8}")


def clear_after_kill(folder: Path) -> int:
    """Take away the lock that a killed run has left, if no run is alive.

    Snakemake's own lock is plain files: after a kill they stay, and no later run starts. So every
    run, before it takes that lock, holds a lock of the kernel's, which ends with its process in
    any case. Who holds it alone is the only run: it may take away Snakemake's lock.

    Parameters
    ----------
    folder : Path
        Snakemake's: ``.snakemake`` in the working folder.

    Returns
    -------
    int
        Descriptor of the kernel's lock, to be left open until the process ends.

    Notes
    -----
    What a run on another machine left stays, since the kernels of two machines need not know of
    each other, and so does all on a file system without such locks: `--unlock` frees the lock.
    """
    folder.mkdir(parents=True, exist_ok=True)
    locks = folder / "locks"
    held = os.open(folder / "alive", os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if _was_here(held):
            shutil.rmtree(locks, ignore_errors=True)
        if not locks.is_dir() or not any(locks.iterdir()):
            os.truncate(held, 0)
            os.pwrite(held, _here(), 0)
        fcntl.flock(held, fcntl.LOCK_SH)
    except BlockingIOError:  # others run, or look at the plan
        fcntl.flock(held, fcntl.LOCK_SH)
    except OSError:
        pass
    return held


def remove_unfinished(held: int, folder: Path, outputs: Iterable[str]) -> None:
    """Take away what killed jobs were writing beside their outputs, if no other run is alive.

    Two runs of different targets go side by side, and then the unfinished files of the one are not
    the other's to remove. Nor are those in a folder to which `cfmpm` is writing.

    Parameters
    ----------
    held : int
        From `clear_after_kill`.
    folder : Path
        The working folder.
    outputs : iterable of str
        Of all rules, with their wildcards; relative to it.
    """
    with suppress(OSError):
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if _was_here(held):
            for output in outputs:
                _remove_asides(folder, re.sub(r"\{.*?\}", "*", output))
    with suppress(OSError):
        fcntl.flock(held, fcntl.LOCK_SH)


def _remove_asides(folder: Path, output: str) -> None:
    place, name = os.path.split(output)
    for path in [path for aside in ASIDE for path in folder.glob(f"{place}/.{name}{aside}")]:
        if any(is_held(folder / above) for above in path.relative_to(folder).parents):
            continue
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def _here() -> bytes:
    return socket.gethostname().encode()


def _was_here(held: int) -> bool:
    """Whether the last run that was the only one was on this machine."""
    return os.pread(held, len(_here()) + 1, 0) == _here()
