import json
import multiprocessing
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from skylimb.base.errors import CompileError, SkylimbError
from skylimb.studies.campaign import run_campaign
from skylimb.studies.campaign.engines import WorkerError
from skylimb.studies.campaign.engines.local import LocalEngine, WorkerDiedError
from skylimb.studies.campaign.folder import STORE_FILE, load_campaign
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.reading import load_spec
from skylimb.studies.campaign.store import load_rows

SpecWriter = Callable[..., Path]

EXAMPLE = Path(__file__).parents[3] / "examples" / "user_controller.py"
DEADLY = """
import multiprocessing
import os


class Deadly(Upright):
    name = "deadly"

    def step(self, *arguments):
        if multiprocessing.parent_process() is not None:  # the coordinator tries a controller, too
            HOW
        return super().step(*arguments)


def controller(robot):
    return Deadly(robot)
"""
"""Behind the example's own controller: it flies well, and ends every worker."""


def table(folder: Path) -> bytes:
    return (folder / "flights.parquet").read_bytes()


def coordinator(spec: Path, folder: Path, *words: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "skylimb", "campaign", str(spec), "--out", str(folder), "--workers", "2"]
    return subprocess.Popen(
        [*command, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def workers(process: subprocess.Popen[str]) -> list[psutil.Process]:
    """The coordinator's worker processes, without the helper that multiprocessing starts beside them."""
    try:
        children = psutil.Process(process.pid).children()
        return [child for child in children if "spawn_main" in " ".join(child.cmdline())]
    except psutil.NoSuchProcess:
        return []


def flown(folder: Path) -> int:
    """Flights that are kept, of a campaign or a search."""
    if not (folder / STORE_FILE).is_file():
        return 0
    with closing(sqlite3.connect(folder / STORE_FILE, timeout=30.0)) as database:
        try:
            return database.execute("SELECT count(row) FROM flights").fetchone()[0]
        except sqlite3.OperationalError:  # not begun yet
            return 0


def wait_for(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.02)


def test_the_folder_is_the_same_at_any_number_of_workers(
    write_spec: SpecWriter, tmp_path: Path, contents: Callable[[Path], dict[str, bytes]]
) -> None:
    spec = write_spec(draws=4)
    for count in (0, 2):
        run_campaign(spec, tmp_path / f"by-{count}", workers=count)
    assert contents(tmp_path / "by-0") == contents(tmp_path / "by-2")


@pytest.mark.slow
@pytest.mark.parametrize("how", ["os.kill(os.getpid(), 9)", "os._exit(0)"])
def test_a_flight_that_ends_its_worker_is_quarantined_and_named(
    how: str, write_spec: SpecWriter, tmp_path: Path
) -> None:
    (tmp_path / "deadly.py").write_text(EXAMPLE.read_text() + DEADLY.replace("HOW", how))
    spec = write_spec(draws=1, controllers='["pid", "deadly.py"]')
    outcome = run_campaign(spec, tmp_path / "out", workers=1)
    statuses = [outcome.rows[flight]["status"] for flight in range(2)]
    assert statuses == ["OK", "QUARANTINED"]
    assert "died 3 times" in outcome.rows[1]["cause"]
    assert outcome.summary is not None
    assert outcome.summary.rates["deadly"][:2] == (0, 1)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Flight 1 (deadly, draw 0) is quarantined" in page


@pytest.mark.slow
def test_nothing_is_lost_and_nothing_counts_twice_in_chaos(write_spec: SpecWriter, tmp_path: Path) -> None:
    """Workers die at random moments; the first coordinator is killed, the second one is stopped by Ctrl-C."""
    spec, folder = write_spec(draws=100, controllers='["pid"]'), tmp_path / "chaos"
    rng = random.Random(3)

    def wait_for_more() -> None:
        begun = flown(folder)
        wait_for(lambda: flown(folder) > begun)

    def strike(process: subprocess.Popen[str], times: int) -> list[psutil.Process]:
        wait_for_more()
        for _ in range(times):
            time.sleep(rng.uniform(0.0, 0.2))
            rng.choice(workers(process)).kill()
            wait_for_more()
        return workers(process)

    process = coordinator(spec, folder)
    orphans = strike(process, 2)
    process.kill()
    process.communicate()
    assert not psutil.wait_procs(orphans, timeout=20.0)[1]
    process = coordinator(spec, folder, "--resume")
    strike(process, 1)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers, too
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (130, "")
    kept, damaged = load_rows(folder, load_campaign(folder))
    assert not damaged
    assert 3 < len(kept) < 100
    assert f"{len(kept)} of 100 flights are kept" in out
    assert "--resume" in out
    assert run_campaign(spec, folder, workers=0, resume=True).complete
    run_campaign(spec, tmp_path / "serial", workers=0)
    assert table(folder) == table(tmp_path / "serial")
    assert not list(folder.rglob(".*"))


def test_a_worker_that_is_killed_while_it_waits_is_replaced(write_spec: SpecWriter) -> None:
    engine = LocalEngine(freeze(load_spec(write_spec())).text, 1)
    try:
        assert engine.submit(()).result() == []
        for child in multiprocessing.active_children():
            child.kill()
        try:
            assert engine.submit(()).result() == []
        except WorkerDiedError as error:
            assert engine.deaths(error) == 0  # noqa: PT017
            assert engine.submit(()).result() == []
    finally:
        engine.close()
    assert not multiprocessing.active_children()


def test_workers_that_die_before_they_begin_end_the_campaign() -> None:
    engine = LocalEngine("", 1)
    for _ in range(4):
        assert engine.deaths(WorkerDiedError(had_begun=False)) == 0
    with pytest.raises(WorkerError, match=r"5 worker processes in a row .*__main__"):
        engine.deaths(WorkerDiedError(had_begun=False))
    assert engine.deaths(WorkerDiedError(had_begun=True)) == 1
    assert engine.deaths(ValueError()) is None


def test_workers_of_another_version_are_refused(write_spec: SpecWriter) -> None:
    from skylimb.studies.campaign.worker import fly_jobs

    tables = freeze(load_spec(write_spec())).to_mapping()
    tables["frozen"] = {**tables["frozen"], "versions": {**tables["frozen"]["versions"], "numpy": "1.0.0"}}
    with pytest.raises(SkylimbError, match=r"numpy .* begun with 1\.0\.0"):
        fly_jobs(json.dumps(tables), ())


@pytest.mark.parametrize(
    ("words", "message"),
    [({"workers": -1}, "workers = -1"), ({"scheduler": "tcp://x:1", "slurm": "q"}, "exclude")],
)
def test_an_engine_that_cannot_be_is_refused(
    words: dict[str, object], message: str, write_spec: SpecWriter, tmp_path: Path
) -> None:
    with pytest.raises(SkylimbError, match=message):
        run_campaign(write_spec(), tmp_path / "out", **words)  # type: ignore[arg-type]
    assert not (tmp_path / "out").exists()


def test_all_drivers_give_the_same_rows_to_the_bit(
    write_spec: SpecWriter, monkeypatch: pytest.MonkeyPatch
) -> None:
    from skylimb.studies.campaign import worker

    spec = load_spec(write_spec(vary='"controller.attitude.damping_ratio.2" = { choice = [0.7, 0.9] }'))
    campaign, jobs = freeze(spec).text, [worker.Job(flight) for flight in range(8)]
    best = worker.fly_jobs(campaign, jobs)
    monkeypatch.setattr(worker, "unavailable", lambda: "no C compiler")
    assert worker.fly_jobs(campaign, jobs) == best
    assert {item.row["status"] for item in best} == {"OK"}


def test_code_that_cannot_be_compiled_is_charged_to_no_flight(
    write_spec: SpecWriter, monkeypatch: pytest.MonkeyPatch
) -> None:
    from skylimb.studies.campaign import worker

    def refuse(*arguments: object) -> None:
        raise CompileError("the disk is full")

    campaign = freeze(load_spec(write_spec())).text
    for name in ("prepare", "scored"):
        with monkeypatch.context() as patch:
            patch.setattr(worker, name, refuse)
            with pytest.raises(CompileError, match="the disk is full"):
                worker.fly_jobs(campaign, [worker.Job(0)])
