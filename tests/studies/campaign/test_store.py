"""What a campaign's folder survives: kills, full disks, damage, readers and other coordinators."""

import random
import signal
import sqlite3
import threading
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skylimb.apps.cli import main
from skylimb.base.errors import OutputError
from skylimb.studies.campaign import report_campaign, run_campaign
from skylimb.studies.campaign.folder import STORE_FILE, TABLE_FILE, load_campaign
from skylimb.studies.campaign.frozen import Campaign, freeze
from skylimb.studies.campaign.reading import load_spec
from skylimb.studies.campaign.rows import OK, make_row
from skylimb.studies.campaign.store import load_rows, open_store
from skylimb.studies.campaign.worker import Flown, Job

SpecWriter = Callable[..., Path]
Contents = Callable[[Path], dict[str, bytes]]
InChild = Callable[..., int]

pytestmark = pytest.mark.usefixtures("instant_flights")


@pytest.fixture
def campaign(write_spec: SpecWriter) -> Campaign:
    return freeze(load_spec(write_spec(draws=50)))


def flown(campaign: Campaign, flight: int) -> tuple[Job, Flown]:
    row = make_row(campaign, flight, OK, "", dict.fromkeys(campaign.spec.keys, 0.1 * flight))
    return Job(flight), Flown(row, None)


def test_a_row_reads_back_to_the_last_bit(campaign: Campaign, tmp_path: Path) -> None:
    number = 0.1 + 0.2
    row = make_row(campaign, 3, OK, "", dict.fromkeys(campaign.spec.keys, number))
    with open_store(tmp_path / "out", campaign, resume=False) as store:
        store.add([(Job(3), Flown(row, None))])
        assert load_rows(tmp_path / "out", campaign) == ({3: row}, 0)
    with open_store(tmp_path / "out", campaign, resume=True) as store:
        assert store.by_flight == {3: row}
        store.finish(store.rows, {})
    assert load_rows(tmp_path / "out", campaign) == ({3: row}, 0)
    assert not (tmp_path / "out" / STORE_FILE).exists()


def test_a_batch_is_kept_whole_or_not_at_all(campaign: Campaign, tmp_path: Path) -> None:
    with open_store(tmp_path / "out", campaign, resume=False) as store:
        with closing(sqlite3.connect(tmp_path / "out" / STORE_FILE)) as other, other:
            other.execute(
                "CREATE TRIGGER stop BEFORE INSERT ON flights WHEN NEW.flight = 2 "
                "BEGIN SELECT RAISE(ABORT, 'no room'); END"
            )
        with pytest.raises(OutputError, match="no room"):
            store.add(flown(campaign, flight) for flight in (1, 2, 3))
        assert load_rows(tmp_path / "out", campaign) == ({}, False)


def test_rows_of_a_search_are_told_apart_by_their_gains(campaign: Campaign, tmp_path: Path) -> None:
    jobs = [Job(0, (("a.b", number),)) for number in (1.0, 2.0)]
    with open_store(tmp_path / "out", campaign, resume=False) as store:
        store.add([(job, flown(campaign, 0)[1]) for job in jobs])
        rows = dict(store.rows)
        store.finish(store.rows, {})
    with open_store(tmp_path / "out", campaign, resume=True) as store:
        assert store.rows == rows
        assert set(rows) == {job.key for job in jobs}
    assert load_rows(tmp_path / "out", campaign)[0] == {}  # they are no campaign's flights


def test_a_quarantined_flight_gets_its_tries_again(campaign: Campaign, tmp_path: Path) -> None:
    job, item = flown(campaign, 0)
    with open_store(tmp_path / "out", campaign, resume=False) as store:
        store.add([(job, Flown({**item.row, "status": "QUARANTINED"}, None))])
    with open_store(tmp_path / "out", campaign, resume=True) as store:
        assert store.rows == {}


