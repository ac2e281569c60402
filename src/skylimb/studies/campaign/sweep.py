"""A sweep: every combination of some values flown, and the scores as one dataset over the swept keys.

    scores = skylimb.sweep("paper", over={"surface.friction": [0.1, 0.3, 0.5]}, seeds=4)
    scores.contact_fraction.mean("seed").plot()

It flies as a campaign does: the same queue, workers and compiled ticks, in a folder that is not kept.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from numbers import Integral
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import xarray as xr

from skylimb.analysis.recording import LOG_FILE, Run
from skylimb.analysis.scores.user_scores import UserScore, load_user_scores, metrics_of
from skylimb.base.config import to_mapping
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.studies.campaign.distributions import Distribution
from skylimb.studies.campaign.flight_queue import Interrupted, Report
from skylimb.studies.campaign.fly_campaign import opened_queue
from skylimb.studies.campaign.folder import log_name
from skylimb.studies.campaign.frozen import Campaign, freeze
from skylimb.studies.campaign.rows import Row
from skylimb.studies.campaign.spec import CampaignSpec
from skylimb.studies.campaign.worker import Job

FEW = 8
"""Flights below which starting workers takes longer than flying."""


def sweep(
    experiment: str = "paper",
    controller: str | Sequence[str] = "hybrid",
    over: Mapping[str, Sequence[Any] | np.ndarray] | None = None,
    *,
    seeds: int | Sequence[int] | np.ndarray = 1,
    set: Mapping[str, Any] | None = None,
    use: Sequence[str | Path | ModuleType | UserScore] = (),
    logs: str | Sequence[str] = (),
    workers: int | None = None,
    progress: Report | None = None,
) -> xr.Dataset:
    """Fly every combination of some values.

    Args:
        experiment: a name or a TOML file.
        controller: a name, a TOML file or a Python file, or several.
        over: dotted keys of the experiment, or of the controller with "controller." in front, and the values
            of each.
        seeds: of the sensors' noise: how many, from 0 on, or which.
        set: dotted keys and values of all flights.
        use: Python files with metrics of your own.
        logs: a signal that is kept as well, or several.
        workers: processes; by default one a core, and none for few flights. 0 flies in this process.
        progress: called with the progress, twice a second or more often.

    Returns:
        Every score over the swept keys, over `seed`, and over `controller` where there are several. Each has
        its unit and what it is. `status` and `cause` say what became of a flight; a lost one has no scores.
        Signals have the dimension `time` besides; shorter flights end with NaN.

    Raises:
        SkylimbError: naming what cannot be flown; nothing has flown then.
        KeyboardInterrupt: Ctrl-C.
    """
    names = [controller] if isinstance(controller, str) else list(controller)
    logs = [logs] if isinstance(logs, str) else list(logs)
    if set and "seed" in set:
        raise ConfigError(f"set['seed'] = {set['seed']!r}: of a sweep, seeds says which seeds fly")
    grids = _grids({} if over is None else over, seeds)
    fixed = {key: [value] for key, value in (set or {}).items() if key.startswith("controller.")}
    vary = {**grids, **fixed}
    spec = CampaignSpec(
        experiment=experiment,
        controllers=tuple(map(str, names)),
        draws=int(np.prod([len(values) for values in vary.values()])),
        logs="all" if logs else "none",
        set={key: value for key, value in (set or {}).items() if key not in fixed},
        use=_files(use),
        vary={key: Distribution(grid=tuple(values)) for key, values in vary.items()},
    )
    campaign = freeze(spec)
    total = campaign.flight(spec.draws, 0)
    if workers is None and total <= FEW:
        workers = 0
    with tempfile.TemporaryDirectory(prefix="skylimb-sweep-") as folder:
        home = Path(folder) / "sweep"
        rows = _rows(campaign, home, total, workers, bool(logs), progress)
        found = xr.Dataset(
            {key: ("flight", np.array([row[key] for row in rows], str)) for key in ("status", "cause")},
            attrs={"experiment": campaign.experiment["name"], "controller": ", ".join(campaign.names)},
        )
        for key, score in campaign.spec.scores.items():
            values = np.array([row[key] for row in rows], dtype=float)
            found[key] = ("flight", values, {"units": score.unit, "long_name": score.text()})
        found = _with_signals(found, home, rows, logs) if logs else found
    # Draw by draw, the first key turning fastest, and in each draw every controller.
    sizes = {**{key: len(grids[key]) for key in reversed(grids)}, "controller": len(names)}
    over_keys = found.map(_unfolded, keep_attrs=True, sizes=sizes).transpose(*grids, "controller", ...)
    axes = {**found.coords, **_coordinates(grids, campaign), "controller": list(campaign.names)}
    found = over_keys.assign_coords(axes)
    return found if len(names) > 1 else found.isel(controller=0, drop=True)


def _unfolded(values: xr.DataArray, sizes: Mapping[str, int]) -> xr.DataArray:
    """Values over the flights, (flight, ...), over what the flights are over."""
    of_flight = values.dims[1:]
    shape = (*sizes.values(), *(values.sizes[dim] for dim in of_flight))
    return xr.DataArray(values.values.reshape(shape), dims=(*sizes, *of_flight), attrs=values.attrs)


def _grids(
    over: Mapping[str, Sequence[Any] | np.ndarray], seeds: int | Sequence[int] | np.ndarray
) -> dict[str, list[Any]]:
    """The values of every swept key, and the seeds behind them."""
    if not isinstance(over, Mapping):
        raise ConfigError(f"over = {over!r} should be a table of keys and the values of each")
    if "seed" in over:
        raise ConfigError(f"over['seed'] is not swept over; seeds = {over['seed']!r} flies these seeds")
    grids = {}
    for key, values in over.items():
        if isinstance(values, str | bytes) or not hasattr(values, "__len__"):
            raise ConfigError(f"over['{key}'] = {values!r} should be a list of values")
        grids[key] = to_mapping(np.asarray(values) if isinstance(values, np.ndarray) else list(values))
        if not grids[key]:
            raise ConfigError(f"over['{key}'] is empty")
    return {**grids, "seed": _seeds(seeds)}


def _seeds(seeds: Any) -> list[int]:
    """The seeds: so many from 0 on, or those that are listed."""
    listed = range(seeds) if isinstance(seeds, Integral) else seeds
    if not isinstance(listed, Sequence | np.ndarray) or not all(isinstance(one, Integral) for one in listed):
        raise ConfigError(f"seeds = {seeds!r} should be a whole number or a list of whole numbers")
    if not len(listed):
        raise ConfigError(f"seeds = {seeds!r} is none; the least is one")
    return [int(seed) for seed in listed]


def _files(use: Sequence[str | Path | ModuleType | UserScore]) -> tuple[str, ...]:
    """The files of the user's metrics, which workers load."""
    files = []
    for item in use:
        if isinstance(item, str | Path):
            files.append(str(item))
            continue
        (first, *_) = metrics_of(load_user_scores([item])) or (None,)
        file = (
            item.__file__ if isinstance(item, ModuleType) else first and first.function.__code__.co_filename
        )
        if not file or not os.path.isfile(file):
            raise ConfigError(f"use = {item!r}: a sweep needs the Python file that the metric stands in")
        files.append(str(file))
    return tuple(dict.fromkeys(files))


