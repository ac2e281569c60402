"""Flies what is missing of a campaign, block by block, and keeps everything that comes back."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FrameType

from skylimb.campaign.bench import Flown, Job
from skylimb.campaign.engines import Died, Done, Engine
from skylimb.campaign.frozen import Campaign
from skylimb.campaign.logs import log_flag, wanted_logs
from skylimb.campaign.rows import LOST, QUARANTINED, Row, make_row
from skylimb.campaign.stopping import enough, looks
from skylimb.campaign.store import Store, logged
from skylimb.errors import OutputError

DEATHS = 3
"""Workers that a flight may take down before it is quarantined."""

_TICK = 0.5
"""Seconds between two signs of life."""


@dataclass
class Progress:
    """How far a campaign is.

    Attributes:
        done: flights that are in the table.
        total: flights that it will take at most.
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


Report = Callable[[Progress], None]


@dataclass
class StopSign:
    """Raised by Ctrl-C: the first time nothing new takes off, the second time nothing is waited for."""

    raised: bool = False
    notes: list[str] = field(default_factory=list)


def fly_missing(
    campaign: Campaign, store: Store, engine: Engine, report: Report, stop: StopSign, batch: int = 1
) -> int | None:
    """Fly every flight that the store lacks, until the draws or the stopping rule are through.

    Args:
        campaign: what to fly.
        store: where rows are and go.
        engine: flies.
        report: told how far it is.
        stop: watched; when it is raised, what flies is finished and kept.
        batch: flights that are handed to a worker at once.

    Returns:
        The number of draws that the campaign has when it is through, None when it was stopped.
    """
    for draws in looks(campaign):
        # Rows of later draws, flown before a kill under the same rule, do not stand in the way of a look.
        missing = [f for f in range(campaign.flight(draws, 0)) if f not in store.rows]
        if not _fly(
            campaign, store, engine, [Job(f, log=log_flag(campaign)) for f in missing], report, stop, batch
        ):
            return None
        if enough(campaign, store.rows, draws):
            return draws
    return campaign.spec.draws


def fly_logs(campaign: Campaign, store: Store, engine: Engine, report: Report, stop: StopSign) -> bool:
    """Fly again those flights whose log is wanted and not there: the worst are known only at the end.

    Returns:
        False when it was stopped.

    Raises:
        OutputError: when a flight gave another row than before, which no log could stand for.
    """
    wanted = wanted_logs(campaign, store.rows)
    missing = set(wanted) - logged(store.folder, (store.rows[f] for f in wanted))
    return _fly(campaign, store, engine, [Job(f, log="always") for f in sorted(missing)], report, stop, 1)


def _fly(
    campaign: Campaign,
    store: Store,
    engine: Engine,
    jobs: Sequence[Job],
    report: Report,
    stop: StopSign,
    batch: int,
) -> bool:
    queue = deque(tuple(jobs[i : i + batch]) for i in range(0, len(jobs), batch))
    total, begun, flown = campaign.flight(campaign.spec.draws, 0), time.monotonic(), 0
    failures = sum(row["status"] in LOST for row in store.rows.values())

    def tell() -> None:
        seconds = time.monotonic() - begun
        report(Progress(len(store.rows), total, failures, flown, seconds, stop.raised))

    tell()
    while (queue and not stop.raised) or engine.flying:
        while queue and engine.free > 0 and not stop.raised:
            handed = queue.popleft()
            if not engine.submit(handed):
                queue.appendleft(handed)
        for event in engine.wait(_TICK):
            rows = _keep(store, event) if isinstance(event, Done) else _bury(campaign, store, event, queue)
            failures += sum(row["status"] in LOST for row in rows)
            flown += len(rows)
        tell()
    return not queue


def _keep(store: Store, event: Done) -> list[Row]:
    fresh: list[Flown] = []
    for item in event.flown:
        known = store.rows.get(item.row["flight"])
        if known is None:
            fresh.append(item)
        elif known != item.row:
            raise OutputError(
                f"flight {known['flight']} gave another result when it was flown again "
                f"({known['checksum'][:8]}, now {item.row['checksum'][:8]}); it depends on something outside "
                "of its configuration"
            )
        elif item.log is not None:
            store.keep_log(item.row, item.log)
    store.add(fresh)
    return [item.row for item in fresh]


def _bury(campaign: Campaign, store: Store, event: Died, queue: deque[tuple[Job, ...]]) -> list[Row]:
    """Queue the jobs of a dead worker again, one by one; a flight that does it too often is given up."""
    if len(event.jobs) > 1:
        queue.extendleft((job,) for job in event.jobs)
        return []
    given_up = []
    for job in event.jobs:
        if not event.final and store.add_death(job.flight) < DEATHS:
            queue.append((job,))
            continue
        if job.flight in store.rows:  # it has flown before and was only to give its log
            continue
        cause = f"its worker process died {DEATHS} times"
        given_up.append(Flown(make_row(campaign, job.flight, QUARANTINED, cause, {}), None))
    store.add(given_up)
    return [item.row for item in given_up]


@contextmanager
def watching_interrupts(stop: StopSign) -> Iterator[None]:
    """Raise `stop` at the first SIGINT or SIGTERM, a KeyboardInterrupt at the second; main thread only."""
    import signal

    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def on_signal(number: int, frame: FrameType | None) -> None:
        del frame
        if stop.raised:
            raise KeyboardInterrupt
        stop.raised = True

    before = {number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
