"""A campaign with all that its flights depend on resolved: what goes to workers and stays in the folder.

Files are read once, when a campaign begins. What they said stays in the folder's spec.toml, so that a resumed
campaign can tell whether an experiment, a preset, a user's code or a version has changed in the meantime.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

from skylimb.analysis.recording.versions import computing_versions
from skylimb.analysis.scores.user_scores import metric_file
from skylimb.base.config import flatten, value_of
from skylimb.base.errors import ConfigError
from skylimb.control.controller import (
    Controller,
    controller_from_tables,
    is_traceable,
    load_controller,
)
from skylimb.control.corrections import read_corrections, with_corrections
from skylimb.control.laws.preset import preset_mapping, preset_names
from skylimb.control.laws.traced_step import traced_step
from skylimb.flight.experiments.experiment import Experiment, experiment_from_mapping, experiment_tables
from skylimb.flight.flight_run import config_units
from skylimb.robots.loader import load_robot
from skylimb.robots.model import Robot
from skylimb.studies.campaign.code import code_files, law_digests
from skylimb.studies.campaign.digests import (
    by_path,
    code_digest,
    code_sources,
    file_digests,
    sources_read,
)
from skylimb.studies.campaign.draws import GAIN, Draw, changed, draw
from skylimb.studies.campaign.reading import FROZEN, spec_from_mapping
from skylimb.studies.campaign.spec import CampaignSpec

FORMAT_VERSION = 4
"""Of a campaign's folder."""

_RESOLVED = ("purpose", "robots", "versions", "experiment", "controllers", "use", "files")
"""What a folder keeps of a campaign besides its spec, in this order."""

CHECKED_DRAWS = 20_000
"""Draws that are checked before take-off; later ones are checked when they are flown."""


_DIGEST = 64
"""Digits of a digest, which nobody reads to the end."""

_CHECKED_GAINS = 64
"""Draws of gains with which each controller is made before take-off."""


