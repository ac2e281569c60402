"""Flies in processes of this machine. pebble starts them, watches them and says which one died.

Every worker is a pool of one process. A process that is killed while it sends leaves half a message and a
held lock behind: it spoils its own pool and no other, and that pool is thrown away.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Future, InvalidStateError
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing.connection import wait
from multiprocessing.sharedctypes import Synchronized
from typing import Any

from pebble import ProcessExpired, ProcessPool

from skylimb.studies.campaign.bench import Flown, Job, fly_jobs
from skylimb.studies.campaign.engines import WorkerError

_STILLBORN = 5
"""Workers in a row that die before they begin, after which it isn't bad luck."""

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables by which libraries for linear algebra learn how many threads to start."""


class LocalEngine:
    """An engine of worker processes, started when they get their first batch.

    Args:
        tables: the campaign, as `Campaign.to_mapping` gives it.
        workers: how many processes.
    """

    def __init__(self, tables: Mapping[str, Any], workers: int) -> None:
        self._tables = dict(tables)
        self._workers = [_Worker() for _ in range(workers)]
        self._stillborn = 0

    @property
    def slots(self) -> int:
        """See `Engine`."""
        return len(self._workers)

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        """See `Engine`."""
        worker = next(worker for worker in self._workers if worker.is_free)
        if worker.has_delivered:
            self._stillborn = 0
        return worker.fly(self._tables, jobs)

    def deaths(self, error: BaseException) -> int | None:
        """See `Engine`."""
        if isinstance(error, ProcessExpired):
            return 1
        if not isinstance(error, BrokenProcessPool):
            return None
        self._stillborn += 1
        if self._stillborn >= _STILLBORN:
            raise WorkerError(
                f"{_STILLBORN} worker processes in a row died while starting; a script that starts a "
                'campaign needs `if __name__ == "__main__":` around the call'
            )
        return 0

    def check(self) -> None:
        """See `Engine`."""
        for worker in self._workers:
            worker.check()

    def close(self) -> None:
        """See `Engine`."""
        for worker in self._workers:
            worker.stop()
        for worker in self._workers:
            worker.join()


class _Worker:
    """A pool of one process, replaced when its process has died."""

    def __init__(self) -> None:
        self._pool: ProcessPool | None = None
        self._future: Future[list[Flown]] | None = None
        self._context = multiprocessing.get_context("spawn")
        self._starts = self._context.Value("i", 0)

    @property
    def is_free(self) -> bool:
        return self._future is None or self._future.done()

    @property
    def has_delivered(self) -> bool:
        return self._future is not None and self._future.exception() is None

    def fly(self, tables: Mapping[str, Any], jobs: Sequence[Job]) -> Future[list[Flown]]:
        if self._future is not None and not self.has_delivered:
            self.stop()
            self.join()
        for _ in range(2):  # a process that died while it had nothing to do is noticed here
            if self._pool is None:
                self._starts.value = 0
                self._pool = ProcessPool(
                    1, initializer=_begin, initargs=(self._starts,), context=self._context
                )
            with suppress(RuntimeError), _inherited():
                self._future = _followed(self._pool.schedule(fly_jobs, (tables, jobs)))
                return self._future
            self.stop()
            self.join()
        raise WorkerError("a worker process cannot be started")

    def check(self) -> None:
        """End a future that a pool has forgotten."""
        if self._pool is None or self._future is None:
            return
        error: Exception | None = None
        if not self._pool.active:  # the process died while the batch was handed over
            error = BrokenProcessPool("the process died")
        elif self._starts.value > 1:  # it ended with exit code 0 in a flight: to pebble that is no death
            error = ProcessExpired("ended in a flight", code=0)
        if error is not None:
            with suppress(InvalidStateError):
                self._future.set_exception(error)

    def stop(self) -> None:
        if self._pool is not None:
            self._pool.stop()

    def join(self) -> None:
        if self._pool is not None:
            self._pool.join()
        self._pool = self._future = None


def _followed(future: Future[list[Flown]]) -> Future[list[Flown]]:
    """A future that ends as that one does, or is ended before."""
    follower: Future[list[Flown]] = Future()

    def follow(ended: Future[list[Flown]]) -> None:
        error = CancelledError() if ended.cancelled() else ended.exception()
        with suppress(InvalidStateError):
            if error is None:
                follower.set_result(ended.result())
            else:
                follower.set_exception(error)

    future.add_done_callback(follow)
    return follower


def _begin(starts: Synchronized[int]) -> None:
    """In the worker: end at once when the coordinator wants it, and with it, however that ends.

    Args:
        starts: counts the processes that a pool has started.
    """
    with starts.get_lock():
        starts.value += 1
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


@contextmanager
def _inherited() -> Iterator[None]:
    """A process started in here keeps to one core, and leaves Ctrl-C to the coordinator from its start on."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT]) if os.name == "posix" else None
    try:
        yield
    finally:
        if mask is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
