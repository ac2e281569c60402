"""Searches gains over a campaign's draws, and judges what it found on draws that it has not seen.

The search is CMA-ES (the `cma` package), which needs no gradient, bears noise and compares trials by their
order alone. Every controller gets the same number of trials over the same draws, its own gains being the
first of them.
"""

from __future__ import annotations

import csv
import importlib
import io
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.analysis.metrics import DESCRIPTIONS
from skylimb.campaign.bench import Job
from skylimb.campaign.coordinator import DEATHS, Progress, Report, StopSign, watching_interrupts
from skylimb.campaign.draws import changed
from skylimb.campaign.engines import Done, Engine
from skylimb.campaign.frozen import Campaign, freeze
from skylimb.campaign.rows import QUARANTINED, Row, make_row
from skylimb.campaign.run import best_driver, local_engine
from skylimb.campaign.spec import GOALS, CampaignSpec, Search, load_spec
from skylimb.campaign.statistics import Paired, bootstrap_rows, compare_paired, is_success, rank
from skylimb.config import write_toml
from skylimb.control.controller import resolved_preset
from skylimb.errors import ConfigError
from skylimb.recording.files import new_folder, require_new
from skylimb.robots.loader import load_robot

_LOSS = 1e6
"""What a flight without success adds to a trial's cost: more than any metric can."""

Gains = dict[str, float]


@dataclass(frozen=True)
class Tuned:
    """What the search found for one controller.

    Attributes:
        name: of the controller.
        before: its gains as they were.
        after: the best found.
        cost: of the best, over the draws of the search.
        trials: how many sets of gains were flown.
        held_out: the tuned against the untuned controller over the held-out draws, by badness.
        successes: on the held-out draws, tuned and untuned.
    """

    name: str
    before: Gains
    after: Gains
    cost: float
    trials: int
    held_out: Paired
    successes: tuple[int, int]

    @property
    def better(self) -> bool:
        """Whether the held-out draws tell the tuned controller from the untuned one, to its advantage."""
        return self.held_out.dominance_low > 0.0


@dataclass(frozen=True)
class TuneOutcome:
    """What `tune` left in a folder.

    Attributes:
        folder: where.
        objective: the metric.
        draws: how many held-out draws the verdict rests on.
        tuned: by controller.
        ranks: of the tuned controllers among each other, over the held-out draws.
    """

    folder: Path
    objective: str
    draws: int
    tuned: dict[str, Tuned]
    ranks: dict[str, int]

    def lines(self) -> list[str]:
        """The verdict in words, a line a controller."""
        text, unit = DESCRIPTIONS[self.objective]
        said = []
        for name, found in self.tuned.items():
            pair, goal = found.held_out, GOALS[self.objective]
            verdict = "better" if found.better else "not told from the untuned one"
            difference = f"{goal * pair.median:+.4f}" if np.isfinite(pair.median) else "decided by losses"
            said.append(
                f"{name} (rank {self.ranks[name]}): {verdict} on {self.draws} held-out draws; {text.lower()} "
                f"{difference} {unit if unit != '1' else ''}".rstrip()
                + f", better in {pair.wins}, equal in {pair.ties}, worse in {pair.defeats}"
            )
        return said


def tune(
    spec: str | Path | CampaignSpec,
    out: str | Path,
    *,
    workers: int | None = None,
    progress: Report | None = None,
) -> TuneOutcome:
    """Search the gains that the spec's `[tune]` names, for each of its controllers.

    Ctrl-C ends the search; the verdict on what it found is still flown.

    Args:
        spec: a campaign's TOML file with a table `[tune]`, or a spec at hand.
        out: new folder: NAME.toml for each controller, verdict.json, trials.csv and spec.toml.
        workers: processes on this machine; all cores by default, 0 flies in this process.
        progress: told how far it is.

    Raises:
        ConfigError: when something asked for cannot be searched, or the extra `tune` is not installed.
        OutputError: when the folder exists.
    """
    spec = spec if isinstance(spec, CampaignSpec) else load_spec(spec)
    if spec.tune is None:
        raise ConfigError("the spec has no table [tune]; it names objective and gains")
    folder, search = require_new(out), spec.tune
    cma = _cma()
    campaign = freeze(spec, best_driver())
    starts = {name: _present_gains(campaign, name, search) for name in campaign.names}
    engine = local_engine(campaign.to_mapping(), workers)
    count = len(campaign.names)
    total = count * (search.trials * spec.draws + 2 * search.held_out)
    stop = StopSign()
    flights = _Flights(campaign, engine, total, stop, progress or (lambda _: None))
    trials: list[tuple[str, int, float, Gains]] = []
    try:
        with watching_interrupts(stop):
            best = {
                name: _search(cma, flights, name, starts[name], search, trials) for name in campaign.names
            }
            outcome = _judge(flights, folder, starts, best, search, trials)
    except BaseException:
        engine.close(now=True)
        raise
    engine.close()
    _write(campaign, outcome, trials)
    return outcome