@dataclass(frozen=True)
class Campaign:
    """A campaign ready to fly.

    Attributes:
        spec: as its user wrote it.
        experiment: tables of the experiment, with the spec's `set` in them.
        controllers: by name, the file it came from and its preset's tables, or the digest of the user's code.
        robots: name of each robot that a draw may fly -> digest of its files.
        versions: of everything that computes, this package's code among it. The driver is not: all give the
            same bits.
        purpose: "campaign", or "search" where the flights are those of `skylimb tune`.
        use: files with metrics of the user's -> digest.
        files: keys of the experiment that name a file (a drawing, a height map, a mesh) -> digest of what the
            draws may read.
        read: the user's files that these digests are of -> digest of each, so that one that changes is named.
            They are no part of what makes two campaigns the same: a folder that was moved has others.
    """

    spec: CampaignSpec
    experiment: dict[str, Any]
    controllers: dict[str, dict[str, Any]]
    robots: dict[str, str]
    versions: dict[str, str]
    purpose: str = "campaign"
    use: dict[str, str] = field(default_factory=dict)
    files: dict[str, str] = field(default_factory=dict)
    read: dict[str, str] = field(default_factory=dict, compare=False)

    @property
    def names(self) -> tuple[str, ...]:
        """The controllers' names, in the spec's order."""
        return tuple(self.controllers)

    def flight(self, draw: int, controller: int) -> int:
        """Index of a flight: draw by draw, controller by controller."""
        return draw * len(self.controllers) + controller

    def split(self, flight: int) -> tuple[int, str]:
        """Draw and controller of a flight."""
        number, controller = divmod(flight, len(self.controllers))
        return number, self.names[controller]

    def draw(self, index: int) -> Draw:
        """A draw; see `skylimb.studies.campaign.draws`."""
        return draw(self.spec, index)

    def experiment_of(self, drawn: Draw) -> Experiment:
        """The experiment of a draw, checked.

        Raises:
            ConfigError: naming the draw and what is wrong with it.
        """
        changes = {key: value for key, value in drawn.values.items() if not key.startswith(GAIN)}
        return self._experiment({**changes, "seed": drawn.seed}, f"draw {drawn.index}")

    def _experiment(self, changes: Mapping[str, Any], where: str) -> Experiment:
        return experiment_from_mapping(changed(self.experiment, changes), where)

    def gains_of(self, drawn: Draw, name: str) -> dict[str, Any]:
        """The drawn gains that a controller has."""
        only = self.spec.only
        return {key: value for key, value in drawn.gains.items() if name in only.get(GAIN + key, (name,))}

    def load(self, name: str, robot: Robot, gains: Mapping[str, Any] | None = None) -> Controller:
        """A controller of the campaign, some of its gains replaced."""
        entry = self.controllers[name]
        path = Path(entry["path"])
        if "preset" not in entry:
            return load_controller(str(path), robot, gains)
        return controller_from_tables(entry["preset"], path, robot, gains)

    def units(self) -> dict[str, str]:
        """Unit of everything that is drawn and has one, by its key."""
        experiment = self._experiment({}, "campaign")
        robot, known = load_robot(experiment.robot), dict[str, str]()
        for name in self.names:
            known |= config_units(experiment, self.load(name, robot))
        # An entry of a list has the unit of the list.
        whole = {key: key if key in known else key.rpartition(".")[0] for key in self.spec.vary}
        return {key: known[table] for key, table in whole.items() if table in known}

    def to_mapping(self) -> dict[str, Any]:
        """What makes two campaigns the same: the spec, and a table with all that was resolved."""
        resolved = {name: getattr(self, name) for name in _RESOLVED}
        frozen = {name: value for name, value in resolved.items() if value or name not in ("use", "files")}
        return {**self.spec.to_mapping(), FROZEN: {"format": FORMAT_VERSION, **frozen}}

    @property
    def tables(self) -> dict[str, Any]:
        """What the folder's spec.toml holds: that, and which files were read."""
        mapping = self.to_mapping()
        return {**mapping, FROZEN: {**mapping[FROZEN], "read": self.read}} if self.read else mapping

    @property
    def text(self) -> str:
        """The same as JSON: what a worker on any machine needs to know."""
        return json.dumps(self.tables)


def freeze(spec: CampaignSpec, purpose: str = "campaign") -> Campaign:
    """Resolve a spec and check it: every key, every range, every draw and every controller.

    Args:
        spec: what to fly.
        purpose: see `Campaign`.

    Raises:
        SkylimbError: naming what cannot be flown; nothing has been written then.
    """
    tables = _tables(spec)
    own = experiment_from_mapping(tables, "set").robot
    chosen = spec.vary["robot"].extremes() if "robot" in spec.vary else [own]
    robots = {str(name): load_robot(str(name)) for name in chosen}
    controllers = {Path(name).stem: _controller(name, spec) for name in spec.controllers}
    if len(controllers) < len(spec.controllers):
        raise ConfigError(f"controllers = {list(spec.controllers)!r}: two of them have the same name")
    digests = {name: robot.description.digest for name, robot in robots.items()}
    use = {file: code_digest(metric_file(file)) for file in spec.use}
    campaign = Campaign(spec, tables, controllers, digests, computing_versions(), purpose, use)
    experiments = possible(campaign)
    read = [
        *(source for robot in robots.values() for source in robot.description.sources),
        *(source for sources in sources_read(experiments).values() for source in sources),
        *(source for file in code_files(use, controllers, spec) for source in code_sources(file)),
    ]
    campaign = dataclasses.replace(campaign, files=file_digests(experiments), read=by_path(read))
    for index in range(min(spec.draws, CHECKED_DRAWS)):
        campaign.experiment_of(campaign.draw(index))
    _require_controllers(campaign, robots.values())
    return campaign


