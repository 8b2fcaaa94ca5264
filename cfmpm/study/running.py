"""Solving the members of a study in processes of their own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from multiprocessing.connection import Connection, wait

from cfmpm.errors import SolveError
from cfmpm.study.member import Job, Outcome, solve
from cfmpm.study.reading import Member
from cfmpm.study.store import Store

# How many threads libraries start as they are loaded. A run keeps to one (`threads`); as many
# idle ones in each process as there are cores are more than large machines allow.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


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

    Raises
    ------
    SolveError
        Where no process can be started.
    """
    jobs = {one.key: one.job() for one in members if one.key not in outcomes}
    try:
        with closing(_solved(deque(jobs.values()), workers)) as solved:
            for outcome in solved:
                store.add(outcome)
                outcomes[outcome.key] = outcome
                observe(outcome)
    finally:
        store.flush()
    store.gather()


def usable_cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _solved(jobs: deque[Job], workers: int) -> Generator[Outcome, None, None]:
    """Solve members, in the order in which they come to their ends."""
    tried: set[str] = set()
    crew: list[_Worker] = []
    any_started = False
    # Compiling takes longer than most members: the first one does it for all.
    most = workers if workers == 1 or _compiled() else 1
    try:
        while jobs or any(worker.job for worker in crew):
            while jobs and len(crew) < most:
                crew.append(_Worker(jobs.popleft()))
            ready = wait([worker.pipe for worker in crew if worker.job])
            for worker in [worker for worker in crew if worker.pipe in ready]:
                job, outcome = worker.job, worker.outcome()
                assert job is not None
                any_started |= worker.started
                if outcome is not None:
                    most = workers
                    worker.take(jobs.popleft() if jobs else None)
                    yield outcome
                    continue
                if worker.alive:
                    continue
                if not (any_started or worker.was_killed()):
                    raise SolveError(
                        f"no process to solve members in can be started: {worker.cause_of_death()}"
                    )
                # Each member of a process that died has a second chance, in a new process.
                crew.remove(worker)
                if job.key in tried:
                    yield Outcome(job.key, "failed", worker.cause_of_death(), lasting=False)
                else:
                    tried.add(job.key)
                    jobs.append(job)
    finally:
        for worker in crew:
            worker.process.terminate()
        for worker in crew:
            worker.process.join()


class _Worker:
    """A process that solves one member after the other.

    The executors of `concurrent.futures` do not tell of which member a process has died, and up to
    Python 3.12 can wait for ever for one that starts while another dies.
    """

    def __init__(self, job: Job) -> None:
        # New processes rather than copies of this one: a copy takes locks of other threads along.
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other,), daemon=True)
        with _one_thread():
            self.process.start()
        other.close()  # with the process its end is then closed for good, which is seen here
        self.started, self.alive = False, True
        self.take(job)

    def take(self, job: Job | None) -> None:
        """Begin with a member; with None there is nothing more to do."""
        self.job = job
        if job is not None:
            with suppress(OSError):  # the process has died, which `outcome` will tell
                self.pipe.send(job)

    def outcome(self) -> Outcome | None:
        """What the member has left; None if the process has only now started, or has died."""
        try:
            found: Outcome | None = self.pipe.recv()
        except (EOFError, OSError):
            self.alive = False
            return None
        self.started = True
        return found

    def was_killed(self) -> bool:
        """Whether the process, which has died, was killed, as it is by a system out of memory."""
        self.process.join()
        return self.process.exitcode == -signal.SIGKILL

    def cause_of_death(self) -> str:
        """Say how the process ended, once it has."""
        if self.was_killed():
            return "its process was killed; not enough memory?"
        code = self.process.exitcode
        how = f"by signal {-code}" if code is not None and code < 0 else f"with status {code}"
        return f"its process ended {how}"


def _serve(pipe: Connection) -> None:
    """Solve members as they come, in a process of their own."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end_with(sentinel: int) -> None:
        wait([sentinel])
        os._exit(1)

    threading.Thread(target=end_with, args=(parent.sentinel,), daemon=True).start()
    # What cannot be imported is no fault of a member.
    import gmsh  # noqa: F401

    import cfmpm.simulation  # noqa: F401

    with suppress(EOFError, BrokenPipeError):  # the other side is gone
        pipe.send(None)  # has started
        while True:
            pipe.send(solve(pipe.recv()))


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes that start within the ``with`` block start no threads of libraries."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _compiled() -> bool:
    """Whether kernels have been compiled before, of the present sources."""
    from cfmpm._jit import cache_folder

    return any(cache_folder().glob("**/*.nbc"))
