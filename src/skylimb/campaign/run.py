"""The public calls: fly a campaign, and write its report anew."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skylimb.campaign.coordinator import (
    Progress,
    Report,
    StopSign,
    fly_logs,
    fly_missing,
    watching_interrupts,
)
from skylimb.campaign.engines import Engine
from skylimb.campaign.engines.inline import InlineEngine
from skylimb.campaign.engines.local import LocalEngine
from skylimb.campaign.frozen import NATIVE, PYTHON, Campaign, freeze
from skylimb.campaign.reading import load_spec
from skylimb.campaign.report import render_report
from skylimb.campaign.rows import Row
from skylimb.campaign.spec import CampaignSpec
from skylimb.campaign.store import (
    REPORT_FILE,
    SUMMARY_FILE,
    load_campaign,
    load_rows,
    logged,
    open_store,
    write_texts,
)
from skylimb.campaign.summary import Summary, summarize, summary_json
from skylimb.errors import ConfigError, OutputError
from skylimb.flights.takeoff import plant_and_mission
from skylimb.robots.loader import load_robot

MOST_WORKERS = 1024

BATCH = {PYTHON: 1, NATIVE: 4}
"""Flights that a worker gets at once: the native driver flies them side by side; a kill costs no more."""


@dataclass(frozen=True)
class Outcome:
    """What a campaign came to.

    Attributes:
        folder: where everything lies.
        campaign: what was flown.
        rows: by flight.
        summary: None when it was stopped before its end.
        damaged: entries that were found torn or altered, and flown again.
    """

    folder: Path
    campaign: Campaign
    rows: dict[int, Row]
    summary: Summary | None
    damaged: int

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
    """Fly a campaign, or go on with one.

    Args:
        spec: the TOML file, or a spec at hand.
        out: the campaign's folder.
        workers: processes on this machine, or jobs on SLURM; all cores by default, 0 flies in this process.
        resume: whether `out` may be there already; flights in it are not flown again.
        scheduler: address of a Dask scheduler, such as tcp://HOST:8786, to fly there.
        slurm: a SLURM queue, to fly there.
        progress: told how far it is, twice a second or more often.

    Returns:
        The outcome; not complete when Ctrl-C stopped it.

    Raises:
        ConfigError: when the spec cannot be flown; nothing has been written then.
        OutputError: when the folder cannot be used; nothing in it has been touched then. Or when the disk
            is full; what was flown before is kept.
    """
    if scheduler and slurm:
        raise ConfigError("scheduler and slurm exclude each other: choose one")
    if workers is not None and not 0 <= workers <= MOST_WORKERS:
        raise ConfigError(f"workers = {workers} must be 0 .. {MOST_WORKERS}")
    campaign = freeze(spec if isinstance(spec, CampaignSpec) else load_spec(spec), best_driver())
    folder = Path(out)
    if not folder.exists():
        first = campaign.experiment_of(campaign.draw(0))
        plant_and_mission(first, load_robot(first.robot))
    stop, report = StopSign(), progress or _silent
    with watching_interrupts(stop), open_store(folder, campaign, resume) as store:
        engine = _engine(campaign.to_mapping(), workers, scheduler, slurm)
        try:
            draws = fly_missing(campaign, store, engine, report, stop, BATCH[campaign.driver])
            through = draws is not None
            if draws is not None:
                store.rows = {f: row for f, row in store.rows.items() if f < campaign.flight(draws, 0)}
                through = fly_logs(campaign, store, engine, report, stop)
        except BaseException:
            engine.close(now=True)
            raise
        engine.close()
        if not through:
            store.settle()
            return Outcome(folder, campaign, store.rows, None, store.damaged)
        summary = summarize(campaign, store.rows)
        store.finish(_texts(campaign, store.rows, summary, folder))
        return Outcome(folder, campaign, store.rows, summary, store.damaged)


def report_campaign(folder: str | Path) -> Outcome:
    """Work out a folder's summary and report anew from its table; also of a campaign that is not through.

    Raises:
        OutputError: when there is no campaign there, or nothing has flown.
    """
    folder = Path(folder)
    campaign = load_campaign(folder)
    rows, damaged = load_rows(folder, campaign)
    if not rows:
        raise OutputError(f"campaign folder '{folder}' holds no flight yet")
    summary = summarize(campaign, rows)
    try:
        write_texts(folder, _texts(campaign, rows, summary, folder))
    except OSError as error:
        raise OutputError(f"cannot write report in '{folder}': {error.strerror or error}") from error
    return Outcome(folder, campaign, rows, summary, damaged)


def _texts(campaign: Campaign, rows: Mapping[int, Row], summary: Summary, folder: Path) -> dict[str, str]:
    kept = logged(folder, rows.values())
    return {
        SUMMARY_FILE: summary_json(campaign, rows, summary),
        REPORT_FILE: render_report(campaign, rows, summary, kept),
    }


def _engine(tables: Mapping[str, Any], workers: int | None, scheduler: str, slurm: str) -> Engine:
    if scheduler:
        from skylimb.campaign.engines.cluster import connect

        return connect(tables, scheduler)
    if slurm:
        from skylimb.campaign.engines.slurm import on_slurm

        return on_slurm(tables, slurm, workers or 4, {})
    return local_engine(tables, workers)


def local_engine(tables: Mapping[str, Any], workers: int | None) -> Engine:
    """An engine on this machine: all cores by default, this process alone for 0."""
    if workers is not None and not 0 <= workers <= MOST_WORKERS:
        raise ConfigError(f"workers = {workers} must be 0 .. {MOST_WORKERS}")
    if workers == 0:
        return InlineEngine(tables)
    return LocalEngine(tables, workers or cores())


def best_driver() -> str:
    """The native driver where a C compiler has built it, else the Python driver."""
    from skylimb.flights.drivers.native import native_available

    return NATIVE if native_available() else PYTHON


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _silent(progress: Progress) -> None:
    """Tell nobody."""
