import os
import signal
import stat
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from skylimb.base.errors import SkylimbError
from skylimb.studies.campaign import run_campaign
from skylimb.studies.campaign.folder import load_campaign
from skylimb.studies.campaign.store import load_rows

distributed = pytest.importorskip("distributed")

SpecWriter = Callable[..., Path]

SBATCH = """#!/bin/sh
# Stands for SLURM: keeps a copy of the job's script, as SLURM does, and runs it at once on this machine.
script=$(mktemp "$SLURM_STAND_IN/job.XXXXXX")
cp "$1" "$script"
sh "$script" >"$script.out" 2>&1 &
ln -sf "$script.out" "$SLURM_STAND_IN/last.out"
echo "Submitted batch job $!"
"""


SCONTROL = """#!/bin/sh
# Stands for SLURM: a job is over when its process is; the last word of the call is its number.
for job; do :; done
if kill -0 "$job" 2>/dev/null; then state=RUNNING; else state=FAILED; fi
echo "JobId=$job JobState=$state ExitCode=127:0 StdOut=$SLURM_STAND_IN/last.out"
"""


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Commands that stand for SLURM's, first on the PATH; the folder that they are in."""
    pytest.importorskip("dask_jobqueue")
    commands, spool = tmp_path / "bin", tmp_path / "spool"
    commands.mkdir()
    spool.mkdir()
    stand_ins = {
        "sbatch": SBATCH,
        "scontrol": SCONTROL,
        "scancel": '#!/bin/sh\nkill "$@" 2>/dev/null\ntrue\n',
    }
    for name, text in stand_ins.items():
        path = commands / name
        path.write_text(text)
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("SLURM_STAND_IN", str(spool))
    monkeypatch.setenv(
        "PATH", f"{commands}{os.pathsep}{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    )
    return commands


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
    ) as started:
        yield started


def table(folder: Path) -> bytes:
    return (folder / "flights.parquet").read_bytes()


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_folder_though_a_worker_dies(
    cluster: Any, write_spec: SpecWriter, tmp_path: Path
) -> None:
    spec = write_spec(draws=10, head='logs = "worst 2"')
    run_campaign(spec, tmp_path / "here", workers=0)
    pids = [nanny.pid for nanny in cluster.workers.values()]
    struck = []

    def strike(progress: Any) -> None:
        if progress.done >= 4 and not struck:
            struck.append(os.kill(pids[0], 9))

    address = cluster.scheduler_address
    outcome = run_campaign(spec, tmp_path / "there", scheduler=address, progress=strike)
    assert outcome.complete
    assert struck
    assert table(tmp_path / "there") == table(tmp_path / "here")
    logs = [sorted(path.name for path in (tmp_path / home / "logs").iterdir()) for home in ("here", "there")]
    assert len(logs[0]) == 2
    assert logs[0] == logs[1]


@pytest.mark.slow
def test_a_scheduler_that_does_not_answer_is_named(write_spec: SpecWriter, tmp_path: Path) -> None:
    with pytest.raises(SkylimbError, match=r"no Dask scheduler answers at 'tcp://127\.0\.0\.1:9'"):
        run_campaign(write_spec(draws=1), tmp_path / "out", scheduler="tcp://127.0.0.1:9")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_slurm_jobs_give_the_same_table(slurm: Path, write_spec: SpecWriter, tmp_path: Path) -> None:
    spec = write_spec(draws=3)
    run_campaign(spec, tmp_path / "here", workers=0)
    outcome = run_campaign(spec, tmp_path / "there", slurm="normal", workers=1)
    assert outcome.complete
    assert table(tmp_path / "there") == table(tmp_path / "here")


@pytest.mark.slow
def test_a_job_that_dies_before_it_works_is_named(
    slurm: Path, write_spec: SpecWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A campaign that was begun elsewhere keeps what it has, and goes on when the jobs are mended."""
    monkeypatch.setattr("skylimb.studies.campaign.engines.slurm.LOOK", 0.5)
    spec, folder = write_spec(draws=3), tmp_path / "out"

    def stop(progress: Any) -> None:
        if progress.done >= 2:
            os.kill(os.getpid(), signal.SIGINT)

    assert not run_campaign(spec, folder, workers=0, progress=stop).complete
    kept = len(load_rows(folder, load_campaign(folder))[0])
    broken = SBATCH.replace('sh "$script" >', "(echo no such environment; exit 127) >")
    (slurm / "sbatch").write_text(broken)
    with pytest.raises(SkylimbError) as caught:
        run_campaign(spec, folder, slurm="normal", workers=1, resume=True)
    for word in (
        "ended before its worker came",
        "FAILED",
        "127:0",
        "last.out",
        "no such environment",
        "--resume",
    ):
        assert word in str(caught.value)
    assert len(load_rows(folder, load_campaign(folder))[0]) == kept
    (slurm / "sbatch").write_text(SBATCH)
    assert run_campaign(spec, folder, slurm="normal", workers=1, resume=True).complete


def watching(jobs: dict[int, Any]) -> Any:
    """An engine whose cluster has these jobs and no worker."""
    from skylimb.studies.campaign.engines.slurm import SlurmEngine

    client = SimpleNamespace(status="running", get_executor=lambda **options: None)
    cluster = SimpleNamespace(scheduler=SimpleNamespace(workers={}), workers=jobs)
    return SlurmEngine("", client, cluster)


def test_a_job_that_waits_in_the_queue_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    from skylimb.studies.campaign.engines import slurm as engine

    states = iter(["PENDING", "RUNNING", "RUNNING", "FORGOTTEN"])
    monkeypatch.setattr(engine, "job_state", lambda job: engine.JobState(next(states), "1:0", "job.out"))
    monkeypatch.setattr(engine, "LOOK", 0.0)
    job = SimpleNamespace(job_id="7")
    watch = watching({0: job})
    for _ in range(3):
        watch.check()
    with pytest.raises(SkylimbError, match=r"SLURM job 7 .*exit code 1:0.*job\.out"):
        watch.check()


def test_a_job_that_runs_without_coming_to_work_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    from skylimb.studies.campaign.engines import slurm as engine

    monkeypatch.setattr(engine, "job_state", lambda job: engine.JobState("RUNNING", "0:0", ""))
    monkeypatch.setattr(engine, "LOOK", 0.0)
    monkeypatch.setattr(engine, "CONNECT", -1.0)
    jobs = {0: SimpleNamespace(job_id="7"), 1: SimpleNamespace(job_id="8")}
    watch = watching(jobs)
    with pytest.raises(SkylimbError, match=r"job 7 runs, but its worker has not come.*1 more"):
        watch.check()


def test_without_slurm_the_message_says_so(
    write_spec: SpecWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("dask_jobqueue")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SkylimbError, match="sbatch"):
        run_campaign(write_spec(draws=1), tmp_path / "out", slurm="normal")
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_used_asks_no_cluster(
    write_spec: SpecWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "out").mkdir()
    asked: list[object] = []
    monkeypatch.setattr(
        "skylimb.studies.campaign.fly_campaign.make_engine", lambda *given: asked.append(given)
    )
    with pytest.raises(SkylimbError, match="exists already"):
        run_campaign(write_spec(draws=1), tmp_path / "out", scheduler="tcp://127.0.0.1:9")
    assert not asked
