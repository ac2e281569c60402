"""Flies on jobs of a SLURM queue, one Dask worker a job, and notices jobs that never come to work."""

from __future__ import annotations

import re
import shutil
import subprocess
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from skylimb.campaign.engines.cluster import ClusterEngine, imported
from skylimb.campaign.engines.local import WorkerError

_DEATHS = 2
"""Deaths of a worker after which the scheduler lets a task have one last try."""

_DEFAULTS = {"cores": 1, "processes": 1, "memory": "2GB"}
"""Of a job, where dask-jobqueue's own configuration file says nothing."""

LOOK = 5.0
"""Seconds between two questions to SLURM while no worker is there."""

CONNECT = 180.0
"""Seconds that a running job may take until its worker is there."""

_WAITING = ("PENDING", "CONFIGURING", "REQUEUED", "SUSPENDED", "STOPPED", "RESIZING")
_GONE = "gone"
"""State of a job that SLURM has forgotten, as it does some minutes after the end."""


class JobState(NamedTuple):
    """What SLURM says of a job.

    Attributes:
        state: such as PENDING, RUNNING, FAILED; "gone" where SLURM knows it no more.
        exit_code: as SLURM writes it, code and signal: 127:0.
        output: the file that holds what it printed.
    """

    state: str
    exit_code: str = ""
    output: str = ""


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
    distributed, jobqueue = imported("distributed"), imported("dask_jobqueue")
    if shutil.which("sbatch") is None:
        raise WorkerError("SLURM's 'sbatch' is not on this machine's PATH; start on a login node")
    from dask import config

    config.set({"distributed.scheduler.allowed-failures": _DEATHS})
    configured = {name: config.get(f"jobqueue.slurm.{name}", None) for name in _DEFAULTS}
    said = {name: value for name, value in configured.items() if value is not None}
    settings = {**_DEFAULTS, **said, **options}
    settings.setdefault("scheduler_options", {"dashboard_address": ":0"})
    cluster = jobqueue.SLURMCluster(queue=queue, **settings)
    # A job that ends, by its time limit for one, is replaced.
    cluster.adapt(minimum_jobs=workers, maximum_jobs=workers)
    client = distributed.Client(cluster, set_as_default=False)
    return ClusterEngine(tables, client, cluster, JobWatch(cluster).check)


class JobWatch:
    """Looks after jobs whose worker has never been there.

    A job that ends before that is no worker's death to the scheduler: it would wait for ever.

    Args:
        cluster: of dask-jobqueue.
    """

    def __init__(self, cluster: Any) -> None:
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
        working = [str(worker.name) for worker in list(self._cluster.scheduler.workers.values())]
        self._came.update(working)
        if working or time.monotonic() < self._looked + LOOK:
            return
        self._looked = time.monotonic()
        missing = [
            str(job.job_id)
            for name, job in list(self._cluster.workers.items())
            if job.job_id and not self._has_come(str(name))
        ]
        if not missing or len(missing) < len(self._cluster.workers):
            return  # one that has worked before is replaced when it ends
        states = {job: self._ask(job) for job in missing}
        lost = [job for job, state in states.items() if self._is_lost(job, state)]
        if len(lost) == len(missing):
            raise WorkerError(_told(lost[0], self._last[lost[0]], len(lost)))

    def _has_come(self, name: str) -> bool:
        return any(worker == name or worker.startswith(f"{name}-") for worker in self._came)

    def _ask(self, job: str) -> JobState:
        state = job_state(job)
        if state.state != _GONE or job not in self._last:
            self._last[job] = state
        return state

    def _is_lost(self, job: str, state: JobState) -> bool:
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
        return JobState(_GONE if "nvalid job id" in done.stderr else "PENDING")
    fields = dict(re.findall(r"(\w+)=(\S*)", done.stdout))
    return JobState(fields.get("JobState", "PENDING"), fields.get("ExitCode", ""), fields.get("StdOut", ""))


def _told(job: str, state: JobState, count: int) -> str:
    what = "runs, but its worker has not come" if state.state == "RUNNING" else "ended before its worker came"
    said = [f"SLURM job {job} {what} (state {state.state}"]
    said.append(f", exit code {state.exit_code})" if state.exit_code else ")")
    if count > 1:
        said.append(f", and so did {count - 1} more")
    if state.output:
        said.append(f"; what it printed is in '{state.output}'")
        words = _last_words(Path(state.output))
        said.append(f", at the end: {words}" if words else "")
    return "".join([*said, "; what was flown is kept, and --resume goes on"])


def _last_words(path: Path) -> str:
    with suppress(OSError, UnicodeDecodeError):
        return _last(path.read_text(encoding="utf-8").splitlines())
    return ""


def _last(lines: Iterable[str]) -> str:
    spoken = [line.strip() for line in lines if line.strip()]
    return spoken[-1][:200] if spoken else ""