class _Flights:
    """Flies sets of gains over draws, and tells how far it is."""

    def __init__(
        self, campaign: Campaign, engine: Engine, total: int, stop: StopSign, report: Report
    ) -> None:
        import time

        self.campaign, self.stop = campaign, stop
        self._engine, self._report, self._clock = engine, report, time.monotonic
        self._progress, self._begun = Progress(0, total, 0), time.monotonic()

    def fly(self, wanted: Sequence[tuple[str, Gains, range]]) -> list[list[Row]]:
        """The rows of each controller with these gains over these draws, in the order given."""
        order = [
            [
                Job(self.campaign.flight(draw, self.campaign.names.index(name)), tuple(sorted(gains.items())))
                for draw in draws
            ]
            for name, gains, draws in wanted
        ]
        rows: dict[Job, Row] = {}
        # Equal jobs, the same gains asked for twice, fly once.
        queue, deaths = list(dict.fromkeys(job for jobs in order for job in jobs))[::-1], dict[Job, int]()
        while queue or self._engine.flying:
            while queue and self._engine.free > 0:
                job = queue.pop()
                if not self._engine.submit((job,)):
                    queue.append(job)
            for event in self._engine.wait(0.5):
                if isinstance(event, Done):
                    rows |= {job: flown.row for job, flown in zip(event.jobs, event.flown, strict=True)}
                    continue
                for job in event.jobs:
                    deaths[job] = deaths.get(job, 0) + 1
                    if deaths[job] < DEATHS:
                        queue.insert(0, job)
                    else:
                        rows[job] = make_row(self.campaign, job.flight, QUARANTINED, "its worker died", {})
            self._tell(len(rows))
        self._progress.done = self._progress.flown
        return [[rows[job] for job in jobs] for jobs in order]

    def _tell(self, flown: int) -> None:
        self._progress.flown = self._progress.done + flown
        self._progress.seconds = self._clock() - self._begun
        shown = Progress(
            self._progress.flown, self._progress.total, 0, self._progress.flown, self._progress.seconds
        )
        self._report(shown)


def _search(
    cma: Any,
    flights: _Flights,
    name: str,
    start: Gains,
    search: Search,
    trials: list[tuple[str, int, float, Gains]],
) -> tuple[Gains, float]:
    """The best gains of a controller and their cost; its own gains are the first trial."""
    spec = flights.campaign.spec
    draws = range(spec.draws)
    options = {"bounds": [0.0, 1.0], "seed": spec.seed + 1, "verbose": -9, "maxfevals": search.trials}
    strategy = cma.CMAEvolutionStrategy(_unit(start, search), search.spread, options)
    best, least = start, _cost(flights.campaign, flights.fly([(name, start, draws)])[0], search)
    trials.append((name, 0, least, start))
    left = search.trials - 1
    while left > 0 and not flights.stop.raised and not strategy.stop():
        points = strategy.ask()
        tried = [_gains(point, search) for point in points[:left]]
        costs = [
            _cost(flights.campaign, rows, search)
            for rows in flights.fly([(name, gains, draws) for gains in tried])
        ]
        for gains, cost in zip(tried, costs, strict=True):
            trials.append((name, search.trials - left, cost, gains))
            left -= 1
            if cost < least:
                best, least = gains, cost
        if len(tried) < len(points):  # the budget ends within a generation, which then teaches nothing more
            break
        strategy.tell(points, costs)
    return best, least


def _cost(campaign: Campaign, rows: Sequence[Row], search: Search) -> float:
    """Losses first, then the median of the objective over the successes."""
    good = [row[search.objective] for row in rows if is_success(campaign, row)]
    values = [GOALS[search.objective] * value for value in good if value is not None]
    return _LOSS * (len(rows) - len(values)) + (float(np.median(values)) if values else 0.0)


def _judge(
    flights: _Flights,
    folder: Path,
    starts: Mapping[str, Gains],
    best: Mapping[str, tuple[Gains, float]],
    search: Search,
    trials: Sequence[tuple[str, int, float, Gains]],
) -> TuneOutcome:
    """Fly tuned and untuned controllers over draws that no trial has flown."""
    campaign = flights.campaign
    draws = range(campaign.spec.draws, campaign.spec.draws + search.held_out)
    wanted = [(name, gains, draws) for name in campaign.names for gains in (best[name][0], starts[name])]
    flown = flights.fly(wanted)
    resampled = bootstrap_rows(search.held_out, campaign.spec.seed)
    tuned, columns = {}, []
    for index, name in enumerate(campaign.names):
        after, before = flown[2 * index], flown[2 * index + 1]
        columns.append(_badness(campaign, after, search))
        tuned[name] = Tuned(
            name,
            starts[name],
            best[name][0],
            best[name][1],
            sum(trial[0] == name for trial in trials),
            compare_paired(columns[-1], _badness(campaign, before, search), resampled),
            (_successes(campaign, after), _successes(campaign, before)),
        )
    ranks = rank(np.column_stack(columns), resampled)
    return TuneOutcome(
        folder, search.objective, search.held_out, tuned, dict(zip(campaign.names, ranks, strict=True))
    )


