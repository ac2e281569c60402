"""What the queue makes of an engine's results and of the deaths of its workers."""

import random
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future
from pathlib import Path
from threading import Event

import pytest

from skylimb.base.errors import ConfigError, OutputError
from skylimb.studies.campaign.engines import Engine, WorkerError
from skylimb.studies.campaign.flight_queue import BATCH, CampaignProgress, FlightQueue, Interrupted
from skylimb.studies.campaign.frozen import Campaign, freeze
from skylimb.studies.campaign.reading import load_spec
from skylimb.studies.campaign.rows import OK, make_row
from skylimb.studies.campaign.store import Store, open_store
from skylimb.studies.campaign.worker import Flown, Job

SpecWriter = Callable[..., Path]


class Death(Exception):
    """A worker died; it takes the number of workers that did."""


class ScriptedEngine(Engine):
    """Hands back rows in a random order, after what a script says of each batch.

    Args:
        campaign: that is flown.
        script: called with a batch; an exception that it returns is what becomes of the batch.
        slots: batches at a time.
    """

    def __init__(
        self,
        campaign: Campaign,
        script: Callable[[Sequence[Job]], BaseException | None] = lambda jobs: None,
        slots: int = 3,
    ) -> None:
        super().__init__("", slots)
        self.batches, self.checks = [], 0
        self._flown, self._script, self._rng = campaign, script, random.Random(1)
        self._waiting: deque[tuple[Sequence[Job], Future[list[Flown]]]] = deque()

    def submit(self, jobs: Sequence[Job]) -> Future[list[Flown]]:
        future: Future[list[Flown]] = Future()
        self.batches.append(list(jobs))
        self._waiting.append((jobs, future))
        assert len(self._waiting) <= self.slots
        if self._rng.random() < 0.5 or len(self._waiting) == self.slots:
            self._end(self._rng.randrange(len(self._waiting)))
        return future

    def deaths(self, error: BaseException) -> int | None:
        if isinstance(error, CancelledError):
            raise WorkerError("the connection is lost")
        return error.args[0] if isinstance(error, Death) else None

    def check(self) -> None:
        self.checks += 1
        self._end(0)

    def close(self) -> None:
        """Nothing is held."""

    def _end(self, place: int) -> None:
        self._waiting.rotate(-place)
        jobs, future = self._waiting.popleft()
        error = self._script(jobs)
        if isinstance(error, CancelledError):
            future.cancel()
            future.set_running_or_notify_cancel()
        elif error is not None:
            future.set_exception(error)
        else:
            future.set_result([flown(self._flown, job) for job in jobs])


def flown(campaign: Campaign, job: Job, score: float = 1.0) -> Flown:
    scores = dict.fromkeys(campaign.spec.keys, score)
    log = b"log" if job.log == "always" else None
    return Flown(make_row(campaign, job.flight, OK, "", scores), log)


@pytest.fixture(autouse=True)
def _no_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skylimb.studies.campaign.flight_queue._PAUSE", 0.001)


@pytest.fixture
def campaign(write_spec: SpecWriter) -> Campaign:
    return freeze(load_spec(write_spec(draws=20)))


@pytest.fixture
def store(campaign: Campaign, tmp_path: Path) -> Iterator[Store]:
    with open_store(tmp_path / "out", campaign, resume=False) as opened:
        yield opened


def queue_of(store: Store, engine: ScriptedEngine, stop: Event | None = None) -> FlightQueue:
    return FlightQueue(store, engine, stop or Event(), lambda progress: None, 40)


def test_every_job_flies_once_in_batches(campaign: Campaign, store: Store) -> None:
    engine = ScriptedEngine(campaign)
    queue_of(store, engine).fly([Job(flight) for flight in range(40)])
    assert list(store.by_flight) == list(range(40))
    assert sorted(job.flight for batch in engine.batches for job in batch) == list(range(40))
    assert max(map(len, engine.batches)) == BATCH


def test_a_few_jobs_are_spread_over_the_workers(campaign: Campaign, store: Store) -> None:
    engine = ScriptedEngine(campaign, slots=8)
    queue_of(store, engine).fly([Job(flight) for flight in range(16)])
    assert {len(batch) for batch in engine.batches} == {2}


