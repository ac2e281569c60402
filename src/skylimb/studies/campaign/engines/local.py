"""Flies in processes of this machine, each with a pipe of its own.

A thread hands a batch through the pipe and waits for what comes back. When a process dies, however that
happens, the system closes its end: the thread reads the end of the pipe, and no other process is touched.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait

from skylimb.studies.campaign.engines import Engine, WorkerError
from skylimb.studies.campaign.worker import Flown, Job, fly_jobs

_STILLBORN = 5
"""Workers in a row that die before they begin, after which it isn't bad luck."""

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables by which libraries for linear algebra learn how many threads to start."""


class WorkerDiedError(WorkerError):
    """A process ended before it gave its batch back.

    Attributes:
        had_begun: whether the batch was in its hands.
    """

    def __init__(self, had_begun: bool) -> None:
        super().__init__("a worker process died")
        self.had_begun = had_begun


class LocalEngine(Engine):
    """An engine of worker processes, started when they get their first batch.

    Args:
        campaign: as `Campaign.text` gives it.
        workers: how many processes.
    """

    def __init__(self, campaign: str, workers: int) -> None:
        super().__init__(campaign)
        self._threads = ThreadPoolExecutor(workers)
        self._processes: list[_Process] = []
        self._free: list[_Process] = []
        self._count, self._stillborn = workers, 0

    @property
    def slots(self) -> int:
        """See `Engine`."""
        return self._count

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        """See `Engine`."""
        if not self._free:
            self._free.append(_Process(self._campaign))
            self._processes.append(self._free[-1])
        return self._threads.submit(self._fly, self._free.pop(), jobs)

    def _fly(self, process: _Process, jobs: Sequence[Job]) -> list[Flown]:
        """Have a process fly; one that has died is never free again."""
        flown = process.fly(jobs)
        self._stillborn = 0
        self._free.append(process)
        if isinstance(flown, BaseException):
            raise flown
        return flown

    def deaths(self, error: BaseException) -> int | None:
        """See `Engine`."""
        if not isinstance(error, WorkerDiedError):
            return None
        if error.had_begun:
            return 1
        self._stillborn += 1
        if self._stillborn >= _STILLBORN:
            raise WorkerError(
                f"{_STILLBORN} worker processes in a row died while starting; a script that starts a "
                'campaign needs `if __name__ == "__main__":` around the call'
            )
        return 0

    def close(self) -> None:
        """See `Engine`."""
        for process in self._processes:
            process.end()
        self._threads.shutdown()


class _Process:
    """A process that flies one batch after the other."""

    def __init__(self, campaign: str) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(campaign, theirs), daemon=True)
        with _inherited():
            self._process.start()
        theirs.close()  # so that its death closes the last one

    def fly(self, jobs: Sequence[Job]) -> list[Flown] | BaseException:
        """What came of a batch, or the error that it ended with."""
        has_begun = False
        try:
            self._pipe.send(jobs)
            has_begun = self._pipe.recv()
            return self._pipe.recv()
        except (EOFError, OSError):
            self.end()
            raise WorkerDiedError(has_begun) from None

    def end(self) -> None:
        self._process.kill()
        self._process.join()


def _serve(campaign: str, pipe: Connection) -> None:
    """In the process: fly what comes, until the coordinator ends, however that happens."""
    threading.Thread(target=_end_with_coordinator, daemon=True).start()
    with suppress(EOFError, OSError):
        while True:
            jobs = pipe.recv()
            pipe.send(True)
            try:
                flown = fly_jobs(campaign, jobs)
            except BaseException as error:
                error.add_note(traceback.format_exc())  # where in the worker
                flown = error
            pipe.send(flown)


def _end_with_coordinator() -> None:
    coordinator = multiprocessing.parent_process()
    if coordinator is not None:
        wait([coordinator.sentinel])
        os._exit(1)


@contextmanager
def _inherited() -> Iterator[None]:
    """A process started in here keeps to one core, and leaves Ctrl-C to the coordinator from its start on."""
    before = {name: os.environ[name] for name in _THREADS if name in os.environ}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT]) if os.name == "posix" else None
    try:
        yield
    finally:
        if mask is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for name in _THREADS:
            del os.environ[name]
        os.environ.update(before)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