def _badness(campaign: Campaign, rows: Sequence[Row], search: Search) -> np.ndarray:
    values = [row[search.objective] if is_success(campaign, row) else None for row in rows]
    return np.array([np.inf if value is None else GOALS[search.objective] * value for value in values])


def _successes(campaign: Campaign, rows: Sequence[Row]) -> int:
    return sum(is_success(campaign, row) for row in rows)


def _present_gains(campaign: Campaign, name: str, search: Search) -> Gains:
    """The gains that are searched, as the controller has them now."""
    if "preset" not in campaign.controllers[name]:
        raise ConfigError(f"controller '{name}' is a Python file; its gains cannot be searched from outside")
    robot = load_robot(campaign.experiment_of(campaign.draw(0)).robot)
    tables = resolved_preset(campaign.load(name, robot))
    found: Gains = {}
    for key in search.gains:
        node: Any = tables
        for part in key.split("."):
            if isinstance(node, list | tuple) and part.isdigit() and int(part) < len(node):
                node = node[int(part)]
            else:
                node = node.get(part) if isinstance(node, Mapping) else None
        if not isinstance(node, int | float) or isinstance(node, bool):
            raise ConfigError(
                f"tune.gains.'{key}' is no single number of controller '{name}'; `skylimb show {name}`"
            )
        found[key] = float(node)
    for end in (0, 1):
        campaign.load(name, robot, {key: bounds[end] for key, bounds in search.gains.items()})
    return found


def _unit(gains: Gains, search: Search) -> list[float]:
    """Gains as a point of the unit cube, kept a little off its faces."""
    point = []
    for key, (low, high) in search.gains.items():
        value = float(np.clip(gains[key], low, high))
        if search.logarithmic:
            point.append(np.log(value / low) / np.log(high / low))
        else:
            point.append((value - low) / (high - low))
    # The search wants two coordinates at least; where there is one gain, the second moves nothing.
    point += [0.5] * (2 - len(point))
    return [float(np.clip(entry, 0.01, 0.99)) for entry in point]


def _gains(point: Sequence[float], search: Search) -> Gains:
    found = {}
    for entry, (key, (low, high)) in zip(point, search.gains.items(), strict=False):
        share = float(np.clip(entry, 0.0, 1.0))
        found[key] = low * (high / low) ** share if search.logarithmic else low + (high - low) * share
    return found


def _cma() -> Any:
    try:
        return importlib.import_module("cma")
    except ImportError:
        raise ConfigError("'cma' is not installed: pip install 'skylimb[tune]'") from None


def _write(campaign: Campaign, outcome: TuneOutcome, trials: Sequence[tuple[str, int, float, Gains]]) -> None:
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    keys = list(next(iter(outcome.tuned.values())).before)
    writer.writerow(["controller", "trial", "cost", *keys])
    writer.writerows(
        [name, number, repr(cost), *(repr(gains[key]) for key in keys)]
        for name, number, cost, gains in trials
    )
    verdict = {
        "objective": outcome.objective,
        "held_out_draws": outcome.draws,
        "controllers": {
            name: {
                "rank": outcome.ranks[name],
                "better": found.better,
                "trials": found.trials,
                "before": found.before,
                "after": found.after,
                "successes": {"tuned": found.successes[0], "untuned": found.successes[1]},
                "tuned_less_untuned": {
                    key: value if np.isfinite(value) else str(value)
                    for key, value in found.held_out._asdict().items()
                },
            }
            for name, found in outcome.tuned.items()
        },
    }
    with new_folder(outcome.folder) as aside:
        for name, found in outcome.tuned.items():
            preset = _preset(campaign, name, found.after, outcome.folder)
            (aside / f"{name}.toml").write_text(write_toml(preset), encoding="utf-8")
        (aside / "verdict.json").write_text(
            json.dumps(verdict, indent=2, allow_nan=False) + "\n", encoding="utf-8"
        )
        (aside / "trials.csv").write_text(table.getvalue(), encoding="utf-8")
        (aside / "spec.toml").write_text(write_toml(campaign.to_mapping()), encoding="utf-8")


def _preset(campaign: Campaign, name: str, gains: Gains, folder: Path) -> dict[str, Any]:
    """The tuned preset's tables; a law in a file of the user's is named as seen from the new folder."""
    entry = campaign.controllers[name]
    tables = changed(entry["preset"], gains)
    for slot in tables.values():
        if isinstance(slot, dict) and str(slot.get("law", "")).endswith(".py"):
            slot["law"] = Path(os.path.relpath(Path(entry["path"]).parent / slot["law"], folder)).as_posix()
    text = str(tables.get("description", name)).rstrip(".")
    return {**tables, "description": f"{text}; tuned for {campaign.spec.experiment}"}
