"""After a run that was killed: its lock of the working folder, and the files it left aside."""

from __future__ import annotations

import fcntl
import os
import shutil
import socket
from pathlib import Path

# Hidden files and folders, not yet renamed. In the folder of a study, which `cfmpm study` may be
# writing to as well, those of the rules alone.
UNFINISHED = (
    *(f"{folder}/**/.*" for folder in ("paper", "performance", "stability")),
    *("*/.study.nc.*.part", "*/members/.batch_*.npz.*.part", "..compiled.*.part"),
)


def clear_after_kill(folder: Path, results: Path) -> int:
    """Take away what a killed run has left, if no run is alive.

    Snakemake's own lock is plain files: after a kill they stay, and no later run starts. So every
    run, before it takes that lock, holds a lock of the kernel's, which ends with its process in
    any case. Who holds it alone is the only run: it may take away Snakemake's lock and the files
    that killed jobs were writing. Two runs of different targets go side by side, and then the
    unfinished files of the one are not the other's to remove.

    Parameters
    ----------
    folder : Path
        Snakemake's: ``.snakemake`` in the working folder.
    results : Path
        What the workflow writes is in there.

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
    locks, here = folder / "locks", socket.gethostname().encode()
    held = os.open(folder / "alive", os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.pread(held, len(here) + 1, 0) == here:
            shutil.rmtree(locks, ignore_errors=True)
            _remove_unfinished(results)
        if not locks.is_dir() or not any(locks.iterdir()):
            os.truncate(held, 0)
            os.pwrite(held, here, 0)
        fcntl.flock(held, fcntl.LOCK_SH)
    except BlockingIOError:  # others run, or look at the plan
        fcntl.flock(held, fcntl.LOCK_SH)
    except OSError:
        pass
    return held


def _remove_unfinished(results: Path) -> None:
    for path in [path for pattern in UNFINISHED for path in results.glob(pattern)]:
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
