"""What a TOML file describes, by its keys: a controller, an experiment, a robot or a campaign."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Literal

from skylimb.base.errors import ConfigError
from skylimb.control.laws.slots import SLOTS
from skylimb.control.missions.configuration import MissionConfig

Kind = Literal["", "campaign", "controller", "experiment", "robot"]

_EXPERIMENT = {"surface", "events", *(field.name for field in fields(MissionConfig))}
"""Tables that an experiment has, and nothing else."""

_TAKEN = {
    "campaign": "`skylimb campaign {file}` takes it",
    "controller": "it goes behind --controller",
    "experiment": "`skylimb run {file}` takes it",
    "robot": "an experiment's key robot takes it",
}
"""What takes a file of each kind."""


def kind_of_tables(tables: Mapping[str, Any]) -> Kind:
    """The kind of a file by its tables; empty where they do not say, as those of a file without a table."""
    keys = set(tables)
    if "urdf" in keys:
        return "robot"
    if "controllers" in keys:
        return "campaign"
    if "file" in keys or (keys & set(SLOTS) and not keys & _EXPERIMENT):
        return "controller"
    return "experiment" if keys & _EXPERIMENT and not keys & set(SLOTS) else ""


def require_kind(tables: Mapping[str, Any], file: str, wanted: Kind) -> None:
    """Raise a `ConfigError` for a file that is of another kind than the one that is wanted."""
    kind = kind_of_tables(tables)
    if kind not in ("", wanted):
        takes = _TAKEN[kind].format(file=file)
        raise ConfigError(f"'{file}' is the file of {_an(kind)}, and not of {_an(wanted)}: {takes}")


def _an(kind: str) -> str:
    return f"an {kind}" if kind == "experiment" else f"a {kind}"