def test_whatever_was_acknowledged_is_there_after_a_kill(
    campaign: Campaign, tmp_path: Path, in_child: InChild
) -> None:
    """A row is acknowledged when `add` returns; killed at any moment, the file has it, whole, and no half."""
    rng, acknowledged = random.Random(1), tmp_path / "acknowledged"
    batches = [[flown(campaign, flight) for flight in range(i, i + 4)] for i in range(0, 100, 4)]

    def write(folder: Path) -> None:
        with open_store(folder, campaign, resume=folder.exists()) as store, acknowledged.open("a") as file:
            for batch in batches:
                store.add(batch)
                print(batch[-1][0].flight, file=file, flush=True)

    kills = 0
    for attempt in range(40):
        folder = tmp_path / f"out-{attempt}"
        acknowledged.write_text("")
        kills += in_child(lambda folder=folder: write(folder), seconds=rng.uniform(0.001, 0.06)) != 0
        if not folder.exists():
            continue
        rows, _ = load_rows(folder, campaign)
        last = max(map(int, acknowledged.read_text().split()), default=-1)
        assert list(rows) == list(range(len(rows)))
        assert len(rows) % 4 == 0
        assert len(rows) > last
        assert all(row == flown(campaign, flight)[1].row for flight, row in rows.items())
        with open_store(folder, campaign, resume=True) as store:
            assert store.by_flight == rows
    assert kills > 10


@pytest.mark.slow
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(kills=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=5))
def test_a_campaign_killed_at_any_moments_ends_as_an_undisturbed_one(
    kills: list[float], tmp_path_factory: pytest.TempPathFactory, write_spec_to: SpecWriter,
    in_child: InChild, contents: Contents, counted: Callable[..., Any],
) -> None:  # fmt: skip
    """Killed again and again at a random call, out of all that an undisturbed campaign makes."""
    home = tmp_path_factory.mktemp("kills")
    spec, folder = write_spec_to(home, draws=12, head='logs = "worst 5"'), home / "out"
    with counted() as calls:
        run_campaign(spec, home / "whole", workers=0)

    def fly() -> None:
        run_campaign(spec, folder, workers=0, resume=folder.exists())

    for share in kills:
        assert in_child(fly, calls=1 + int(share * calls.count)) in (0, -signal.SIGKILL)
    fly()
    assert contents(folder) == contents(home / "whole")


