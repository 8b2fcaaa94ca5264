"""Solving the members of a study in separate processes."""

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

# Environment variables of the number of threads that libraries start when they are loaded. A run
# uses one (`threads`); one idle thread per core in each process exceeds limits of large machines.
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
        Known outcomes, by the keys of their members; new ones are added.
    store : Store
        Store for new outcomes.
    workers : int
        Number of processes, each on one thread. Results do not depend on it.
    observe : callable, optional
        Called with each new outcome.

    Raises
    ------
    SolveError
        If no process can be started.
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
    """Number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _solved(jobs: deque[Job], workers: int) -> Generator[Outcome, None, None]:
    """Solve members; outcomes are in the order of completion."""
    tried: set[str] = set()
    crew: list[_Worker] = []
    any_started = False
    # Compilation takes longer than most members: the first member does it for all.
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
                # The member of a process that died is solved once more, in a new process.
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

    The executors of `concurrent.futures` do not report the member for which a process died, and up
    to Python 3.12 they can wait forever for a process that starts while another dies.
    """

    def __init__(self, job: Job) -> None:
        # New processes rather than forks of this one, which would inherit locks of other threads.
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other,), daemon=True)
        with _one_thread():
            self.process.start()
        other.close()  # with the process its end is then closed for good, which is seen here
        self.started, self.alive = False, True
        self.take(job)

    def take(self, job: Job | None) -> None:
        """Start a member; None ends the process."""
        self.job = job
        if job is not None:
            with suppress(OSError):  # the process has died, which `outcome` will tell
                self.pipe.send(job)

    def outcome(self) -> Outcome | None:
        """The outcome of the member; None if the process has just started, or has died."""
        try:
            found: Outcome | None = self.pipe.recv()
        except (EOFError, OSError):
            self.alive = False
            return None
        self.started = True
        return found

    def was_killed(self) -> bool:
        """Whether the process was killed, as by a system that is out of memory."""
        self.process.join()
        return self.process.exitcode == -signal.SIGKILL

    def cause_of_death(self) -> str:
        """Describe how the process ended."""
        if self.was_killed():
            return "its process was killed; not enough memory?"
        code = self.process.exitcode
        how = f"by signal {-code}" if code is not None and code < 0 else f"with status {code}"
        return f"its process ended {how}"


def _serve(pipe: Connection) -> None:
    """Solve members as they are received; the main function of a process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end_with(sentinel: int) -> None:
        wait([sentinel])
        os._exit(1)

    threading.Thread(target=end_with, args=(parent.sentinel,), daemon=True).start()
    # An import error is not an error of a member.
    import gmsh  # noqa: F401

    import cfmpm.simulation  # noqa: F401

    with suppress(EOFError, BrokenPipeError):  # the other side is gone
        pipe.send(None)  # has started
        while True:
            pipe.send(solve(pipe.recv()))


@contextmanager
def _one_thread() -> Iterator[None]:
    """Prevent threads of libraries in processes that are started within the ``with`` block."""
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
    """Whether the kernels of the current sources are compiled."""
    from cfmpm._jit import cache_folder

    return any(cache_folder().glob("**/*.nbc"))
