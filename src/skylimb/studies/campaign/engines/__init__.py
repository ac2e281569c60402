"""Where flights are flown: in this process, in processes of this machine, or on a cluster.

An engine takes batches of jobs and hands out futures of what came of them. It keeps no results and flies
nothing twice: what to do about a worker that died is decided by the queue.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future

from skylimb.base.errors import ConfigError, SkylimbError, extra_module
from skylimb.studies.campaign.worker import Flown, Job, fly_jobs

MOST_WORKERS = 1024

DEATHS = 3
"""Workers that may die over a flight before it is quarantined."""


class WorkerError(SkylimbError):
    """Workers cannot be started or reached."""


class Engine:
    """What the queue asks of an engine. This one flies in the calling process, and has no workers to lose.

    Args:
        campaign: as `Campaign.text` gives it.
        slots: how many batches it can have in hand.
    """

    def __init__(self, campaign: str, slots: int = 1) -> None:
        self.campaign, self._slots = campaign, slots

    @property
    def slots(self) -> int:
        """How many batches it can have in hand."""
        return self._slots

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        """Fly a batch; at most `slots` batches may be on their way at a time."""
        future: Future[list[Flown]] = Future()
        future.set_result(fly_jobs(self.campaign, jobs))
        return future

    def deaths(self, error: BaseException) -> int | None:
        """How many workers have died over a batch whose future holds `error`.

        0: its worker died before it began. None: the error is no worker's death.
        """
        del error

    def check(self) -> None:
        """Look whether anything can still come back; called while nothing does.

        Raises:
            WorkerError: nothing will.
        """

    def close(self) -> None:
        """Let the workers go, also those that are flying."""


def make_engine(campaign: str, workers: int | None = None, scheduler: str = "", slurm: str = "") -> Engine:
    """The engine that a user asks for.

    Args:
        campaign: as `Campaign.text` gives it.
        workers: processes on this machine, one a core by default, 0 for none; or jobs on SLURM, 4 by default.
        scheduler: address of a Dask scheduler.
        slurm: a SLURM queue.

    Raises:
        WorkerError: nobody answers there.
        MissingExtraError: the extra `cluster` is wanted and not installed.
    """
    if scheduler:
        from skylimb.studies.campaign.engines.cluster import connect

        return connect(campaign, scheduler)
    if slurm:
        from skylimb.studies.campaign.engines.slurm import on_slurm

        return on_slurm(campaign, slurm, workers or 4)
    if workers == 0:
        return Engine(campaign)
    from skylimb.studies.campaign.engines.local import LocalEngine, cores

    return LocalEngine(campaign, workers or cores())


def check_workers(workers: int | None, scheduler: str = "", slurm: str = "") -> None:
    """Find out before anything is written whether `make_engine` can do something with these.

    Raises:
        ConfigError: values that it cannot take.
        MissingExtraError: the extra `cluster` is wanted and not installed.
    """
    if scheduler and slurm:
        raise ConfigError("scheduler and slurm exclude each other: choose one")
    if workers is not None and not 0 <= workers <= MOST_WORKERS:
        raise ConfigError(f"workers = {workers} must be 0 .. {MOST_WORKERS}")
    if scheduler or slurm:
        for package in ("distributed", "dask_jobqueue") if slurm else ("distributed",):
            extra_module(package)
