"""What a worker does: (campaign, job) -> row and, where the policy wants it, the flight's log.

A worker keeps nothing between flights but what can be made anew: the robot, the controllers with their
compiled equations. Any worker on any machine gives the same row for the same job.
"""

from __future__ import annotations

import dataclasses
import json
import tempfile
import threading
import warnings
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from skylimb.analysis.recording.run import Run
from skylimb.analysis.recording.versions import computing_versions
from skylimb.analysis.scores.registry import measured
from skylimb.analysis.scores.user_scores import scored
from skylimb.base.errors import CompileError, ConfigError, SkylimbError
from skylimb.control.controller import Controller
from skylimb.control.loop.flight import Flight
from skylimb.flight.drivers.native import fly_native, unavailable
from skylimb.flight.experiments.experiment import Experiment, robot_of
from skylimb.flight.flying import fly_here
from skylimb.flight.run_files import not_repeatable
from skylimb.flight.simulated_run import simulated_run, with_origin
from skylimb.flight.takeoff import Takeoff, prepare
from skylimb.studies.campaign.folder import CONFIG_FILE, log_name
from skylimb.studies.campaign.frozen import Campaign, campaign_from_mapping
from skylimb.studies.campaign.rows import FAILED, REFUSED, Row, make_row
from skylimb.studies.campaign.unchanged import Unchanged

# A process flies one flight at a time, also where a cluster's worker has several threads.
_ONE_AT_A_TIME = threading.Lock()


class Job(NamedTuple):
    """One flight to fly.

    Attributes:
        flight: index in the campaign.
        gains: changes to the controller beyond those of the draw, dotted key and value.
        log: whether to hand back the log: "never", "failed" or "always".
    """

    flight: int
    gains: tuple[tuple[str, Any], ...] = ()
    log: str = "never"

    @property
    def key(self) -> tuple[int, str]:
        """What its row is of: the flight, and the gains as JSON."""
        return self.flight, json.dumps([list(pair) for pair in self.gains])


class Flown(NamedTuple):
    """What came of a job.

    Attributes:
        row: of the table.
        log: the NetCDF file's bytes, or None.
        files: what belongs to the log, by name in the campaign's folder: its configuration, and copies of the
            user's files, which the logs share.
    """

    row: Row
    log: bytes | None
    files: Mapping[str, bytes] = {}


def fly_jobs(campaign: str, jobs: Sequence[Job]) -> list[Flown]:
    """Fly jobs of a campaign.

    Args:
        campaign: as `Campaign.text` gives it, which travels to any process.
        jobs: what to fly.

    Raises:
        ConfigError: when this process has other versions than the campaign was begun with.
    """
    with _ONE_AT_A_TIME:
        return _worker(campaign).fly(jobs)


def ready(experiment: Experiment, controller: Controller) -> Takeoff:
    """What the flight of a draw needs to take off, checked.

    Raises:
        SkylimbError: when the controller cannot fly it.
    """
    with warnings.catch_warnings():  # of a doubtful draw its row tells what came of it
        warnings.simplefilter("ignore", UserWarning)
        return prepare(experiment, robot_of(experiment), controller)


