"""The public calls: fly a campaign, and write its report anew."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skylimb.base.errors import CompileError, ConfigError, OutputError, SkylimbError
from skylimb.base.files import replace_text
from skylimb.flight.experiments.experiment import robot_of
from skylimb.studies.campaign.engines import check_workers, make_engine
from skylimb.studies.campaign.flight_queue import (
    FlightQueue,
    Interrupted,
    Report,
    watching_interrupts,
)
from skylimb.studies.campaign.folder import (
    LOGS,
    REPORT_FILE,
    SPEC_FILE,
    STORE_FILE,
    SUMMARY_FILE,
    TABLE_FILE,
    begin_folder,
    complaints,
    load_campaign,
    logged,
)
from skylimb.studies.campaign.frozen import Campaign, freeze
from skylimb.studies.campaign.logs import log_flag, wanted_logs
from skylimb.studies.campaign.reading import load_spec
from skylimb.studies.campaign.rows import Row
from skylimb.studies.campaign.spec import CampaignSpec
from skylimb.studies.campaign.stopping import enough, looks
from skylimb.studies.campaign.store import load_rows, open_store
from skylimb.studies.campaign.summary import Summary, summarize, summary_json
from skylimb.studies.campaign.worker import Job, ready

_TRIED = 8
"""Draws that each controller is tried with, at most, before a campaign begins."""


@dataclass(frozen=True)
class Outcome:
    """What a campaign came to.

    Attributes:
        folder: where everything lies.
        campaign: what was flown.
        rows: by flight.
        summary: None when it was stopped before its end.
        damaged: whether something that had flown could not be read, and was flown again or left out.
    """

    folder: Path
    campaign: Campaign
    rows: dict[int, Row]
    summary: Summary | None
    damaged: bool

    @property
    def complete(self) -> bool:
        """Whether all has flown that the spec asks for."""
        return self.summary is not None


def run_campaign(
    spec: str | Path | CampaignSpec,
    out: str | Path,
    *,
    workers: int | None = None,
    resume: bool = False,
    scheduler: str = "",
    slurm: str = "",
    progress: Report | None = None,
) -> Outcome:
    """Fly a campaign into a folder, or go on with one.

    Args:
        spec: a TOML file, or a spec at hand.
        out: folder for the results: spec.toml, flights.parquet, summary.json, report.html and logs/.
        workers: processes on this machine, or jobs on SLURM; all cores by default, 0 flies in this process.
            The table does not depend on it, and a resumed campaign may have another number.
        resume: whether `out` may be there already; flights in it are not flown again.
        scheduler: address of a Dask scheduler, such as tcp://HOST:8786, to fly there.
        slurm: a SLURM queue, to fly there.
        progress: called with the progress, twice a second or more often.

    Returns:
        The outcome; not complete when Ctrl-C stopped it.

    Raises:
        ConfigError: when the spec cannot be flown; nothing has been written then.
        OutputError: when the folder cannot be used; nothing in it has been touched then. Or when the disk
            is full; what was flown before is kept.
    """
    campaign, folder = freeze(spec if isinstance(spec, CampaignSpec) else load_spec(spec)), Path(out)
    if not folder.exists():
        require_flyable(campaign)
    total = campaign.flight(campaign.spec.draws, 0)
    with opened_queue(campaign, folder, total, workers, resume, progress, scheduler, slurm) as queue:
        store = queue.store
        try:
            draws = fly_draws(campaign, queue)
            rows = {f: row for f, row in store.by_flight.items() if f < campaign.flight(draws, 0)}
            fly_logs(campaign, queue, rows)
        except Interrupted:
            return Outcome(folder, campaign, store.by_flight, None, store.damaged)
        summary = summarize(campaign, rows)
        with complaints(folder):
            (folder / LOGS).mkdir(exist_ok=True)
        store.finish((Job(flight).key for flight in rows), _texts(campaign, rows, summary, folder))
        return Outcome(folder, campaign, rows, summary, store.damaged)


def require_flyable(campaign: Campaign) -> None:
    """Refuse a campaign of which a controller cannot take off for any of some draws, from first to last.

    Raises:
        ConfigError: naming the controller, and why it cannot take off for the first of them.
    """
    count = min(campaign.spec.draws, _TRIED)
    for name in campaign.names:
        why: list[str] = []
        for index in np.linspace(0, campaign.spec.draws - 1, count).astype(int).tolist():
            drawn = campaign.draw(index)
            experiment = campaign.experiment_of(drawn)
            try:
                ready(experiment, campaign.load(name, robot_of(experiment), campaign.gains_of(drawn, name)))
                break
            except CompileError:
                raise  # says something of this machine, nothing of the draw
            except SkylimbError as error:
                why.append(f"draw {index}: {error}")
        else:
            raise ConfigError(f"controller '{name}' can fly none of {count} draws; {why[0]}")


def report_campaign(folder: str | Path) -> Outcome:
    """Work out a folder's summary and report anew from its flights; also of a campaign that is not through.

    Raises:
        OutputError: when there is no campaign there, or nothing has flown.
    """
    folder = Path(folder)
    campaign = load_campaign(folder)
    rows, damaged = load_rows(folder, campaign)
    if not rows:
        file = STORE_FILE if (folder / STORE_FILE).is_file() else TABLE_FILE
        raise OutputError(
            f"'{folder / file}' is damaged or of another campaign than {SPEC_FILE}, and holds no flight that "
            "can be trusted; `skylimb campaign --resume` flies them again"
            if damaged
            else f"campaign folder '{folder}' holds no flight yet"
        )
    summary = summarize(campaign, rows)
    with complaints(folder):
        for name, text in _texts(campaign, rows, summary, folder).items():
            replace_text(folder / name, text)
    return Outcome(folder, campaign, rows, summary, damaged)


@contextmanager
def opened_queue(
    campaign: Campaign,
    folder: Path,
    total: int,
    workers: int | None = None,
    resume: bool = False,
    progress: Report | None = None,
    scheduler: str = "",
    slurm: str = "",
) -> Iterator[FlightQueue]:
    """A queue that flies into a folder; campaigns and searches share it.

    Args:
        campaign: what is flown.
        folder: where it is kept.
        total: flights that it takes at most.
        workers: as of `run_campaign`, like all that follows.
        resume: whether the folder may be there already.
        progress: called with the progress.
        scheduler: address of a Dask scheduler, to fly there.
        slurm: a SLURM queue, to fly there.
    """
    check_workers(workers, scheduler, slurm)
    if folder.exists():
        begin_folder(folder, campaign, resume)  # one that cannot be used asks no cluster for workers
    with (
        watching_interrupts() as stop,
        closing(make_engine(campaign.text, workers, scheduler, slurm)) as engine,
        open_store(folder, campaign, resume) as store,  # after the engine: without one, no folder is begun
    ):
        yield FlightQueue(store, engine, stop, progress or (lambda _: None), total)


def fly_draws(campaign: Campaign, queue: FlightQueue) -> int:
    """Fly every flight that is missing, until the draws or the stopping rule are through.

    Returns:
        The number of draws that the campaign has. The store may hold more, flown before a kill; they do not
        stand in the way of a look.
    """
    for draws in looks(campaign):
        jobs = [Job(flight, log=log_flag(campaign)) for flight in range(campaign.flight(draws, 0))]
        queue.fly([job for job in jobs if job.key not in queue.store.rows])
        if enough(campaign, queue.store.by_flight, draws):
            return draws
    return campaign.spec.draws


def fly_logs(campaign: Campaign, queue: FlightQueue, rows: Mapping[int, Row]) -> None:
    """Fly again those flights whose log is wanted and not there: the worst are known only at the end."""
    wanted = wanted_logs(campaign, rows)
    missing = set(wanted) - logged(queue.store.folder, (rows[flight] for flight in wanted))
    queue.fly([Job(flight, log="always") for flight in sorted(missing)])


def _texts(campaign: Campaign, rows: Mapping[int, Row], summary: Summary, folder: Path) -> dict[str, str]:
    from skylimb.studies.campaign.report import render_report  # draws, which the flights need not wait for

    kept = logged(folder, rows.values())
    return {
        SUMMARY_FILE: summary_json(campaign, rows, summary),
        REPORT_FILE: render_report(campaign, rows, summary, kept, folder),
    }
