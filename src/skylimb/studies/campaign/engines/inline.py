"""Flies in the calling process: for a debugger, for tests, and where no process can be started."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from typing import Any

from skylimb.studies.campaign.bench import Flown, Job, fly_jobs


class InlineEngine:
    """An engine without workers.

    Args:
        tables: the campaign, as `Campaign.to_mapping` gives it.
    """

    slots = 1

    def __init__(self, tables: Mapping[str, Any]) -> None:
        self._tables = tables

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        """See `Engine`; the batch is flown here and now, however long it takes."""
        future: Future[list[Flown]] = Future()
        future.set_result(fly_jobs(self._tables, jobs))
        return future

    def deaths(self, error: BaseException) -> int | None:
        """See `Engine`; this process cannot outlive itself."""
        del error

    def check(self) -> None:
        """See `Engine`."""

    def close(self) -> None:
        """See `Engine`."""