def _rows(
    campaign: Campaign, home: Path, total: int, workers: int | None, logs: bool, progress: Report | None
) -> list[Row]:
    """The row of every flight, in order."""
    jobs = [Job(flight, log="always" if logs else "never") for flight in range(total)]
    with opened_queue(campaign, home, total, workers, progress=progress) as queue:
        try:
            queue.fly(jobs)
        except Interrupted:
            raise KeyboardInterrupt from None
        return list(queue.store.by_flight.values())


def _coordinates(grids: Mapping[str, Sequence[Any]], campaign: Campaign) -> dict[str, Any]:
    """The swept values, with their units; a list as its JSON text."""
    units, found = campaign.units(), {}
    for key, values in grids.items():
        plain = [json.dumps(value) if isinstance(value, list | dict) else value for value in values]
        found[key] = (key, plain, {"units": units[key]} if key in units else {})
    return found


def _with_signals(scores: xr.Dataset, home: Path, rows: Sequence[Row], names: Sequence[str]) -> xr.Dataset:
    """The scores with some signals of every flight, over flight and time."""
    paths = {row["flight"]: home / log_name(row) / LOG_FILE for row in rows}
    logs = {flight: Run.load(path).log for flight, path in paths.items() if path.is_file()}
    if not logs:  # every draw was refused
        return scores
    longest = max(logs.values(), key=lambda log: log.sizes["time"])
    for name in names:
        if name not in longest:
            raise unknown_name("signal", name, [str(known) for known in longest.data_vars])
        signal = longest[name]
        values = np.full((len(rows), *signal.shape), np.nan)
        for flight, log in logs.items():
            values[flight, : log.sizes["time"]] = log[name].values
        scores[name] = (("flight", *signal.dims), values, signal.attrs)
        scores = scores.assign_coords({dim: longest[dim] for dim in signal.dims if dim in longest.coords})
    return scores
