"""What every job of the workflow does before its work: log file and threads."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

log = logging.getLogger(__name__)


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
