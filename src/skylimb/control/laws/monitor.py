"""What the laws of one tick read of each other and give: each is held to what it declares.

A tick shows every field that a law reads, as laws that are compiled decide nothing by numbers. So a law
cannot read what it does not declare, or what nobody gives, without being named; and what a user's law does
not declare is known once it has been tried (`control.laws.trial`).
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from skylimb.base.errors import ConfigError
from skylimb.control.estimation.records import Signals
from skylimb.control.laws.fields import FIELDS, RECORDS, called, misfit, optional, provided, required
from skylimb.control.laws.slots import SLOTS, Slots
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import PACE, merged
from skylimb.control.records import LawInput

_WATCHED = (*RECORDS, "residual")


class LawMonitor:
    """Hands each law its inputs and takes down what it reads and gives.

    Args:
        slots: the laws and their gains.

    Attributes:
        reads: fields that each law has read, by its slot.
        gives: fields that each law has given, by its slot.
    """

    def __init__(self, slots: Slots) -> None:
        self._slots = slots
        self.reads: dict[str, set[str]] = {slot: set() for slot in SLOTS}
        self.gives: dict[str, frozenset[str]] = {}

    def inputs(self, slot: str, inputs: LawInput) -> LawInput:
        """The inputs as the law of a slot may read them."""
        law = getattr(self._slots, slot).law
        read = functools.partial(self._read, slot, required(law), optional(law))
        seen: dict[str, Any] = {name: _Seen(getattr(inputs, name), name, read) for name in RECORDS}
        if inputs.residual is not None or "residual" not in optional(law):
            seen["residual"] = _Seen(inputs.residual, "residual", read)
        return inputs._replace(reference=self._previewed(slot, inputs.reference), **seen)

    def _previewed(self, slot: str, reference: Reference) -> Reference:
        """The reference with what the law of a slot wants to see ahead, where anything is shown at all."""
        if not reference.ahead:
            return reference
        times = merged(one.needs for one in self._slots).preview
        ahead = dict(zip(times, reference.ahead, strict=True))
        wanted = getattr(self._slots, slot).needs.preview
        return reference._replace(ahead=tuple(ahead[time] for time in wanted))

    def gave(self, slot: str, record: Any) -> None:
        """Take down what a law gives; a `ConfigError` where it is not as declared, or no record at all."""
        name, kind = next((name, kind) for name, (giver, kind) in RECORDS.items() if giver == slot)
        if not isinstance(record, kind):
            raise ConfigError(
                f"{called(self._slots, slot)} gives {type(record).__name__}, a {kind.__name__} is needed"
            )
        self._keep(
            slot, (f"{name}.{field}" for field, value in record._asdict().items() if value is not None)
        )

    def residual(self, state: Any) -> Any:
        """What the rotors fell short of, as the allocation law's state says it; absent where it does not."""
        missing = getattr(state, "residual", None)
        self._keep("allocation", [] if missing is None else ["residual"])
        return missing

    def recorded(self, slot: str, signals: Signals, known: Signals) -> None:
        """Raise a `ConfigError` where a law has a name twice, or a signal "pace" and no needs that say so."""
        for name in signals.keys() & known.keys():
            raise ConfigError(
                f"{called(self._slots, slot)} records '{name}', which another part of the controller "
                "records; choose another name"
            )
        paced = getattr(self._slots, slot).needs.paced
        if paced != (PACE in signals):
            lacks = f"has no signal '{PACE}'" if paced else "its needs do not say paced=True"
            sets = "sets the mission's pace" if paced else f"has a signal '{PACE}'"
            raise ConfigError(f"{called(self._slots, slot)} {sets}, but {lacks}")

    def _keep(self, slot: str, given: Any) -> None:
        given = self.gives[slot] = frozenset(given)
        declared = provided(slot, getattr(self._slots, slot).law)
        wrong = sorted(given ^ (given if declared is None else declared))
        if wrong:
            what = "gives" if wrong[0] in given else "does not give"
            other = "does not name" if wrong[0] in given else "names"
            raise ConfigError(f"{called(self._slots, slot)} {what} {wrong[0]}, which its PROVIDES {other}")

    def _read(self, slot: str, declared: frozenset[str] | None, may_lack: Any, field: str, value: Any) -> Any:
        self.reads[slot].add(field)
        if field in may_lack:
            return value
        if declared is not None and field not in declared:
            raise ConfigError(
                f"{called(self._slots, slot)} reads {field}, which its REQUIRES and OPTIONAL do not name"
            )
        if value is None:
            lacks = misfit(self._slots, slot, FIELDS[field], [field])
            raise ConfigError(f"{lacks}; a law that can do without it names it in OPTIONAL")
        return value


def unmonitored(given: tuple[Any, ...]) -> tuple[Any, ...]:
    """Arguments of a law whose inputs are the records themselves."""
    return tuple(
        one._replace(**{name: _bare(getattr(one, name)) for name in _WATCHED})
        if isinstance(one, LawInput)
        else one
        for one in given
    )


def monitored_like(given: tuple[Any, ...], records: tuple[Any, ...]) -> tuple[Any, ...]:
    """Other arguments of a law, whose reading is taken down as that of the given ones is."""
    return tuple(
        record._replace(**{name: _over(getattr(one, name), getattr(record, name)) for name in _WATCHED})
        if isinstance(one, LawInput)
        else record
        for one, record in zip(given, records, strict=True)
    )


class _Seen:
    """A record as one law sees it: `read` gets the name of each field and returns its value.

    Where there is no record it is false, for laws that ask `inputs.residual or ...`.
    """

    def __init__(self, record: Any, name: str, read: Callable[[str, Any], Any]) -> None:
        self._record, self._name, self._read = record, name, read

    def __bool__(self) -> bool:
        return self._record is not None

    def __getattr__(self, field: str) -> Any:
        value = None if self._record is None else getattr(self._record, field)
        whole = self._name if self._name in FIELDS else f"{self._name}.{field}"
        return self._read(whole, value) if whole in FIELDS else value


def _bare(record: Any) -> Any:
    return record._record if isinstance(record, _Seen) else record


def _over(seen: Any, record: Any) -> Any:
    return _Seen(record, seen._name, seen._read) if isinstance(seen, _Seen) else record
