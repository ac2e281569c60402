"""Flies on a cluster of Dask workers.

Workers need the same skylimb installed (they check) and no shared disk: rows and logs come back over the
wire.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import CancelledError, Future
from typing import TYPE_CHECKING, Any

from skylimb.base.errors import extra_module, first_line
from skylimb.studies.campaign.engines import DEATHS, Engine, WorkerError
from skylimb.studies.campaign.worker import Flown, Job, fly_jobs

if TYPE_CHECKING:
    from distributed import Client

_AHEAD = 2
"""Batches that are sent for each thread of a worker, so that it never waits for the next."""


class ClusterEngine(Engine):
    """An engine of Dask workers.

    Args:
        campaign: as `Campaign.text` gives it.
        client: connected to the scheduler.
    """

    def __init__(self, campaign: str, client: Client) -> None:
        super().__init__(campaign)
        self._client, self._executor = client, client.get_executor(pure=False)

    @property
    def slots(self) -> int:
        """See `Engine`."""
        threads: Any = self._client.nthreads()
        return max(_AHEAD * sum(threads.values()), 1)

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        """See `Engine`."""
        return self._executor.submit(fly_jobs, self.campaign, list(jobs))

    def deaths(self, error: BaseException) -> int | None:
        """See `Engine`; Dask itself tries a batch again before it gives up."""
        from distributed.scheduler import KilledWorker

        if isinstance(error, CancelledError):
            raise WorkerError("the connection to the cluster's scheduler is lost")
        return DEATHS if isinstance(error, KilledWorker) else None

    def check(self) -> None:
        """See `Engine`."""
        if self._client.status != "running":
            raise WorkerError("the connection to the cluster's scheduler is lost")

    def close(self) -> None:
        """See `Engine`."""
        self._executor.shutdown(wait=False)
        self._client.close()


def connect(campaign: str, address: str) -> ClusterEngine:
    """An engine on a scheduler that runs, such as tcp://HOST:8786.

    Raises:
        WorkerError: when nobody answers there.
        MissingExtraError: when Dask is not installed.
    """
    distributed = extra_module("distributed")
    try:
        return ClusterEngine(campaign, distributed.Client(address, timeout="5s", set_as_default=False))
    except (OSError, ValueError) as error:
        raise WorkerError(f"no Dask scheduler answers at '{address}': {first_line(error)}") from error
