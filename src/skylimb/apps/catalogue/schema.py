"""JSON schemas of the TOML files that users write, for editors that complete and check."""

from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skylimb.base.config import to_mapping
from skylimb.base.keys import Key, summary
from skylimb.base.keys.fields import default_of, fields_of, members_of
from skylimb.control.laws.preset import DEFAULT_LAWS, IMU, ROBOTS
from skylimb.control.laws.slots import SLOTS, find_law, law_names
from skylimb.flight.events import EVENTS
from skylimb.flight.experiments.experiment import Experiment, Settings
from skylimb.robots.flight_file import FlightFile
from skylimb.simulation.surfaces import SURFACES
from skylimb.studies.campaign.spec import CampaignSpec

_DIALECT = "http://json-schema.org/draft-07/schema#"
_PLAIN = {str: "string", bool: "boolean", int: "integer", float: "number"}

Schema = dict[str, Any]


def _own(key: str) -> Schema:
    """A table whose `key` names a Python file of the user's own, with whatever other keys that file has."""
    file = {"type": "string", "pattern": r"\.py$", "description": "your own Python file"}
    return {"type": "object", "properties": {key: file}, "required": [key]}


_OWN = _own("law")


def schemas() -> dict[str, Schema]:
    """A schema by the name of its file."""
    return {
        "experiment.schema.json": _whole("An experiment", _experiment()),
        "controller.schema.json": _whole("A controller's preset", _controller()),
        "robot.schema.json": _whole("What a robot needs that URDF cannot say", _table(FlightFile)),
        "campaign.schema.json": _whole("A campaign, or a search of gains", _campaign()),
    }


def _whole(title: str, schema: Schema) -> Schema:
    return {"$schema": _DIALECT, "title": title, **schema}


def _experiment() -> Schema:
    schema = _table(Settings)
    own = fields_of(Experiment)
    for name in ("controller", "recorded"):
        note = own[name][1]
        schema["properties"][name] = {"type": "object", "description": note.meaning if note else ""}
    schema["properties"]["surface"] = {
        "description": "What is touched",
        "anyOf": [
            *(_chosen(_table(cls), "kind", name, name == "board") for name, cls in SURFACES.items()),
            _own("kind"),
        ],
    }
    kinds = [_chosen(_table(cls), "kind", name, False) for name, cls in EVENTS.items()]
    note = "What happens in flight"
    schema["properties"]["events"] = {"type": "array", "description": note, "items": {"anyOf": kinds}}
    return schema


def _controller() -> Schema:
    texts = {name: {"type": "string"} for name in ("name", "description")}
    laws = {slot: _laws(slot) for slot in SLOTS}
    slots = {slot: {"anyOf": [*known, _OWN]} for slot, known in laws.items()}
    needed = [slot for slot in SLOTS if slot not in DEFAULT_LAWS]
    changes = _object({slot: {"anyOf": [*_partial(known), _OWN]} for slot, known in laws.items()}, [])
    note = "What is different for a robot, by its name"
    robots = {"type": "object", "description": note, "additionalProperties": changes}
    return _object({**texts, **slots, ROBOTS: robots, IMU: changes}, needed)


def _partial(schema: Any) -> Any:
    """A schema of which any part may be left out, as in a table that changes another."""
    if isinstance(schema, list):
        return [_partial(each) for each in schema]
    if isinstance(schema, dict):
        return {key: [] if key == "required" else _partial(value) for key, value in schema.items()}
    return schema


def _laws(slot: str) -> list[Schema]:
    """The laws that a slot may be filled with, and their gains."""
    laws = []
    for law in law_names(slot):
        made = find_law(slot, law, Path())
        table = _table(made.Gains)
        table["description"] = summary(made)
        laws.append(_chosen(table, "law", law, DEFAULT_LAWS.get(slot) == law))
    return laws


def _campaign() -> Schema:
    schema = _table(CampaignSpec)
    for name in ("set", "vary"):  # dotted keys and nested tables are both welcome
        schema["properties"][name].pop("additionalProperties", None)
    return schema


def _chosen(table: Schema, key: str, name: str, usual: bool) -> Schema:
    """A table that is chosen by one of its keys; the usual one may leave the key out."""
    choice = {"const": name, "description": table["properties"].get(key, {}).get("description", "")}
    properties = {key: choice, **{k: v for k, v in table["properties"].items() if k != key}}
    required = [*([] if usual else [key]), *(k for k in table.get("required", ()) if k != key)]
    return {**table, "title": name, "properties": properties, "required": required}


def _object(properties: Mapping[str, Schema], required: list[str]) -> Schema:
    return {
        "type": "object",
        "properties": dict(properties),
        "required": required,
        "additionalProperties": False,
    }


def _table(cls: type) -> Schema:
    """A dataclass of keys."""
    properties, required = {}, []
    for field in dataclasses.fields(cls):
        if not field.init:
            continue
        kind, key = fields_of(cls)[field.name]
        properties[field.name] = _described(_of(kind, key or Key()), key, default_of(field))
        if default_of(field) is dataclasses.MISSING:
            required.append(field.name)
    return {**_object(properties, required), "description": summary(cls)}


def _described(schema: Schema, key: Key | None, default: Any) -> Schema:
    if key is not None and key.meaning:
        schema["description"] = f"{key.meaning} ({key.unit})" if key.unit else key.meaning
    plain = to_mapping(default) if default is not dataclasses.MISSING else None
    if isinstance(plain, str | bool | int | float | list) and not _infinite(plain):
        schema["default"] = plain
    return schema


def _infinite(value: Any) -> bool:
    return isinstance(value, float) and not math.isfinite(value)


def _of(kind: Any, key: Key) -> Schema:
    """The schema of a type; a range holds for each number in it."""
    members = [member for member in members_of(kind) if member is not type(None)]
    if len(members) > 1:
        return {"anyOf": [_of(member, key) for member in members]}
    (member,) = members
    if dataclasses.is_dataclass(member) and isinstance(member, type):
        return _table(member)
    if member in _PLAIN:
        return {"type": _PLAIN[member], **(_ends(key) if member in (int, float) else {})}
    return _container(typing.get_origin(member), typing.get_args(member), key)


def _container(origin: Any, arguments: tuple[Any, ...], key: Key) -> Schema:
    """The schema of a choice, a list or a table of entries; anything goes for other types."""
    if origin is typing.Literal:
        return {"enum": list(arguments)}
    if origin is tuple:
        count = {} if arguments[1:] == (...,) else {"minItems": len(arguments), "maxItems": len(arguments)}
        return {"type": "array", "items": _of(arguments[0], key), **count}
    if origin is dict:
        return {"type": "object", "additionalProperties": _of(arguments[1], key)}
    return {}


def _ends(key: Key) -> Schema:
    ends = {
        "minimum": key.low, "maximum": key.high, "exclusiveMinimum": key.above, "exclusiveMaximum": key.below,
    }  # fmt: skip
    return {name: end for name, end in ends.items() if end is not None and math.isfinite(end)}