def test_a_flight_that_kills_three_workers_is_quarantined_and_no_other(
    campaign: Campaign, store: Store
) -> None:
    engine = ScriptedEngine(campaign, lambda jobs: Death(1) if Job(5) in jobs else None)
    queue_of(store, engine).fly([Job(flight) for flight in range(16)])
    statuses = {flight: row["status"] for flight, row in store.by_flight.items()}
    assert statuses == {**dict.fromkeys(range(16), "OK"), 5: "QUARANTINED"}
    assert store.rows[Job(5).key]["cause"] == "its worker process died 3 times"
    # Once among others, for which nobody is charged; then alone, three times.
    assert [len(batch) for batch in engine.batches if Job(5) in batch] == [4, 1, 1, 1]


def test_a_worker_that_dies_before_it_begins_is_charged_to_nobody(campaign: Campaign, store: Store) -> None:
    left = [Death(0)] * 10
    engine = ScriptedEngine(campaign, lambda jobs: left.pop() if left else None)
    queue_of(store, engine).fly([Job(flight) for flight in range(12)])
    assert {row["status"] for row in store.rows.values()} == {"OK"}


def test_a_flight_that_only_gives_its_log_is_never_quarantined(campaign: Campaign, store: Store) -> None:
    store.add([(Job(0), flown(campaign, Job(0)))])
    engine = ScriptedEngine(campaign, lambda jobs: Death(3))
    queue_of(store, engine).fly([Job(0, log="always")])
    assert store.rows[Job(0).key]["status"] == "OK"


def test_a_flight_with_another_result_is_refused_by_number(campaign: Campaign, store: Store) -> None:
    store.add([(Job(7), flown(campaign, Job(7), 1.0 + 1e-15))])
    with pytest.raises(OutputError, match="flight 7 gave another result"):
        queue_of(store, ScriptedEngine(campaign)).fly([Job(7, log="always")])


def test_a_log_of_a_flight_that_has_flown_is_kept(campaign: Campaign, store: Store) -> None:
    queue = queue_of(store, ScriptedEngine(campaign))
    queue.fly([Job(3)])
    queue.fly([Job(3, log="always")])
    assert (store.folder / "logs" / "000003-hybrid" / "log.nc").read_bytes() == b"log"


def test_a_stop_finishes_what_flies_and_keeps_it(campaign: Campaign, store: Store) -> None:
    stop = Event()

    def script(jobs: Sequence[Job]) -> None:
        if len(engine.batches) == 4:
            stop.set()

    engine = ScriptedEngine(campaign, script)
    with pytest.raises(Interrupted):
        queue_of(store, engine, stop).fly([Job(flight) for flight in range(40)])
    assert len(engine.batches) < 10
    assert set(store.by_flight) == {job.flight for batch in engine.batches for job in batch}


def test_a_stop_after_the_last_flight_is_no_interruption(campaign: Campaign, store: Store) -> None:
    stop = Event()

    def script(jobs: Sequence[Job]) -> None:
        stop.set()

    queue_of(store, ScriptedEngine(campaign, script, slots=1), stop).fly([Job(0)])
    assert set(store.by_flight) == {0}


def test_an_error_of_the_worker_ends_the_campaign(campaign: Campaign, store: Store) -> None:
    wrong = ConfigError("this worker has other files")
    with pytest.raises(ConfigError, match="other files"):
        queue_of(store, ScriptedEngine(campaign, lambda jobs: wrong)).fly([Job(0)])
    with pytest.raises(WorkerError, match=r"a flight of \[0\] ended its worker: SystemExit"):
        queue_of(store, ScriptedEngine(campaign, lambda jobs: SystemExit(0))).fly([Job(0)])
    with pytest.raises(WorkerError, match="connection is lost"):
        queue_of(store, ScriptedEngine(campaign, lambda jobs: CancelledError())).fly([Job(0)])


def test_progress_counts_flights_and_failures(campaign: Campaign, store: Store) -> None:
    seen: list[CampaignProgress] = []
    engine = ScriptedEngine(campaign, lambda jobs: Death(1) if Job(0) in jobs else None)
    FlightQueue(store, engine, Event(), seen.append, 8).fly([Job(flight) for flight in range(8)])
    assert (seen[0].done, seen[-1].done) == (0, 8)
    assert (seen[-1].total, seen[-1].flown, seen[-1].failures) == (8, 8, 1)
    again = FlightQueue(store, engine, Event(), seen.append, 8)
    again.fly([])
    assert (seen[-1].done, seen[-1].flown, seen[-1].failures) == (8, 0, 1)