def _tables(spec: CampaignSpec) -> dict[str, Any]:
    """The experiment's tables, with the spec's `set` in them."""
    tables = experiment_tables(spec.experiment)
    resolved = experiment_from_mapping(tables, f"experiment {tables['name']}").to_mapping()
    for key in spec.set:
        if key.startswith(GAIN):
            raise ConfigError(
                f"set.'{key}': gains are fixed in a preset's own file; "
                f"vary.'{key}' = {{ choice = [...] }} varies them"
            )
    for key in (*spec.set, *spec.vary):
        tables = _fill_list(tables, resolved, key)
    return changed(tables, spec.set)


def possible(campaign: Campaign) -> list[Experiment]:
    """The experiment with each key at each end of its range, one by one, so that a message names the key."""
    ends = [
        ({key: value}, f"vary.'{key}'")
        for key, entry in campaign.spec.vary.items()
        if not key.startswith(GAIN)
        for value in entry.extremes()
    ]
    return [campaign._experiment(*end) for end in [({}, "set"), *ends]]


def _require_controllers(campaign: Campaign, robots: Collection[Robot]) -> None:
    """Make every controller for every robot, with many of the gains that will be drawn."""
    varied = any(key.startswith(GAIN) for key in campaign.spec.vary)
    for index in range(min(campaign.spec.draws, _CHECKED_GAINS) if varied else 1):
        drawn = campaign.draw(index)
        for name, robot in product(campaign.names, robots):
            controller = campaign.load(name, robot, campaign.gains_of(drawn, name))
            if index == 0 and "code" in campaign.controllers[name] and is_traceable(controller):
                # A user's law that cannot be compiled is refused now, before a folder is begun.
                period = campaign.experiment_of(drawn).control_period
                traced_step(controller, period, len(controller.needs.preview))


def campaign_from_mapping(mapping: Mapping[str, Any], where: str) -> Campaign:
    """A campaign from what `Campaign.to_mapping` wrote; nothing is looked up again."""
    frozen = mapping.get(FROZEN)
    if not isinstance(frozen, dict) or "format" not in frozen:
        raise ConfigError(f"{where} was not written by a campaign (it has no table [{FROZEN}])")
    if frozen["format"] != FORMAT_VERSION:
        raise ConfigError(
            f"{where} has folder format {frozen['format']}, this skylimb has {FORMAT_VERSION}: fly anew, "
            "into another folder"
        )
    resolved = {name: frozen[name] for name in (*_RESOLVED, "read") if name in frozen}
    return Campaign(spec_from_mapping(mapping, where), **resolved)


def differences(begun: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """What differs between two campaigns' tables, a line each: `draws: 100 -> 200`."""
    before, after = flatten(begun), flatten(now)
    keys = [*before, *(key for key in after if key not in before)]
    return [
        f"{key}: {_shown(before.get(key))} -> {_shown(after.get(key))}"
        for key in keys
        if before.get(key) != after.get(key)
    ]


def _shown(value: Any) -> str:
    text = "nothing" if value is None else repr(value)
    if isinstance(value, str) and len(value) == _DIGEST:
        return f"{value[:8]}..."
    return text if len(text) <= 60 else f"{text[:57]}..."


def _fill_list(tables: dict[str, Any], resolved: Mapping[str, Any], key: str) -> dict[str, Any]:
    """The tables with a list that only the defaults have, where a key picks one of its entries."""
    whole, _, last = key.rpartition(".")
    defaults = value_of(resolved, whole)
    if not last.isdigit() or not isinstance(defaults, list) or value_of(tables, whole) is not None:
        return tables
    return changed(tables, {whole: defaults})


def _controller(name: str, spec: CampaignSpec) -> dict[str, Any]:
    (mapping, path), calibration = preset_mapping(name), spec.calibration
    if path.suffix == ".py":
        if calibration:
            raise ConfigError(f"controller '{name}' is Python of its own; only presets fly calibrated")
        return {"path": path.as_posix(), "code": code_digest(path)}
    if calibration:
        mapping = with_corrections(mapping, path, read_corrections(calibration))
    laws = law_digests(mapping, path, spec)
    entry: dict[str, Any] = {
        "path": f"{name}.toml" if name in preset_names() else path.as_posix(),
        "preset": mapping,
    }
    return {**entry, "code": laws} if laws else entry
