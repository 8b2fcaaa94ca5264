"""Solving the members of a study in processes of their own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from multiprocessing.connection import wait as wait_for

from cfmpm.scene import Scene
from cfmpm.study.member import Outcome, solve
from cfmpm.study.reading import Member
from cfmpm.study.store import Store

# Members handed to each process ahead of time: it has no pause between two of them.
AHEAD = 2
# What keeps a member to one thread; read by the libraries as they are loaded.
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)

Job = tuple[str, Scene]


def run_members(
    members: Iterable[Member],
    outcomes: dict[str, Outcome],
    store: Store,
    workers: int,
    observe: Callable[[Outcome], None] = lambda outcome: None,
) -> None:
    """Solve the members whose outcomes are not known.

    Parameters
    ----------
    members : iterable of Member
    outcomes : dict of str to Outcome
        Those known, by the keys of their members; new ones are added as they come.
    store : Store
        Where new outcomes are kept.
    workers : int
        Processes, each on one thread. No number depends on how many there are.
    observe : callable, optional
        Called with each new outcome.
    """
    jobs = {one.key: one.scene for one in members if one.key not in outcomes}
    try:
        with closing(_solved(deque(jobs.items()), workers)) as solved:
            for outcome in solved:
                store.add(outcome)
                outcomes[outcome.key] = outcome
                observe(outcome)
    finally:
        store.gather()


def usable_cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _solved(jobs: deque[Job], workers: int) -> Generator[Outcome, None, None]:
    """Solve members, in the order in which they come to their ends."""
    # Compiling takes longer than most members: the first one does it for all.
    if len(jobs) > 1 and workers > 1 and not _compiled():
        jobs.extendleft((yield from _pooled(deque([jobs.popleft()]), 1)))
    while jobs:
        lost = deque((yield from _pooled(jobs, min(workers, len(jobs)))))
        # A process died: what was under way is tried again one by one, to find out on which.
        while lost:
            for key, _ in (yield from _pooled(lost, 1, ahead=1)):
                yield Outcome(key, "its process died; not enough memory?", lasting=False)


def _pooled(
    jobs: deque[Job], workers: int, ahead: int = AHEAD
) -> Generator[Outcome, None, list[Job]]:
    """Solve members until all are done or a process dies; returns those under way when it died."""
    running: dict[Future[Outcome], Job] = {}
    with _pool(workers) as pool:
        try:
            while jobs or running:
                while jobs and len(running) < ahead * workers:
                    running[pool.submit(solve, *jobs[0])] = jobs[0]
                    jobs.popleft()
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    outcome = future.result()
                    del running[future]
                    yield outcome
        except BrokenProcessPool:
            whole = [one for one in running if one.done() and one.exception() is None]
            for future in whole:
                del running[future]
                yield future.result()
    return list(running.values())


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    # New processes rather than copies of this one: a copy takes locks of other threads along.
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _prepare)
    os.environ.update(ONE_THREAD)
    try:
        yield pool
    except BaseException:
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _prepare() -> None:
    """Make a new process ready: it loads what is heavy, and ends when the one that made it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        wait_for([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()

    import cfmpm.simulation  # noqa: F401


def _compiled() -> bool:
    """Whether kernels have been compiled before, of the present sources."""
    from cfmpm._jit import cache_folder

    return any(cache_folder().glob("**/*.nbc"))
