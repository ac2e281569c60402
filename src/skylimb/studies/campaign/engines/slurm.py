"""Flies on jobs of a SLURM queue, one Dask worker a job, and notices jobs whose worker never comes.

dask-jobqueue submits the jobs and replaces those that end. It does not say why a job ended before its worker
came; SLURM is asked for that.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from skylimb.base.errors import extra_module
from skylimb.studies.campaign.engines import WorkerError
from skylimb.studies.campaign.engines.cluster import ClusterEngine

_DEATHS = 2
"""Deaths of a worker after which the scheduler lets a task have one last try."""

_DEFAULTS = {"cores": 1, "processes": 1, "memory": "2GB", "scheduler_options": {"dashboard_address": ":0"}}
"""Of a job, where dask-jobqueue's own configuration file says nothing."""

LOOK = 5.0
"""Seconds between two questions to SLURM while no worker is there."""

CONNECT = 180.0
"""Seconds that a running job may take until its worker is there."""

_WAITING = ("PENDING", "CONFIGURING", "REQUEUED", "SUSPENDED", "STOPPED", "RESIZING")
_FORGOTTEN = "FORGOTTEN"
"""Our word for the state of a job that SLURM knows no more, as happens some minutes after its end."""


class JobState(NamedTuple):
    """What SLURM says of a job.

    Attributes:
        state: such as PENDING, RUNNING, FAILED; or FORGOTTEN.
        exit_code: as SLURM writes it, code and signal: 127:0.
        output: the file that holds what it printed.
    """

    state: str
    exit_code: str = ""
    output: str = ""


def on_slurm(campaign: str, queue: str, workers: int) -> SlurmEngine:
    """An engine on jobs of a SLURM queue, one worker a job; the scheduler runs in this process.

    Args:
        campaign: as `Campaign.text` gives it.
        queue: SLURM's partition. Account, walltime and the like come from dask-jobqueue's own file.
        workers: how many jobs to ask for.

    Raises:
        WorkerError: when SLURM's commands are not there, or dask-jobqueue is not installed.
    """
    distributed, jobqueue = extra_module("distributed"), extra_module("dask_jobqueue")
    if shutil.which("sbatch") is None:
        raise WorkerError("SLURM's 'sbatch' is not on this machine's PATH; start on a login node")
    from dask import config

    config.set({"distributed.scheduler.allowed-failures": _DEATHS})
    settings = {
        name: value for name, value in _DEFAULTS.items() if not config.get(f"jobqueue.slurm.{name}", None)
    }
    cluster = jobqueue.SLURMCluster(queue=queue, **settings)
    # A job that ends, by its time limit for one, is replaced.
    cluster.adapt(minimum_jobs=workers, maximum_jobs=workers)
    return SlurmEngine(campaign, distributed.Client(cluster, set_as_default=False), cluster)


class SlurmEngine(ClusterEngine):
    """An engine of SLURM jobs. It watches those whose worker never came: to Dask their end is no death.

    Args:
        campaign: as `Campaign.text` gives it.
        client: connected to the cluster.
        cluster: of dask-jobqueue.
    """

    def __init__(self, campaign: str, client: Any, cluster: Any) -> None:
        super().__init__(campaign, client)
        self._cluster = cluster
        self._came: set[str] = set()
        self._running: dict[str, float] = {}
        self._last: dict[str, JobState] = {}
        self._looked = time.monotonic()

    def check(self) -> None:
        """Ask SLURM, now and then, where no worker is there.

        Raises:
            WorkerError: when no job waits or runs any more, or none of those that run has come to work.
        """
        super().check()
        working = {str(worker.name) for worker in list(self._cluster.scheduler.workers.values())}
        self._came |= working
        if working or time.monotonic() < self._looked + LOOK:
            return
        self._looked = time.monotonic()
        jobs = {str(name): job.job_id for name, job in list(self._cluster.workers.items())}
        # A job's workers are called NAME, or NAME-0, NAME-1. A job that has worked is replaced when it ends;
        # one without a number is being submitted.
        came = [name for name in jobs if any(f"{w}-".startswith(f"{name}-") for w in self._came)]
        if came or not all(jobs.values()):
            return
        lost = [str(job) for job in jobs.values() if self._is_lost(str(job))]
        if jobs and len(lost) == len(jobs):
            raise WorkerError(_described(lost[0], self._last[lost[0]], len(lost)))

    def close(self) -> None:
        """See `Engine`."""
        super().close()
        self._cluster.close()

    def _is_lost(self, job: str) -> bool:
        state = job_state(job)
        if state.state != _FORGOTTEN or job not in self._last:
            self._last[job] = state
        if state.state in _WAITING:
            self._running.pop(job, None)
            return False
        if state.state not in ("RUNNING", "COMPLETING"):
            return True
        return time.monotonic() > self._running.setdefault(job, time.monotonic()) + CONNECT


def job_state(job: str) -> JobState:
    """What SLURM says of a job now."""
    command = ["scontrol", "--oneliner", "show", "job", job]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return JobState("PENDING")  # nobody can say; a queue may be long
    if done.returncode != 0:
        return JobState(_FORGOTTEN if "nvalid job id" in done.stderr else "PENDING")
    fields = dict(re.findall(r"(\w+)=(\S*)", done.stdout))
    return JobState(fields.get("JobState", "PENDING"), fields.get("ExitCode", ""), fields.get("StdOut", ""))


def _described(job: str, state: JobState, count: int) -> str:
    what = "runs, but its worker has not come" if state.state == "RUNNING" else "ended before its worker came"
    code = f", exit code {state.exit_code}" if state.exit_code else ""
    more = f", and so did {count - 1} more" if count > 1 else ""
    output = f"; what it printed is in '{state.output}'" if state.output else ""
    words = _last_words(Path(state.output)) if state.output else ""
    return (
        f"SLURM job {job} {what} (state {state.state}{code}){more}{output}"
        f"{f', at the end: {words}' if words else ''}; what was flown is kept, and --resume goes on"
    )


def _last_words(path: Path) -> str:
    with suppress(OSError, UnicodeDecodeError):
        lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
        return lines[-1][:200] if lines else ""
    return ""
