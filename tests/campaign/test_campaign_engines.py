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

from skylimb.campaign import run_campaign
from skylimb.campaign.folder import STORE_FILE, load_campaign
from skylimb.campaign.frozen import freeze
from skylimb.campaign.reading import load_spec
from skylimb.campaign.store import load_rows
from skylimb.errors import SkylimbError

SpecWriter = Callable[..., Path]

DEADLY = """
import os


class Deadly:
    name = "deadly"

    def gains(self): return None
    def initial_state(self): return None
    def step(self, *arguments): os.kill(os.getpid(), 9)


def controller(robot):
    return Deadly()
"""


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


def test_the_table_is_the_same_at_any_number_of_workers(write_spec: SpecWriter, tmp_path: Path) -> None:
    spec = write_spec(draws=5)
    for count in (0, 1, 2):
        run_campaign(spec, tmp_path / f"by-{count}", workers=count)
    assert table(tmp_path / "by-0") == table(tmp_path / "by-1") == table(tmp_path / "by-2")
    names = ("summary.json", "report.html", "spec.toml")
    for name in names:
        assert (tmp_path / "by-0" / name).read_bytes() == (tmp_path / "by-2" / name).read_bytes()


def test_a_flight_that_kills_its_worker_is_quarantined_and_named(
    write_spec: SpecWriter, tmp_path: Path
) -> None:
    (tmp_path / "deadly.py").write_text(DEADLY)
    spec = write_spec(draws=2, controllers='["pid", "deadly.py"]')
    outcome = run_campaign(spec, tmp_path / "out", workers=2)
    statuses = [outcome.rows[flight]["status"] for flight in range(4)]
    assert statuses == ["OK", "QUARANTINED", "OK", "QUARANTINED"]
    assert "died 3 times" in outcome.rows[1]["cause"]
    assert outcome.summary is not None
    assert outcome.summary.rates["deadly"][:2] == (0, 2)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Flight 1 (deadly, draw 0) is quarantined" in page


def test_ctrl_c_finishes_what_flies_and_says_how_to_go_on(write_spec: SpecWriter, tmp_path: Path) -> None:
    spec, folder = write_spec(draws=200), tmp_path / "out"
    process = coordinator(spec, folder)
    wait_for(lambda: flown(folder) > 3)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers, too
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err == ""
    assert "--resume" in out
    rows, damaged = load_rows(folder, load_campaign(folder))
    assert damaged == 0
    assert 3 < len(rows) < 400
    assert f"{len(rows)} of 400 flights are kept" in out


def test_workers_end_with_a_killed_coordinator(write_spec: SpecWriter, tmp_path: Path) -> None:
    process = coordinator(write_spec(draws=200), tmp_path / "out")
    wait_for(lambda: flown(tmp_path / "out") > 1)
    orphans = workers(process)
    assert len(orphans) == 2
    process.kill()
    process.communicate()
    _, alive = psutil.wait_procs(orphans, timeout=20)
    assert not alive


def chaos(spec: Path, folder: Path, kills: int, every: float, coordinators: int) -> tuple[int, int]:
    """Fly a campaign to its end while workers and coordinators are killed; how many of each were."""
    rng = random.Random(3)
    killed, restarts = 0, 0
    process = coordinator(spec, folder)
    strike = time.monotonic() + every
    while process.poll() is None or process.returncode != 0:
        if process.poll() is not None:
            out, err = process.communicate()
            assert process.returncode == -signal.SIGKILL, (out, err)
            process, strike = coordinator(spec, folder, "--resume"), time.monotonic() + every
        time.sleep(0.02)
        if time.monotonic() < strike or not flown(folder):
            continue
        strike = time.monotonic() + every * rng.uniform(0.5, 1.5)
        victims = workers(process)
        if killed < kills and victims:
            rng.choice(victims).kill()
            killed += 1
        if restarts < coordinators and killed >= (restarts + 1) * kills // (coordinators + 1):
            process.kill()
            process.wait()
            restarts += 1
    process.communicate()
    return killed, restarts


def check_chaos(spec: Path, home: Path, kills: int, every: float, coordinators: int) -> None:
    run_campaign(spec, home / "serial", workers=0)
    killed, restarts = chaos(spec, home / "chaos", kills, every, coordinators)
    assert killed >= kills // 2
    assert restarts == coordinators
    rows, damaged = load_rows(home / "chaos", load_campaign(home / "chaos"))
    assert damaged == 0
    # Three kills may hit one flight by chance; a resumed campaign gives such a flight its tries again.
    if any(row["status"] == "QUARANTINED" for row in rows.values()):
        run_campaign(spec, home / "chaos", workers=0, resume=True)
    assert table(home / "chaos") == table(home / "serial")
    assert not list((home / "chaos").rglob(".*"))


def test_nothing_is_lost_and_nothing_counts_twice_in_chaos(write_spec: SpecWriter, tmp_path: Path) -> None:
    check_chaos(write_spec(draws=24), tmp_path, kills=3, every=0.8, coordinators=1)


@pytest.mark.slow
def test_120_flights_through_chaos(write_spec: SpecWriter, tmp_path: Path) -> None:
    check_chaos(write_spec(draws=60), tmp_path, kills=8, every=1.2, coordinators=2)


def test_workers_of_another_version_are_refused(write_spec: SpecWriter) -> None:
    from skylimb.campaign.bench import fly_jobs

    tables = freeze(load_spec(write_spec())).to_mapping()
    tables["frozen"] = {**tables["frozen"], "versions": {**tables["frozen"]["versions"], "numpy": "1.0.0"}}
    with pytest.raises(SkylimbError, match=r"numpy .* begun with 1\.0\.0"):
        fly_jobs(tables, ())


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


def test_both_drivers_give_the_same_table_to_a_billionth(write_spec: SpecWriter) -> None:
    from skylimb.campaign.bench import Job, fly_jobs
    from skylimb.flights.drivers.native import native_available

    if not native_available():
        pytest.skip("no C compiler here: the Python driver flies everything")
    spec = load_spec(write_spec(vary='"controller.attitude.damping_ratio.2" = { choice = [0.7, 0.9] }'))
    jobs = [Job(flight) for flight in range(8)]
    native, python = (fly_jobs(freeze(spec, driver).to_mapping(), jobs) for driver in ("native", "python"))
    for ours, theirs in zip(native, python, strict=True):
        assert ours.row["status"] == theirs.row["status"] == "OK"
        assert ours.row["tilt_max"] == pytest.approx(theirs.row["tilt_max"], abs=1e-9)
        assert ours.row["error_z_median"] == pytest.approx(theirs.row["error_z_median"], abs=1e-9)