@settings(max_examples=7, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(limits=st.lists(st.integers(100, 30_000), min_size=1, max_size=4))
def test_a_disk_that_is_full_at_any_byte_costs_nothing_that_was_flown(
    limits: list[int], tmp_path_factory: pytest.TempPathFactory, write_spec_to: SpecWriter, in_child: InChild,
    contents: Contents,
) -> None:  # fmt: skip
    """No file may grow beyond a limit; the process says so and ends, and the next one goes on."""
    home = tmp_path_factory.mktemp("full")
    spec = write_spec_to(home, draws=12, head='logs = "all"')
    folder, kept = home / "out", 0

    def fly() -> None:
        try:
            run_campaign(spec, folder, workers=0, resume=folder.exists())
        except OutputError as error:
            kept_is_named = "--resume" in str(error) or not folder.exists()
            if not kept_is_named or "\n" in str(error):
                raise RuntimeError("the message does not help") from error

    for limit in limits:  # the last file that is written, the longest, has 24 kB
        assert in_child(fly, most_bytes=limit) == 0
        rows = load_rows(folder, load_campaign(folder))[0] if folder.exists() else {}
        assert len(rows) >= kept
        kept = len(rows)
    run_campaign(spec, folder, workers=0, resume=folder.exists())
    run_campaign(spec, home / "whole", workers=0)
    assert contents(folder) == contents(home / "whole")


def test_the_report_can_be_written_while_it_flies(campaign: Campaign, tmp_path: Path) -> None:
    seen, failures = [], []
    with open_store(tmp_path / "out", campaign, resume=False) as store:
        store.add([flown(campaign, 0)])

        def read() -> None:
            try:
                while not seen or seen[-1] < 100:
                    seen.append(len(report_campaign(tmp_path / "out").rows))
            except Exception as error:
                failures.append(error)

        reader = threading.Thread(target=read)
        reader.start()
        for flight in range(1, 100):
            store.add([flown(campaign, flight)])
        reader.join(30.0)
    assert not failures
    assert seen == sorted(seen)
    assert seen[-1] == 100
    assert "100 flights" in (tmp_path / "out" / "report.html").read_text()


def test_numbers_of_half_a_campaign_say_how_many_draws_they_are_of(
    campaign: Campaign, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with open_store(tmp_path / "out", campaign, resume=False) as store:
        store.add([flown(campaign, flight) for flight in range(25)])
    assert main(["campaign", "report", str(tmp_path / "out")]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "medians over 12 draws (not through yet: 25 of 100 flights)" in told


def test_a_folder_has_one_coordinator_at_a_time(campaign: Campaign, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with open_store(folder, campaign, resume=False) as store:
        store.add([flown(campaign, 0)])
        with (
            pytest.raises(OutputError, match=f"'{folder}' is in use by another process"),
            open_store(folder, campaign, resume=True),
        ):
            pass
        store.add([flown(campaign, 1)])
    with open_store(folder, campaign, resume=True) as store:
        assert len(store.rows) == 2


def test_a_killed_coordinator_holds_no_lock(campaign: Campaign, tmp_path: Path, in_child: InChild) -> None:
    def hold() -> None:
        with open_store(tmp_path / "out", campaign, resume=False) as store:
            store.add([flown(campaign, 0)])
            time.sleep(60.0)

    assert in_child(hold, seconds=0.5) != 0
    with open_store(tmp_path / "out", campaign, resume=True) as store:
        assert set(store.by_flight) == {0}


def test_a_damaged_store_is_refused_by_name_and_can_be_moved_away(campaign: Campaign, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with open_store(folder, campaign, resume=False) as store:
        store.add([flown(campaign, flight) for flight in range(50)])
    path = folder / STORE_FILE
    sound = path.read_bytes()
    for damaged in (b"no database at all, but long enough to be one" * 100, sound[:4096] + b"x" * 20_000):
        path.write_bytes(damaged)
        with (
            pytest.raises(OutputError, match=r"flights\.sqlite' is damaged .*move it away"),
            open_store(folder, campaign, resume=True),
        ):
            pass
        assert path.read_bytes() == damaged
    path.rename(tmp_path / "aside")
    with open_store(folder, campaign, resume=True) as store:
        assert store.rows == {}


def test_no_flipped_bit_of_the_store_is_taken_for_a_number(campaign: Campaign, tmp_path: Path) -> None:
    """A damaged row flies again, and all others are kept; a file that cannot be read is refused."""
    folder, rng, partly = tmp_path / "out", random.Random(1), 0
    with open_store(folder, campaign, resume=False) as store:
        store.add([flown(campaign, flight) for flight in range(50)])
        sound = store.by_flight
    file = (folder / STORE_FILE).read_bytes()
    for _ in range(150):
        changed = bytearray(file)
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
        (folder / STORE_FILE).write_bytes(changed)
        try:
            with open_store(folder, campaign, resume=True) as store:
                kept = store.by_flight
        except OutputError:
            continue
        assert kept.items() <= sound.items()
        if len(kept) == 49 and store.damaged:
            partly += 1
            with open_store(folder, campaign, resume=True) as store:
                store.add([flown(campaign, flight) for flight in sound.keys() - kept.keys()])
            assert load_rows(folder, campaign) == (sound, False)
    assert partly > 30


def test_a_store_that_was_never_written_is_empty(campaign: Campaign, tmp_path: Path) -> None:
    with open_store(tmp_path / "out", campaign, resume=False):
        pass
    (tmp_path / "out" / STORE_FILE).write_bytes(b"")  # a kill between creating the file and its first page
    assert load_rows(tmp_path / "out", campaign) == ({}, False)
    with open_store(tmp_path / "out", campaign, resume=True) as store:
        assert store.rows == {}


def test_a_damaged_table_is_flown_again(write_spec: SpecWriter, tmp_path: Path, contents: Contents) -> None:
    spec, folder = write_spec(draws=8), tmp_path / "out"
    run_campaign(spec, folder, workers=0)
    before = contents(folder)
    (folder / TABLE_FILE).write_bytes(before[TABLE_FILE][:-100])
    with pytest.raises(
        OutputError, match=r"flights\.parquet' is damaged or of .* --resume` flies them again"
    ):
        report_campaign(folder)
    assert run_campaign(spec, folder, workers=0, resume=True).damaged
    assert contents(folder) == before


def test_a_kill_between_table_and_tidying_up_costs_nothing(
    write_spec: SpecWriter, tmp_path: Path, contents: Contents
) -> None:
    """The table is there and so is the store; neither has to be whole."""
    spec, folder = write_spec(draws=8), tmp_path / "out"
    run_campaign(spec, folder, workers=0)
    before = contents(folder)
    campaign = load_campaign(folder)
    with open_store(folder, campaign, resume=True):
        pass
    assert (folder / STORE_FILE).exists()
    with closing(sqlite3.connect(folder / STORE_FILE)) as database, database:
        database.execute("DELETE FROM flights WHERE flight > 10")
    assert len(load_rows(folder, campaign)[0]) == 16
    run_campaign(spec, folder, workers=0, resume=True)
    assert contents(folder) == before
