"""The queue of flights: hands jobs to an engine and keeps everything that comes back.

Campaigns and searches fly through this one queue. It knows no draws and no statistics.
"""

from __future__ import annotations

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Event
from types import FrameType

from skylimb.base.errors import OutputError
from skylimb.base.interrupts import ENDS, answering, insists
from skylimb.studies.campaign.engines import DEATHS, Engine, WorkerError
from skylimb.studies.campaign.rows import LOST, QUARANTINED, make_row
from skylimb.studies.campaign.store import Key, Store
from skylimb.studies.campaign.worker import Flown, Job

BATCH = 4
"""Flights that a worker gets at once: the native driver flies them side by side."""

_PAUSE = 0.5
"""Seconds between two signs of life."""


@dataclass
class CampaignProgress:
    """How far a campaign or a search is.

    Attributes:
        done: flights that are kept.
        total: flights that it takes at most.
        failures: of those done.
        flown: since this process began; with `seconds` it gives the rate.
        seconds: since the first flight was handed out.
        stopping: whether it only waits for what is in the air.
    """

    done: int
    total: int
    failures: int
    flown: int = 0
    seconds: float = 0.0
    stopping: bool = False


Report = Callable[[CampaignProgress], None]


class Interrupted(Exception):  # noqa: N818 - it is no error
    """Ctrl-C came before all had flown; what was flown is kept."""


class FlightQueue:
    """Flies jobs until each has its row in the store.

    Args:
        store: where rows are and go.
        engine: flies.
        stop: watched; when it is set, what flies is finished and kept.
        report: called with the progress, twice a second or more often.
        total: flights that it takes at most, for the progress.
    """

    def __init__(
        self, store: Store, engine: Engine, stop: threading.Event, report: Report, total: int
    ) -> None:
        self.store = store
        self._engine, self._stop, self._report, self._total = engine, stop, report, total
        self._begun, self._before = time.monotonic(), len(store.rows)
        self._failures = sum(row["status"] in LOST for row in store.rows.values())
        self._deaths: Counter[Key] = Counter()

    def fly(self, jobs: Sequence[Job]) -> None:
        """Fly jobs, in any order and at any number of workers.

        Raises:
            Interrupted: Ctrl-C came before all had flown.
            OutputError: when a flight that had flown before gave another row, or the disk is full.
        """
        size = max(1, min(BATCH, len(jobs) // self._engine.slots))
        waiting: deque[Sequence[Job]] = deque(jobs[i : i + size] for i in range(0, len(jobs), size))
        flying: dict[Future[list[Flown]], Sequence[Job]] = {}
        self._show()
        while flying or (waiting and not self._stop.is_set()):
            free = self._engine.slots - len(flying)
            while waiting and free > 0 and not self._stop.is_set():
                batch, free = waiting.popleft(), free - 1
                flying[self._engine.submit(batch)] = batch
            ended = wait(flying, _PAUSE, FIRST_COMPLETED).done
            for future in ended:
                self._take(flying.pop(future), future, waiting)
            if not ended:
                self._engine.check()
            self._show()
        if waiting:
            raise Interrupted

    def _take(self, batch: Sequence[Job], future: Future[list[Flown]], waiting: deque[Sequence[Job]]) -> None:
        """Keep what came back; jobs whose worker has died wait again."""
        error = CancelledError() if future.cancelled() else future.exception()
        if error is None:
            self._keep(list(zip(batch, future.result(), strict=True)))
            return
        deaths = self._engine.deaths(error)
        if deaths is None:
            if isinstance(error, Exception):
                raise error
            raise WorkerError(f"a flight of {[job.flight for job in batch]} ended its worker: {error!r}")
        if deaths == 0 or len(batch) > 1:  # one of several did it: each flies alone now
            waiting.extendleft((job,) for job in batch)
            return
        (job,) = batch
        self._deaths[job.key] += deaths
        if self._deaths[job.key] < DEATHS:
            waiting.append(batch)
        elif job.key not in self.store.rows:  # otherwise it has flown before and was only to give its log
            cause = f"its worker process died {DEATHS} times"
            self._keep(
                [(job, Flown(make_row(self.store.campaign, job.flight, QUARANTINED, cause, {}), None))]
            )

    def _keep(self, flown: Sequence[tuple[Job, Flown]]) -> None:
        fresh = []
        for job, item in flown:
            known = self.store.rows.get(job.key)
            if known is None:
                fresh.append((job, item))
            elif known != item.row:
                raise OutputError(
                    f"flight {job.flight} gave another result when it was flown again; it depends on "
                    "something outside of its configuration"
                )
            elif item.log is not None:
                self.store.keep_log(item.row, item.log, item.files)
        self.store.add(fresh)
        self._failures += sum(item.row["status"] in LOST for _, item in fresh)

    def _show(self) -> None:
        done, seconds = len(self.store.rows), time.monotonic() - self._begun
        flown, stopping = done - self._before, self._stop.is_set()
        self._report(CampaignProgress(done, self._total, self._failures, flown, seconds, stopping))


@contextmanager
def watching_interrupts() -> Iterator[Event]:
    """What the first of `ENDS` sets; a second one that insists is a KeyboardInterrupt. Main thread only."""
    stop = Event()

    def on_signal(number: int, frame: FrameType | None) -> None:
        del frame
        if stop.is_set() and insists(number):
            raise KeyboardInterrupt
        stop.set()

    with answering(ENDS, on_signal):
        yield stop
