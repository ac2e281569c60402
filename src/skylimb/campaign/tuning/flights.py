"""Flies sets of gains over draws; a flight that was flown before is not flown again."""

from __future__ import annotations

import time
from collections.abc import Sequence

from skylimb.campaign.bench import Job
from skylimb.campaign.coordinator import DEATHS, Progress, Report, StopSign
from skylimb.campaign.engines import Died, Done, Engine
from skylimb.campaign.frozen import Campaign
from skylimb.campaign.rows import QUARANTINED, Row, make_row
from skylimb.campaign.tuning.folder import Memory
from skylimb.campaign.tuning.gains import Gains


class Stopped(Exception):  # noqa: N818 - it is no error
    """Ctrl-C has ended the search; what was flown is kept."""


class Flights:
    """Flies sets of gains over draws, remembers every flight, and tells how far it is.

    Args:
        campaign: what is flown.
        engine: flies.
        memory: what was flown before, and where it is kept.
        total: flights that will be asked for at most.
        stop: watched; when it is raised, what flies is finished and kept.
        report: told how far it is.
    """

    def __init__(
        self, campaign: Campaign, engine: Engine, memory: Memory, total: int, stop: StopSign, report: Report
    ) -> None:
        self.campaign = campaign
        self._engine, self._memory, self._stop, self._report = engine, memory, stop, report
        self._total, self._begun, self._flown = total, time.monotonic(), 0
        self._deaths: dict[Job, int] = {}

    def fly(self, wanted: Sequence[tuple[str, Gains, range]]) -> list[list[Row]]:
        """The rows of each controller with these gains over these draws, in the order given.

        Raises:
            Stopped: when Ctrl-C came before all had flown.
        """
        order = [
            [
                Job(self.campaign.flight(draw, self.campaign.names.index(name)), tuple(sorted(gains.items())))
                for draw in draws
            ]
            for name, gains, draws in wanted
        ]
        rows = self._memory.rows
        # Equal jobs, the same gains asked for twice, fly once.
        queue = list(dict.fromkeys(job for jobs in order for job in jobs if job not in rows))[::-1]
        self._tell()
        while (queue and not self._stop.raised) or self._engine.flying:
            while queue and self._engine.free > 0 and not self._stop.raised:
                job = queue.pop()
                if not self._engine.submit((job,)):
                    queue.append(job)
            for event in self._engine.wait(0.5):
                queue[:0] = self._keep(event)
            self._tell()
        if queue:
            raise Stopped
        return [[rows[job] for job in jobs] for jobs in order]

    def _keep(self, event: Done | Died) -> list[Job]:
        """Keep what came back; jobs that must fly again."""
        if isinstance(event, Done):
            self._memory.add({job: flown.row for job, flown in zip(event.jobs, event.flown, strict=True)})
            self._flown += len(event.jobs)
            return []
        again = []
        for job in event.jobs:
            self._deaths[job] = self._deaths.get(job, 0) + 1
            if self._deaths[job] < DEATHS:
                again.append(job)
                continue
            row = make_row(
                self.campaign, job.flight, QUARANTINED, f"its worker process died {DEATHS} times", {}
            )
            self._memory.add({job: row})
        return again

    def _tell(self) -> None:
        seconds = time.monotonic() - self._begun
        self._report(
            Progress(len(self._memory.rows), self._total, 0, self._flown, seconds, self._stop.raised)
        )
