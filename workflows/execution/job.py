"""What surrounds every job of the workflow: imports, log file, threads."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

log = logging.getLogger(__name__)


def let_scripts_import(root: Path) -> None:
    """Make scripts, which run in processes of their own, import from the checkout at `root`."""
    paths = [str(root), os.environ.get("PYTHONPATH", "")]
    os.environ["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)


@contextmanager
def job(snakemake: Any) -> Iterator[None]:
    """Log to the rule's file, traceback included, and keep Numba to the rule's threads.

    Parameters
    ----------
    snakemake : Snakemake
        The object that Snakemake puts into a script. It has set the threads of the BLAS itself,
        by environment variables, but does not know Numba.
    """
    import numba

    Path(snakemake.log[0]).parent.mkdir(parents=True, exist_ok=True)
    logging.basicConfig(
        filename=snakemake.log[0],
        filemode="w",
        format="%(asctime)s %(name)s %(message)s",
    )
    for name in ("cfmpm", "workflows"):
        logging.getLogger(name).setLevel(logging.INFO)
    numba.set_num_threads(min(snakemake.threads, numba.get_num_threads()))
    log.info("rule %s on %d threads", snakemake.rule, snakemake.threads)
    try:
        yield
    except BaseException:
        log.exception("failed")
        raise
    log.info("done")
