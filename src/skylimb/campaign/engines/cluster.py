"""Flies on a cluster of Dask workers.

Workers need the same skylimb installed (they check) and no shared disk: rows and logs come back over the
wire.
"""

from __future__ import annotations

import itertools
import queue
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from skylimb.campaign.bench import Job, fly_jobs
from skylimb.campaign.engines import Died, Done
from skylimb.campaign.engines.local import WorkerError

if TYPE_CHECKING:
    from distributed import Client, Future

_AHEAD = 2
"""Batches that are sent for each thread of a worker, so that it never waits for the next."""


class ClusterEngine:
    """An engine of Dask workers.

    Args:
        tables: the campaign, as `Campaign.to_mapping` gives it.
        client: connected to the scheduler.
        cluster: what to close with it, where this process has started it.
        check: called while nothing comes back; raises where nothing ever will.
    """

    def __init__(
        self,
        tables: Mapping[str, Any],
        client: Client,
        cluster: Any = None,
        check: Callable[[], None] | None = None,
    ) -> None:
        self._tables, self._client, self._cluster = dict(tables), client, cluster
        self._check = check
        self._flying: dict[Future, Sequence[Job]] = {}
        self._finished: queue.Queue[Future] = queue.Queue()
        self._numbers = itertools.count()

    @property
    def free(self) -> int:
        """See `Engine`."""
        workers: Any = self._client.nthreads()
        threads = sum(workers.values())
        return max(_AHEAD * threads, 1) - len(self._flying)

    @property
    def flying(self) -> int:
        """See `Engine`."""
        return len(self._flying)

    def submit(self, jobs: Sequence[Job]) -> bool:
        """See `Engine`."""
        key = f"skylimb-{id(self)}-{next(self._numbers)}"
        future: Any = self._client.submit(fly_jobs, self._tables, list(jobs), key=key, pure=False)
        self._flying[future] = jobs
        future.add_done_callback(self._finished.put)
        return True

    def wait(self, timeout: float) -> list[Done | Died]:
        """See `Engine`."""
        from distributed.scheduler import KilledWorker

        events: list[Done | Died] = []
        for future in self._arrived(timeout):
            jobs = self._flying.pop(future)
            if future.status in ("cancelled", "lost"):
                raise WorkerError("the connection to the cluster's scheduler is lost")
            try:
                events.append(Done(jobs, future.result()))
            except KilledWorker:
                events.append(Died(jobs, final=True))
        return events

    def _arrived(self, timeout: float) -> list[Future]:
        """Futures that are through, after at most `timeout` seconds."""
        arrived: list[Future] = []
        with suppress(queue.Empty):
            arrived.append(self._finished.get(timeout=timeout))
            while True:
                arrived.append(self._finished.get_nowait())
        if not arrived and self._client.status != "running":
            raise WorkerError("the connection to the cluster's scheduler is lost")
        if not arrived and self._check is not None:
            self._check()
        return arrived

    def close(self, now: bool = False) -> None:
        """See `Engine`."""
        if now:
            self._client.cancel(list(self._flying))
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()


def connect(tables: Mapping[str, Any], address: str) -> ClusterEngine:
    """An engine on a scheduler that runs, such as tcp://HOST:8786.

    Raises:
        WorkerError: when nobody answers there, or Dask is not installed.
    """
    distributed = imported("distributed")
    try:
        return ClusterEngine(tables, distributed.Client(address, timeout="5s", set_as_default=False))
    except (OSError, ValueError) as error:
        raise WorkerError(f"no Dask scheduler answers at '{address}': {_line(error)}") from error


def imported(name: str) -> Any:
    """A module of the extra `cluster`.

    Raises:
        WorkerError: when it is not installed.
    """
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        raise WorkerError(f"'{name}' is not installed: pip install 'skylimb[cluster]'") from None


def _line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
