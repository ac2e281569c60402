"""Flies in the calling process: for a debugger, for tests, and where no process can be started."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future

from skylimb.studies.campaign.engines import Engine
from skylimb.studies.campaign.worker import Flown, Job, fly_jobs


class InlineEngine(Engine):
    """An engine without workers; see `Engine`."""

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        """See `Engine`; the batch is flown at once, however long it takes."""
        future: Future[list[Flown]] = Future()
        future.set_result(fly_jobs(self._campaign, jobs))
        return future
