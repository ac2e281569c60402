"""Every gain and every key of an experiment as a control of a page, made from what is declared of it."""

from __future__ import annotations

import math
import typing
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.apps.studio.surface_edits import surface_keys_in_flight
from skylimb.base.keys import KeyInfo, rows_of, tables_of
from skylimb.base.keys.fields import has_numbers, members_of
from skylimb.base.packing import Layout
from skylimb.control.controller import is_configurable, is_traceable
from skylimb.robots.loader import list_robots

IN_FLIGHT, RESTART = "in flight", "restart"
"""When a control acts: at once, or by a new take-off."""

PREFIX = "controller."
"""What the keys of gains begin with."""

_GROUPS = {
    "controller.contact": "Contact and force",
    "controller.translation": "Motion in space",
    "controller.attitude": "Attitude",
    "controller.shape": "Arm",
    "controller.allocation": "Thrusts and rotor angles",
    "controller.estimation": "What the controller estimates",
    "trajectory": "The path",
    "surface": "The surface",
    "approach": "Going to the surface",
    "phases": "How long each phase takes",
    "posture": "The arm's posture",
    "sensors": "Sensors",
    "plant": "The simulated robot",
    "excitation": "Excitation",
    "supervisor": "Supervisor",
    "terminations": "When a flight is lost",
    "tolerances": "What counts as done",
}
"""What tables of keys are called, in the order in which a page has them; all others are named last."""
_OTHERS = "The experiment"

_LEFT_OUT = ("events", "recorded", "controller")
_NOT_TO_TURN = ("name", "description", "stop_at")


def controls_of(flights: Sequence[LiveFlight]) -> list[dict[str, Any]]:
    """The controls of some flights of one experiment: its keys, then the gains of their controllers.

    Their values are those of take-off; `live_state` has what becomes of them.

    Returns:
        For each: `key`, `group` in words, `unit`, `meaning`, `low` and `high` (None without an end), `value`,
        `kind` (number, switch, choice, vector or text), `whole` (of a number), `choices`, `acts` (`IN_FLIGHT`
        or `RESTART`).
        Gains, whose keys begin with "controller.", also have `flights`, the numbers of those that have it,
        and `values`, one for each of them.
    """
    order = [*_GROUPS.values(), _OTHERS]
    found = [*_of_experiment(flights[0]), *_of_controllers(flights)]
    return sorted(found, key=lambda control: order.index(control["group"]))


def values_of(control: Mapping[str, Any]) -> list[tuple[int | None, Any]]:
    """The values of a control: of each flight that has such a gain, or one for all (None)."""
    if "flights" in control:
        return list(zip(control["flights"], control["values"], strict=True))
    return [(None, control["value"])] if control else []


def _of_experiment(flight: LiveFlight) -> Iterator[dict[str, Any]]:
    in_flight = surface_keys_in_flight(flight.experiment.surface)
    for key, value, info in rows_of(tables_of(flight.experiment)):
        if key.partition(".")[0] in _LEFT_OUT or key in _NOT_TO_TURN:
            continue
        if info.key.file and key != "robot":  # no file is read because a page says so
            continue
        choices = tuple(list_robots()) if key == "robot" else info.choices
        yield _control(key, value, info, IN_FLIGHT if key in in_flight else RESTART, choices)


def _of_controllers(flights: Sequence[LiveFlight]) -> Iterator[dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for number, flight in enumerate(flights):
        controller = flight.takeoff.controller
        if not is_configurable(controller):
            continue
        flown = Layout(controller.gains()).slices if is_traceable(controller) else {}
        for key, value, info in rows_of(controller.key_tables()):
            if key in _NOT_TO_TURN or info.key.file:
                continue
            acts = IN_FLIGHT if key in flown else RESTART
            new = {**_control(f"{PREFIX}{key}", value, info, acts), "flights": [], "values": []}
            control = found.setdefault(key, new)
            control["flights"].append(number)
            control["values"].append(new["value"])
            if acts == RESTART:
                control["acts"] = RESTART
    yield from found.values()


def _control(
    key: str, value: Any, info: KeyInfo, acts: str, choices: tuple[Any, ...] | None = None
) -> dict[str, Any]:
    choices = info.choices if choices is None else choices
    numbers = info.key if has_numbers(info.type) else None
    kind = _kind(info, value, choices)
    return {
        "key": key,
        "group": next(
            (title for table, title in _GROUPS.items() if f"{key}.".startswith(f"{table}.")), _OTHERS
        ),
        "unit": info.unit,
        "meaning": info.meaning,
        "low": _end(numbers.low if numbers.low is not None else numbers.above) if numbers else None,
        "high": _end(numbers.high if numbers.high is not None else numbers.below) if numbers else None,
        "value": _plain(value),
        "kind": kind,
        "whole": kind == "number" and isinstance(value, int),
        "choices": list(choices),
        "acts": acts,
    }


def _kind(info: KeyInfo, value: Any, choices: tuple[Any, ...]) -> str:
    kinds = [typing.get_origin(kind) or kind for kind in members_of(info.type)]
    if choices:
        return "choice"
    if bool in kinds:
        return "switch"
    if isinstance(value, tuple | list) or (tuple in kinds and not {float, int} & set(kinds)):
        return "vector"
    return "number" if {float, int} & set(kinds) else "text"


def _end(end: float | None) -> float | None:
    return None if end is None or math.isinf(end) else float(end)


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return [_plain(one) for one in value]
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
