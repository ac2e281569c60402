import os
import stat
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from skylimb.campaign import run_campaign
from skylimb.errors import SkylimbError

distributed = pytest.importorskip("distributed")

SpecWriter = Callable[..., Path]

SBATCH = """#!/bin/sh
# Stands for SLURM: keeps a copy of the job's script, as SLURM does, and runs it at once on this machine.
script=$(mktemp "$SLURM_STAND_IN/job.XXXXXX")
cp "$1" "$script"
sh "$script" >"$script.out" 2>&1 &
echo "Submitted batch job $!"
"""


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
    ) as started:
        yield started


def table(folder: Path) -> bytes:
    return (folder / "flights.parquet").read_bytes()


def test_a_dask_cluster_of_two_processes_gives_the_same_table(
    cluster: Any, write_spec: SpecWriter, tmp_path: Path
) -> None:
    spec = write_spec(draws=6, head='logs = "all"')
    run_campaign(spec, tmp_path / "here", workers=0)
    outcome = run_campaign(spec, tmp_path / "there", scheduler=cluster.scheduler_address)
    assert outcome.complete
    assert table(tmp_path / "there") == table(tmp_path / "here")
    assert len(list((tmp_path / "there" / "logs").iterdir())) == 12


def test_a_worker_of_the_cluster_may_die(cluster: Any, write_spec: SpecWriter, tmp_path: Path) -> None:
    spec = write_spec(draws=10)
    run_campaign(spec, tmp_path / "here", workers=0)
    pids = [nanny.pid for nanny in cluster.workers.values()]
    struck = []

    def strike(progress: Any) -> None:
        if progress.done >= 4 and not struck:
            struck.append(os.kill(pids[0], 9))

    run_campaign(spec, tmp_path / "there", scheduler=cluster.scheduler_address, progress=strike)
    assert struck
    assert table(tmp_path / "there") == table(tmp_path / "here")


def test_a_scheduler_that_does_not_answer_is_named(write_spec: SpecWriter, tmp_path: Path) -> None:
    with pytest.raises(SkylimbError, match=r"no Dask scheduler answers at 'tcp://127\.0\.0\.1:9'"):
        run_campaign(write_spec(draws=1), tmp_path / "out", scheduler="tcp://127.0.0.1:9")


def test_slurm_jobs_give_the_same_table(
    write_spec: SpecWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("dask_jobqueue")
    commands = tmp_path / "bin"
    commands.mkdir()
    for name, text in (("sbatch", SBATCH), ("scancel", '#!/bin/sh\nkill "$@" 2>/dev/null\ntrue\n')):
        path = commands / name
        path.write_text(text)
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv(
        "PATH", f"{commands}{os.pathsep}{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    )
    spec = write_spec(draws=3)
    run_campaign(spec, tmp_path / "here", workers=0)
    outcome = run_campaign(spec, tmp_path / "there", slurm="normal", workers=1)
    assert outcome.complete
    assert table(tmp_path / "there") == table(tmp_path / "here")


def test_without_slurm_the_message_says_so(
    write_spec: SpecWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("dask_jobqueue")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SkylimbError, match="sbatch"):
        run_campaign(write_spec(draws=1), tmp_path / "out", slurm="normal")
