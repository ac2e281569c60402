"""Flies on this machine's cores, a process each.

Every worker is a pool of its own with one process in it, so that the death of a process breaks one pool and
names the jobs it had in hand. A worker is warmed up first: it takes jobs only when its imports are done,
and a death before that is charged to nobody.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing.connection import wait as wait_for_end
from typing import Any, NamedTuple

from skylimb.campaign.bench import Flown, Job, fly_jobs
from skylimb.campaign.engines import Died, Done
from skylimb.errors import SkylimbError

_STILLBORN = 5
"""Workers in a row that die before they are ready, after which it isn't bad luck."""


_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables by which libraries for linear algebra are told how many threads to start."""


class WorkerError(SkylimbError):
    """Workers cannot be started or reached."""


class LocalEngine:
    """An engine of worker processes.

    Args:
        tables: the campaign, as `Campaign.to_mapping` gives it.
        workers: how many processes.
    """

    def __init__(self, tables: Mapping[str, Any], workers: int) -> None:
        self._tables, self._missing = tables, workers
        self._stillborn = 0
        self._warming: dict[Future[int], ProcessPoolExecutor] = {}
        self._ready: list[_Worker] = []
        self._flying: dict[Future[list[Flown]], tuple[_Worker, Sequence[Job]]] = {}

    @property
    def free(self) -> int:
        """See `Engine`; the first call starts the workers."""
        while self._missing:
            self._missing -= 1
            self._start()
        return len(self._ready)

    @property
    def flying(self) -> int:
        """See `Engine`."""
        return len(self._flying)

    def submit(self, jobs: Sequence[Job]) -> bool:
        """See `Engine`."""
        worker = self._ready.pop()
        try:
            self._flying[worker.pool.submit(fly_jobs, self._tables, jobs)] = (worker, jobs)
        except BrokenProcessPool:  # it died while it had nothing to do
            self._replace(worker.pool)
            return False
        return True

    def wait(self, timeout: float) -> list[Done | Died]:
        """See `Engine`."""
        pending: list[Future[Any]] = [*self._flying, *self._warming]
        finished, _ = wait(pending, timeout, FIRST_COMPLETED)
        events: list[Done | Died] = []
        for future in finished:
            if future in self._warming:
                self._warmed(self._warming.pop(future), future)
                continue
            worker, jobs = self._flying.pop(future)
            try:
                flown = future.result()
            except BrokenProcessPool:
                self._replace(worker.pool)
                events.append(Died(jobs))
            else:
                self._ready.append(worker)
                events.append(Done(jobs, flown))
        return events

    def close(self, now: bool = False) -> None:
        """See `Engine`."""
        busy = [worker for worker, _ in self._flying.values()]
        if now:
            for worker in busy:
                with suppress(ProcessLookupError):
                    os.kill(worker.pid, signal.SIGTERM)
        for pool in [*(worker.pool for worker in (*self._ready, *busy)), *self._warming.values()]:
            pool.shutdown(wait=not now, cancel_futures=True)

    def _start(self) -> None:
        pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin)
        with _deaf_to_interrupts(), _single_threaded():
            self._warming[pool.submit(_warm, self._tables)] = pool

    def _warmed(self, pool: ProcessPoolExecutor, future: Future[int]) -> None:
        try:
            pid = future.result()
        except BrokenProcessPool:
            self._stillborn += 1
            if self._stillborn >= _STILLBORN:
                raise WorkerError(
                    f"{_STILLBORN} worker processes in a row died while starting; a script that starts a "
                    'campaign needs `if __name__ == "__main__":` around the call'
                ) from None
            self._replace(pool)
        else:
            self._stillborn = 0
            self._ready.append(_Worker(pool, pid))

    def _replace(self, pool: ProcessPoolExecutor) -> None:
        pool.shutdown(wait=False)
        self._start()


class _Worker(NamedTuple):
    pool: ProcessPoolExecutor
    pid: int


def _begin() -> None:
    """In the worker: leave Ctrl-C to the coordinator, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait_for_end([sentinel])
    os._exit(1)


def _warm(tables: Mapping[str, Any]) -> int:
    """In the worker: import and load what flights need. Returns the process's id."""
    fly_jobs(tables, ())
    return os.getpid()


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """A process started in here inherits that Ctrl-C is ignored, before its own first line runs."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _single_threaded() -> Iterator[None]:
    """A process started in here keeps to one core: threads that wait for work would take the others' time."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
