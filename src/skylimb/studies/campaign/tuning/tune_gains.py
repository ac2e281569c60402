"""The public call: search gains, judge them, leave presets."""

from __future__ import annotations

from pathlib import Path

from skylimb.base.errors import ConfigError, extra_module
from skylimb.studies.campaign.flight_queue import Interrupted, Report
from skylimb.studies.campaign.fly_campaign import opened_queue
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.reading import load_spec
from skylimb.studies.campaign.spec import CampaignSpec
from skylimb.studies.campaign.tuning.gains import present_gains
from skylimb.studies.campaign.tuning.results import texts
from skylimb.studies.campaign.tuning.search import search_gains
from skylimb.studies.campaign.tuning.verdict import TuneOutcome, judge


def tune(
    spec: str | Path | CampaignSpec,
    out: str | Path,
    *,
    workers: int | None = None,
    resume: bool = False,
    progress: Report | None = None,
) -> TuneOutcome:
    """Search the gains that the spec's `[tune]` names, for each of its controllers, or go on with a search.

    Args:
        spec: a campaign's TOML file with a table `[tune]`, or a spec at hand.
        out: folder for NAME.toml for each controller, verdict.json, trials.csv, spec.toml and
            flights.parquet.
        workers: processes on this machine; all cores by default, 0 flies in this process.
        resume: whether `out` may be there already; flights in it are not flown again, and what is found is
            the same as without the interruption.
        progress: called with the progress, twice a second or more often.

    Returns:
        The outcome; not complete when Ctrl-C stopped it.

    Raises:
        ConfigError: when the spec cannot be searched, or the extra `tune` is not installed.
        OutputError: when the folder cannot be used; nothing in it has been touched then. Or when the disk is
            full; what was flown before is kept.
    """
    spec = spec if isinstance(spec, CampaignSpec) else load_spec(spec)
    if spec.tune is None:
        raise ConfigError("the spec has no table [tune]; it names objective and gains")
    search, folder, cma = spec.tune, Path(out), extra_module("cma")
    campaign, objective = freeze(spec, "search"), spec.scores[search.objective]
    starts = {name: present_gains(campaign, name, search) for name in campaign.names}
    total = len(campaign.names) * (search.trials * spec.draws + 2 * search.held_out)
    with opened_queue(campaign, folder, total, workers, resume, progress) as queue:
        store = queue.store
        try:
            trials = {name: search_gains(cma, queue, name, starts[name], search) for name in campaign.names}
            tuned, ranks = judge(queue, starts, trials, search)
        except Interrupted:
            return TuneOutcome(folder, objective, search.held_out, flown=len(store.rows), total=total)
        outcome = TuneOutcome(folder, objective, search.held_out, tuned, ranks, len(store.rows), total)
        store.finish(store.rows, texts(campaign, outcome, trials))
        return outcome