class Worker:
    """A campaign's robot and controllers, loaded once."""

    def __init__(self, campaign: Campaign) -> None:
        present = computing_versions()
        for name, version in campaign.versions.items():
            if present.get(name) != version:
                raise ConfigError(
                    f"this worker has {name} {present.get(name)}, the campaign was begun with {version}; "
                    "the rows would not be the same"
                )
        self._campaign = campaign
        self._unchanged = Unchanged(campaign)
        self._controller = lru_cache(maxsize=64)(
            lambda name, robot, gains: campaign.load(name, robot, json.loads(gains))
        )

    def fly(self, jobs: Sequence[Job]) -> list[Flown]:
        """The row of each flight, and its log if it is wanted.

        Raises:
            ConfigError: when they have read another file than the campaign was begun with.
        """
        prepared = [self._prepare(job) for job in jobs]
        ready = [item for item in prepared if isinstance(item, Takeoff)]
        flights = iter(self._native_flights(ready))
        flown = [
            item if isinstance(item, Flown) else self._flown(job, item, next(flights))
            for job, item in zip(jobs, prepared, strict=True)
        ]
        self._unchanged.require(item.experiment for item in ready)
        return flown

    def _prepare(self, job: Job) -> Takeoff | Flown:
        """What a job needs to take off; its row where it never will."""
        campaign = self._campaign
        index, name = campaign.split(job.flight)
        drawn = campaign.draw(index)
        try:
            experiment = campaign.experiment_of(drawn)
            robot = robot_of(experiment)
            gains = {**campaign.gains_of(drawn, name), **dict(job.gains)}
            controller = self._controller(name, robot, json.dumps(gains, sort_keys=True))
            return ready(experiment, controller)
        except CompileError:
            raise  # says something of this machine, nothing of the draw
        except SkylimbError as error:
            return Flown(make_row(campaign, job.flight, REFUSED, _line(error), {}), None)

    def _native_flights(self, ready: Sequence[Takeoff]) -> list[Flight | None]:
        """What the native driver can fly of them, all at once; None where another driver must.

        All drivers give the same bits, so each worker uses the best that it can.
        """
        native = [item for item in ready if item.compiled]
        if not native or unavailable():
            return [None] * len(ready)
        try:
            made = iter(fly_native(native))
        except CompileError:  # the disk that keeps compiled code is full, for one
            return [None] * len(ready)
        taken = {id(item) for item in native}
        return [next(made) if id(item) in taken else None for item in ready]

    def _twin(self, item: Takeoff) -> Run | None:
        """The same flight without its events, where the campaign compares the two."""
        if not (self._campaign.spec.twins and item.experiment.events):
            return None
        twin = item.changed(dataclasses.replace(item.experiment, events=()))
        return simulated_run(twin, self._native_flights([twin])[0] or fly_here(twin))

    def _flown(self, job: Job, item: Takeoff, flight: Flight | None) -> Flown:
        """The row of a flight; it is flown by the Python driver where it has not been yet."""
        spec = self._campaign.spec
        try:
            if flight is None:
                flight = fly_here(item)
            run = dataclasses.replace(simulated_run(item, flight), twin=self._twin(item))
            run = scored(run, spec.user_metrics, spec.measures)
        except (OSError, MemoryError, CompileError):
            raise  # says something of this machine, nothing of the flight
        except Exception as error:  # one odd flight must not end a night of them; its row says what happened
            cause = (
                _line(error) if isinstance(error, SkylimbError) else f"{type(error).__name__}: {_line(error)}"
            )
            return Flown(make_row(self._campaign, job.flight, FAILED, cause, {}), None)
        scores = {**run.metrics, **measured(run, spec.measures)}
        # Why a number is missing, or not to be had again.
        again = (f"this run cannot be repeated: {why}" for why in not_repeatable(item.controller))
        lacks = "" if run.failed else "; ".join(run.problems.values())
        cause = lacks or run.cause or next(chain(run.notes, again), "")
        row = make_row(self._campaign, job.flight, run.status, cause, scores)
        wanted = job.log == "always" or (job.log == "failed" and run.failed)
        if not wanted:
            return Flown(row, None)
        kept = with_origin(run, item)
        placed = kept.with_sources_at("../../")  # a log lies two folders below the campaign's
        config = {f"{log_name(row)}/{CONFIG_FILE}": placed.config.encode()}
        return Flown(row, _bytes(placed), {**kept.sources, **config})


@lru_cache(maxsize=4)
def _worker(campaign: str) -> Worker:
    return Worker(campaign_from_mapping(json.loads(campaign), "the campaign"))


def _bytes(run: Run) -> bytes:
    with tempfile.TemporaryDirectory(prefix="skylimb-log-") as folder:
        return run.save(Path(folder) / "log.nc").read_bytes()


def _line(error: Exception) -> str:
    return " ".join(str(error).split())
