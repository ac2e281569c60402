"""Which fields of the records between slots a law gives and needs, and whether the laws of a cascade fit.

A law's file names a field as its inputs do, "contact.tip" for `inputs.contact.tip`:

- `PROVIDES`: fields of its own record that it fills in; the others are absent, None.
- `REQUIRES`: fields of other laws' records that it reads.
- `OPTIONAL`: fields that it reads where they are given, and that are None elsewhere, each with the gain that
  needs the field unless it is 0, or "" where none does.

A law in a user's file may leave `PROVIDES` and `REQUIRES` out: one traced tick shows them
(`control.laws.monitor`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys import keys_of
from skylimb.base.keys.key import shown
from skylimb.control.estimation.records import Estimate
from skylimb.control.laws.slots import SLOTS, Slot, Slots, find_law, law_names
from skylimb.control.records import ArmTarget, ContactView

RECORDS = {
    "estimate": ("estimation", Estimate),
    "contact": ("contact", ContactView),
    "arm": ("shape", ArmTarget),
}
"""Records between slots by their name in a `LawInput`: the slot whose law makes each, and its type."""

FIELDS = {
    **{f"{name}.{field}": slot for name, (slot, kind) in RECORDS.items() for field in kind._fields},
    "residual": "allocation",
}
"""Every field by its whole name, and the slot whose law gives it."""


def provided(slot: str, law: Any) -> frozenset[str] | None:
    """Fields that a law declares to give; None where it declares nothing."""
    given = [field for field, giver in FIELDS.items() if giver == slot]
    return _known("PROVIDES", law, law.PROVIDES, given) if hasattr(law, "PROVIDES") else None


def required(law: Any) -> frozenset[str] | None:
    """Fields that a law declares to read whatever its gains; None where it declares nothing."""
    return _known("REQUIRES", law, law.REQUIRES, FIELDS) if hasattr(law, "REQUIRES") else None


def optional(law: Any) -> Mapping[str, str]:
    """Fields that a law reads where they are given, each with the gain that needs it, or ""."""
    found: Mapping[str, str] = getattr(law, "OPTIONAL", {})
    _known("OPTIONAL", law, found, FIELDS)
    _known("OPTIONAL", law, filter(None, found.values()), keys_of(law.Gains) if found else ())
    return found


def needed(slot: str, filled: Slot) -> dict[str, str]:
    """Fields that a law declares to need with its gains, each with the gain that is the reason, or ""."""
    fields = dict.fromkeys(required(filled.law) or (), "")
    for field, gain in optional(filled.law).items():
        if gain and np.any(value := attrgetter(gain)(filled.gains)):
            fields[field] = f" ({slot}.{gain} = {shown(value)})"
    return fields


def described(slot: str, law: Any) -> str:
    """What a law declares, in a line; empty where it declares nothing."""
    declared = {
        "Needs": required(law),
        "Reads where given": optional(law),
        "Gives": provided(slot, law),
    }
    listed = {what: [field for field in FIELDS if field in (names or ())] for what, names in declared.items()}
    return " ".join(f"{what} {', '.join(fields)}." for what, fields in listed.items() if fields)


def require_fit(slots: Slots, where: str) -> None:
    """Raise a `ConfigError` that begins with `where` unless every law is given what it needs.

    What a user's law gives may not be known before a tick is traced; until then it counts as enough.
    """
    for slot, filled in zip(SLOTS, slots, strict=True):
        missing: dict[str, list[str]] = {}
        for field, why in needed(slot, filled).items():
            giver = FIELDS[field]
            other = getattr(slots, giver)
            given = provided(giver, other.law) if other.gives is None else other.gives
            if is_late(slot, giver) or (given is not None and field not in given):
                missing.setdefault(giver, []).append(field + why)
        for giver, fields in missing.items():
            raise ConfigError(f"{where}: {misfit(slots, slot, giver, fields)}")


def is_late(slot: str, giver: str) -> bool:
    """Whether what the law of `giver` gives comes too late for `slot`; a residual is the last tick's."""
    return giver != "allocation" and SLOTS.index(giver) >= SLOTS.index(slot)


def misfit(slots: Slots, slot: str, giver: str, fields: Collection[str]) -> str:
    """Which law lacks which fields of which other one, and which laws that ship would give them.

    Args:
        slots: the laws.
        slot: of the law that needs them.
        giver: slot of the law that should give them.
        fields: with the reason behind each name.
    """
    lacks = f"{called(slots, slot)} needs {', '.join(sorted(fields))}, which {called(slots, giver)}"
    if is_late(slot, giver):
        return f"{lacks} gives only after it"
    names = {field.partition(" ")[0] for field in fields}
    laws = {name: provided(giver, find_law(giver, name, Path())) or () for name in law_names(giver)}
    fit = [name for name, given in laws.items() if names.issubset(given)]
    shipped = f"{giver} laws that do: {', '.join(fit)}" if fit else f"no {giver} law that ships does"
    return f"{lacks} does not give ({shipped})"


def called(slots: Slots, slot: str) -> str:
    """The law of a slot in a message: "contact law 'open'"."""
    return f"{slot} law '{getattr(slots, slot).name}'"


def _known(table: str, law: Any, names: Iterable[str], known: Iterable[str]) -> frozenset[str]:
    """The names of a declaration; an `UnknownNameError` for one that is none."""
    where = f"{table} of {getattr(law, 'what', '') or getattr(law, '__name__', 'a law')}"
    if isinstance(names, str):
        raise ConfigError(f"{where} should be a tuple of names, as in ('{names}',)")
    names, known = frozenset(names), list(known)
    for name in sorted(names.difference(known)):
        raise unknown_name(f"name in {where}:", name, known)
    return names
