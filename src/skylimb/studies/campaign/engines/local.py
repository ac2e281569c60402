"""Flies in processes of this machine, each an executor of its own: when one dies, no other is touched."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
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
        had_begun: whether it was there when it got the batch.
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
        super().__init__(campaign, workers)
        self._context = multiprocessing.get_context("spawn")
        # The workers end when this end of the pipe is closed, which the death of this process does, too.
        self._end, self._alive = self._context.Pipe(duplex=False)
        self._threads = ThreadPoolExecutor(workers)
        self._workers: list[ProcessPoolExecutor] = []
        self._free: list[ProcessPoolExecutor] = []
        self._stillborn = 0

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        """See `Engine`."""
        worker = self._free.pop() if self._free else self._started()
        return self._threads.submit(self._fly, worker, jobs)

    def _started(self) -> ProcessPoolExecutor:
        worker = ProcessPoolExecutor(1, self._context, _end_with, (self._end,))
        with _inherited():
            worker.submit(os.getpid)  # the process is started by the first thing that it is to do
        self._workers.append(worker)
        return worker

    def _fly(self, worker: ProcessPoolExecutor, jobs: Sequence[Job]) -> list[Flown]:
        """Have a process fly; one that has died is never free again."""
        has_begun = False
        try:
            worker.submit(os.getpid).result()
            has_begun = True
            flown = worker.submit(fly_jobs, self.campaign, jobs).result()
        except BrokenProcessPool:
            raise WorkerDiedError(has_begun) from None
        self._stillborn = 0
        self._free.append(worker)
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
        self._alive.close()
        for each in (self._threads, *self._workers):
            each.shutdown()


def _end_with(coordinator: Connection) -> None:
    """In the process: end when the coordinator lets go of its end of the pipe, however that happens."""

    def watch() -> None:
        wait([coordinator])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


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
