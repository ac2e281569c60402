"""Flies in the calling process: for a debugger, for tests, and where no process can be started."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from skylimb.campaign.bench import Job, fly_jobs
from skylimb.campaign.engines import Died, Done


class InlineEngine:
    """An engine without workers.

    Args:
        tables: the campaign, as `Campaign.to_mapping` gives it.
    """

    def __init__(self, tables: Mapping[str, Any]) -> None:
        self._tables = tables
        self._jobs: deque[Sequence[Job]] = deque()

    @property
    def free(self) -> int:
        """See `Engine`."""
        return 1 - len(self._jobs)

    @property
    def flying(self) -> int:
        """See `Engine`."""
        return len(self._jobs)

    def submit(self, jobs: Sequence[Job]) -> bool:
        """See `Engine`."""
        self._jobs.append(jobs)
        return True

    def wait(self, timeout: float) -> list[Done | Died]:
        """See `Engine`; a batch is flown here and now, however long it takes."""
        del timeout
        jobs = self._jobs.popleft()
        return [Done(jobs, fly_jobs(self._tables, jobs))]

    def close(self, now: bool = False) -> None:
        """See `Engine`."""
