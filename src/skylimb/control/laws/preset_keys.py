"""The keys of a preset: the law of every slot and its gains, each with unit, range and meaning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal

from skylimb.base.errors import unknown_name
from skylimb.base.keys import Key, KeyInfo, Table, rows_of, summary, tables_of
from skylimb.control.laws.fields import described, require_fit
from skylimb.control.laws.preset import IMU, ROBOTS, Preset
from skylimb.control.laws.slots import SLOTS, Slot, law_names

_LAW = Key("", "the law that fills the slot: one of these, or a Python file of your own")

_OUTSIDE_TABLES = {
    "name": KeyInfo(Key("", "short name"), str, ""),
    "description": KeyInfo(Key("", "one line on what it is"), str, ""),
}
"""Keys outside of the tables."""


_CASES = {
    ROBOTS: KeyInfo(Key("", "differs for a robot, by its name or kind (tilting, pushing, chain)"), dict, {}),
    IMU: KeyInfo(Key("", "what is different with estimation.smoothing.imu = true"), dict, {}),
}


def preset_tables(preset: Preset, mapping: Mapping[str, Any] | None = None) -> Iterator[Table]:
    """The tables of a preset as a TOML file has them, with every key that may be set.

    Args:
        preset: whose.
        mapping: its file's tables, which may say what is different for a robot, or with an IMU.
    """
    yield Table((), "", tuple((name, getattr(preset, name), info) for name, info in _OUTSIDE_TABLES.items()))
    for slot, filled in zip(SLOTS, preset.slots, strict=True):
        yield from _slot_tables(slot, filled)
    for name, info in _CASES.items():
        if mapping and name in mapping:
            yield Table((), "", ((name, dict(mapping[name]), info),))


def with_gains(preset: Preset, changes: Mapping[str, Any], where: str) -> Preset:
    """A preset with other values of some gains, by dotted key; the laws stay.

    Raises:
        ConfigError: beginning with `where`, naming the gain that is unknown or cannot have its value, or the
            field that it needs.
    """
    for key, value in changes.items():
        slot, _, rest = key.partition(".")
        if slot not in SLOTS or not rest or rest == "law":
            raise unknown_name(
                f"gain of {where}", key, [name for name, _, _ in rows_of(preset_tables(preset))]
            )
        preset = preset.with_gain(key, value, where)
    require_fit(preset.slots, where)
    return preset


def law_tables(slot: str, name: str, law: Any) -> Iterator[Table]:
    """The tables of a law in its slot, with the defaults of its gains."""
    return _slot_tables(slot, Slot(name, law, law.Gains))


def _slot_tables(slot: str, filled: Slot) -> Iterator[Table]:
    first, *inside = tables_of(filled.gains, (slot,))
    info = KeyInfo(_LAW, Literal[law_names(slot)], filled.name)
    meaning = " ".join(filter(None, (summary(filled.law), described(slot, filled.law))))
    yield Table(first.path, meaning, (("law", filled.name, info), *first.rows))
    yield from inside
