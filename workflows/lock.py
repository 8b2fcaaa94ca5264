"""After a run that was killed: its lock of the working folder, and the files it left aside."""

from __future__ import annotations

import fcntl
import os
import shutil
import socket
from pathlib import Path


def free_stale_lock(folder: Path) -> int:
    """Take away Snakemake's lock if no process is left that could have taken it.

    Snakemake's own lock is plain files: after a kill they stay, and no later run starts. So every
    run, before it takes that lock, holds a lock of the kernel's, which ends with its process in
    any case. Who holds it alone is the only run.

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
    A lock that a run on another machine took is left, since the kernels of two machines need not
    know of each other, and so is any on a file system without such locks: `--unlock` frees these.
    """
    folder.mkdir(parents=True, exist_ok=True)
    locks, here = folder / "locks", socket.gethostname().encode()
    held = os.open(folder / "alive", os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.pread(held, len(here) + 1, 0) == here:
            shutil.rmtree(locks, ignore_errors=True)
        if not locks.is_dir() or not any(locks.iterdir()):
            os.truncate(held, 0)
            os.pwrite(held, here, 0)
        fcntl.flock(held, fcntl.LOCK_SH)
    except BlockingIOError:  # others run, or look at the plan
        fcntl.flock(held, fcntl.LOCK_SH)
    except OSError:
        pass
    return held


def remove_leavings(*folders: Path) -> None:
    """Take away what killed jobs were writing: hidden files and folders, not yet renamed."""
    for folder in folders:
        for path in list(folder.rglob(".*")):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)
