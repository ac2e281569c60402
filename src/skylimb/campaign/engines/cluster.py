"""Flies on a cluster: on Dask workers that run already, or on ones that SLURM starts.

Workers need the same skylimb installed (they check) and no shared disk: rows and logs come back over the
wire.
"""

from __future__ import annotations

import itertools
import queue
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from skylimb.campaign.bench import Job, fly_jobs
from skylimb.campaign.engines import Died, Done
from skylimb.campaign.engines.local import WorkerError

if TYPE_CHECKING:
    from distributed import Client, Future

_AHEAD = 2
"""Batches that are sent for each thread of a worker, so that it never waits for the next."""

_DEATHS = 2
"""Deaths of a worker after which the scheduler lets a task have one last try."""


class ClusterEngine:
    """An engine of Dask workers.

    Args:
        tables: the campaign, as `Campaign.to_mapping` gives it.
        client: connected to the scheduler.
        cluster: what to close with it, where this process has started it.
    """

    def __init__(self, tables: Mapping[str, Any], client: Client, cluster: Any = None) -> None:
        self._tables, self._client, self._cluster = dict(tables), client, cluster
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
    distributed = _imported("distributed")
    try:
        return ClusterEngine(tables, distributed.Client(address, timeout="5s", set_as_default=False))
    except (OSError, ValueError) as error:
        raise WorkerError(f"no Dask scheduler answers at '{address}': {_line(error)}") from error


def on_slurm(
    tables: Mapping[str, Any], queue: str, workers: int, options: Mapping[str, Any]
) -> ClusterEngine:
    """An engine on jobs of a SLURM queue, one worker a job; the scheduler runs in this process.

    Args:
        tables: the campaign.
        queue: SLURM's partition.
        workers: how many jobs to ask for.
        options: of `dask_jobqueue.SLURMCluster`, such as walltime or account; its own configuration file,
            where there is one, gives the rest.

    Raises:
        WorkerError: when SLURM's commands are not there, or dask-jobqueue is not installed.
    """
    import shutil

    distributed, jobqueue = _imported("distributed"), _imported("dask_jobqueue")
    if shutil.which("sbatch") is None:
        raise WorkerError("SLURM's 'sbatch' is not on this machine's PATH; start on a login node")
    from dask import config

    config.set({"distributed.scheduler.allowed-failures": _DEATHS})
    settings = {"cores": 1, "processes": 1, "memory": "2GB", "walltime": "04:00:00", **options}
    settings.setdefault("scheduler_options", {"dashboard_address": ":0"})
    cluster = jobqueue.SLURMCluster(queue=queue, **settings)
    # A job that ends, by its time limit for one, is replaced.
    cluster.adapt(minimum_jobs=workers, maximum_jobs=workers)
    return ClusterEngine(tables, distributed.Client(cluster, set_as_default=False), cluster)


def _imported(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        raise WorkerError(f"'{name}' is not installed: pip install 'skylimb[cluster]'") from None


def _line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
