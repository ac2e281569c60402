"""Flies on a cluster of Dask workers.

Workers need the same skylimb installed (they check) and no shared disk: rows and logs come back over the
wire.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, Future
from typing import TYPE_CHECKING, Any

from skylimb.base.errors import missing_extra
from skylimb.studies.campaign.bench import Flown, Job, fly_jobs
from skylimb.studies.campaign.engines import DEATHS, WorkerError

if TYPE_CHECKING:
    from distributed import Client

_AHEAD = 2
"""Batches that are sent for each thread of a worker, so that it never waits for the next."""


class ClusterEngine:
    """An engine of Dask workers.

    Args:
        tables: the campaign, as `Campaign.to_mapping` gives it.
        client: connected to the scheduler.
        cluster: what to close with it, where this process has started it.
        watch: called while nothing comes back; raises where nothing ever will.
    """

    def __init__(
        self,
        tables: Mapping[str, Any],
        client: Client,
        cluster: Any = None,
        watch: Callable[[], None] | None = None,
    ) -> None:
        self._tables, self._client, self._cluster, self._watch = dict(tables), client, cluster, watch
        self._executor = client.get_executor(pure=False)

    @property
    def slots(self) -> int:
        """See `Engine`."""
        threads: Any = self._client.nthreads()
        return max(_AHEAD * sum(threads.values()), 1)

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        """See `Engine`."""
        return self._executor.submit(fly_jobs, self._tables, list(jobs))

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
        if self._watch is not None:
            self._watch()

    def close(self) -> None:
        """See `Engine`."""
        self._executor.shutdown(wait=False)
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()


def connect(tables: Mapping[str, Any], address: str) -> ClusterEngine:
    """An engine on a scheduler that runs, such as tcp://HOST:8786.

    Raises:
        WorkerError: when nobody answers there.
        MissingExtraError: when Dask is not installed.
    """
    distributed = imported("distributed")
    try:
        return ClusterEngine(tables, distributed.Client(address, timeout="5s", set_as_default=False))
    except (OSError, ValueError) as error:
        first = (str(error).splitlines() or [type(error).__name__])[0]
        raise WorkerError(f"no Dask scheduler answers at '{address}': {first}") from error


def imported(name: str) -> Any:
    """A module of the extra `cluster`.

    Raises:
        MissingExtraError: when it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise missing_extra(name, "cluster") from None
