"""What there is to be shown: experiments, controllers, robots, surfaces, events, laws, tables, metrics ..."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from skylimb.analysis.scores.registry import SCORES, SETS
from skylimb.analysis.scores.score import Score
from skylimb.base.errors import unknown_name
from skylimb.base.keys import ANY_NUMBER, Table, keys_of, summary, tables_of
from skylimb.base.keys.fields import entry_section, fields_of, section_of
from skylimb.control.laws.preset import preset_from_mapping, preset_mapping
from skylimb.control.laws.preset_keys import law_tables, preset_tables
from skylimb.control.laws.slots import SLOTS, find_law, law_names
from skylimb.control.planning.trajectory_config import TrajectoryConfig
from skylimb.flight.events import EVENTS
from skylimb.flight.experiments.experiment import Settings
from skylimb.flight.experiments.listing import list_controllers, list_experiments
from skylimb.robots.flight_file import FlightFile
from skylimb.robots.loader import list_robots
from skylimb.simulation.surfaces import SURFACES
from skylimb.simulation.surfaces.surface_keys import SurfaceKeys
from skylimb.studies.campaign.spec import CampaignSpec

KINDS = {
    "experiment": "Experiments",
    "controller": "Controllers",
    "robot": "Robots",
    "surface": "Surfaces: surface.kind",
    "event": "Events: kind in [[events]]",
    "path": "Paths: trajectory.shape",
    "law": "Laws of the controller's slots: controller.SLOT.law",
    "table": "Tables of an experiment",
    "file": "Files of your own, every key with its default",
    "metric": "Metrics: scores of a flight",
}
"""Kinds of entries, and the heading of each in a list."""


@dataclass(frozen=True)
class Entry:
    """One thing that `skylimb show` shows.

    Attributes:
        kind: a key of `KINDS`.
        name: unique: "paper", "surface.cylinder", "event.push", "translation.pid", "metric.error_u_median".
        meaning: one line.
    """

    kind: str
    name: str
    meaning: str

    @property
    def short(self) -> str:
        """The name without its kind, as configurations write it."""
        return self.name.partition(".")[2] or self.name


def entries() -> list[Entry]:
    """Everything that ships, in the order of `KINDS`."""
    found = [Entry("experiment", name, text) for name, text in list_experiments().items()]
    found += [Entry("controller", name, text) for name, text in list_controllers().items()]
    found += [Entry("robot", name, text) for name, text in list_robots().items()]
    found += [Entry("surface", f"surface.{name}", summary(cls)) for name, cls in sorted(SURFACES.items())]
    found += [Entry("event", f"event.{name}", summary(cls)) for name, cls in sorted(EVENTS.items())]
    found += [Entry("path", f"path.{name}", text) for name, text in _paths().items()]
    found += [
        Entry("law", f"{slot}.{law}", summary(find_law(slot, law, Path())))
        for slot in SLOTS
        for law in law_names(slot)
    ]
    found += [Entry("table", name, summary(cls)) for name, cls in experiment_tables().items()]
    found += [Entry("file", name, summary(cls)) for name, cls in _FILES.items()]
    return found + [Entry("metric", f"metric.{name}", _metric(score)) for name, score in SCORES.items()]


EVENT = ("events", ANY_NUMBER)
"""Where the keys of an event stand in an experiment."""

_FILES = {"campaign": CampaignSpec, "flight": FlightFile}
"""Files that users write besides experiments and presets."""


def find_entry(name: str) -> Entry:
    """The entry of a name; the kind in front may be left out where the rest is enough.

    Raises:
        UnknownNameError: when there is none.
    """
    known = entries()[::-1]  # where two are called alike, the first one counts
    named = {entry.short: entry for entry in known} | {entry.name: entry for entry in known}
    if name not in named:
        raise unknown_name("experiment, controller, robot, surface, event, law, path or metric", name, named)
    return named[name]


def tables_of_entry(entry: Entry) -> list[Table]:
    """The keys of an entry with value, unit, range and meaning; none of a metric, which is no key."""
    return list(_TABLES[entry.kind](entry)) if entry.kind in _TABLES else []


def _path_tables(entry: Entry) -> Iterable[Table]:
    (table,) = tables_of(TrajectoryConfig, ("trajectory",))
    rows = tuple(
        (name, entry.short if name == "shape" else value, info)
        for name, value, info in table.rows
        if entry.short in (_shapes_of(info.meaning) or (entry.short,))
    )
    return [Table(table.path, entry.meaning, rows)]


def _law_tables(entry: Entry) -> Iterable[Table]:
    slot, _, law = entry.name.partition(".")
    return law_tables(slot, law, find_law(slot, law, Path()))


_TABLES: dict[str, Callable[[Entry], Iterable[Table]]] = {
    "controller": lambda entry: preset_tables(preset_from_mapping(*preset_mapping(entry.name))),
    "surface": lambda entry: tables_of(SURFACES[entry.short], ("surface",)),
    "event": lambda entry: tables_of(EVENTS[entry.short], EVENT),
    "path": _path_tables,
    "law": _law_tables,
    "table": lambda entry: tables_of(experiment_tables()[entry.name], (entry.name,)),
    "file": lambda entry: tables_of(_FILES[entry.name]),
}


def experiment_tables() -> dict[str, type]:
    """The tables of an experiment by name, with their classes; of the surface, what all kinds share."""
    found = {name: section_of(kind) or entry_section(kind) for name, (kind, _) in fields_of(Settings).items()}
    return {"surface": SurfaceKeys, **{name: cls for name, cls in found.items() if cls is not None}}


def _paths() -> dict[str, str]:
    """Every shape of a path, with the keys that count for it."""
    info = keys_of(TrajectoryConfig)["shape"]
    names = [str(choice) for choice in info.choices]
    keys = {
        name: [key for key, each in keys_of(TrajectoryConfig).items() if name in _shapes_of(each.meaning)]
        for name in names
    }
    return {name: f"its keys: {', '.join(keys[name])}" if keys[name] else "" for name in names}


def _shapes_of(meaning: str) -> tuple[str, ...]:
    """The shapes for which a key of a path counts, the words before the colon; none where for all."""
    head, colon, _ = meaning.partition(":")
    names = [name.strip() for name in head.split(",")]
    shapes = {str(choice) for choice in keys_of(TrajectoryConfig)["shape"].choices}
    return tuple(names) if colon and set(names) <= shapes else ()


def _metric(score: Score) -> str:
    """What it is and its unit, which flight is better by it, what it is held to, and where it is computed."""
    bound = score.tolerance and score.tolerance.bound
    bound = f"`tolerances.{bound}`" if isinstance(bound, str) else f"{bound} {score.unit}".strip()
    told = (
        ", ".join(filter(None, (score.text(), score.unit))),
        f"{'smaller' if score.smaller_is_better else 'larger'} is better" if score.directed else "",
        f"held to {bound}" if score.tolerance else "",
        *(f'with `measures = ["{name}"]`' for name, keys in SETS.items() if score.name in keys),
    )
    return "; ".join(filter(None, told))
