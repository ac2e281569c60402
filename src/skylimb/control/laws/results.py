"""What laws and controllers have to return, and the one line that says where they do not."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.base.errors import UserCodeError
from skylimb.base.packing import Layout, with_floats
from skylimb.base.signals import Signal, require_free, require_recorded
from skylimb.control.estimation.records import BodyState, Estimate, Wrench
from skylimb.control.records import Allocated, ArmTarget, Command, ContactView, TipMove
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState

PARTS = {"0": "state", "1": "output", "2": "signals"}
"""What the three things are that a step returns."""

_Z3 = np.zeros(3)
_WRENCH = Wrench(_Z3, _Z3)
_BODY = BodyState(_Z3, _Z3, np.zeros((3, 3)), _Z3, None)  # type: ignore[arg-type]
_MOVE = TipMove(_Z3, _Z3, _Z3, _Z3)
_OUTPUTS: Mapping[str, tuple[str, Any]] = {
    "estimation": ("an Estimate", Estimate(_BODY, _WRENCH, _WRENCH, 0.0, _Z3, _WRENCH)),
    "contact": (
        "a ContactView",
        ContactView._make([0.0] * len(ContactView._fields))._replace(across=_Z3, tip=_MOVE),
    ),
    "shape": ("an ArmTarget", ArmTarget(0.0, 0.0)),
    "translation": ("a force (3,)", _Z3),
    "attitude": ("a torque (3,)", _Z3),
    "allocation": ("an Allocated", Allocated(Command(_Z3, _Z3, _Z3), _WRENCH)),
    "controller": ("a Command", Command(_Z3, _Z3, _Z3)),
}
"""What a step makes, by its slot or of a whole controller, in words and as a record of the right shapes."""


def checked(
    result: Any, slot: str, name: str, what: str, state: Any, robot: Robot, signals: Mapping[str, Signal]
) -> tuple[Layout[Any], np.ndarray]:
    """Where what a function of a law returns stands in a flat vector, and that vector.

    Args:
        result: of a call on numbers.
        slot: that the law fills, or "controller".
        name: of the function.
        what: the function in a message.
        state: before the first tick.
        robot: the controller's.
        signals: that the law declares.

    Raises:
        UserCodeError: saying what was got and what was expected.
        UnknownNameError: where a signal is declared and not recorded.
    """
    words, output = _OUTPUTS[slot]
    if name == "commanded":
        return _fitting(result, state, f"{what}: state", "")
    if name == "aim":
        return _fitting(with_floats(result), _Z3, f"{what} returns", "a force: ")
    if not isinstance(result, tuple | list) or len(result) != 3 or hasattr(result, "_fields"):
        raise UserCodeError(
            f"{what} returns {_shown(result)}, expected three things: state, {words}, signals"
        )
    new, made, recorded = result[0], with_floats(result[1]), with_floats(result[2])
    if isinstance(output, tuple) and not isinstance(made, type(output)):
        raise UserCodeError(f"{what} returns {_shown(made)} as its output, expected {words}")
    if not isinstance(recorded, dict) or not all(isinstance(key, str) for key in recorded):
        raise UserCodeError(
            f"{what} returns {_shown(recorded)} as its signals, expected a table of numbers by name"
        )
    require_recorded(signals, recorded, what.rpartition(": ")[0])
    require_free(recorded, what)
    _fitting(new, state, f"{what}: state", "as initial_state: ")
    template = _template(slot, output, made, robot)
    _fitting(made, template, f"{what}: output", f"{words}: ")
    shapes = {key: np.zeros(np.shape(value)) if np.shape(value) else 0.0 for key, value in recorded.items()}
    _fitting(recorded, shapes, f"{what}: signals", "")
    return _fitting((new, made, recorded), (state, template, shapes), f"{what} returns", "")


def _template(slot: str, output: Any, made: Any, robot: Robot) -> Any:
    """The output that is expected, without what the law does not fill in."""
    if slot in ("allocation", "controller"):
        command = Command(*map(np.zeros, (robot.n_rotors, robot.n_joints, robot.n_vectoring)))
        return command if slot == "controller" else output._replace(command=command)
    if slot in ("translation", "attitude"):
        return output
    absent: dict[str, Any] = {name: None for name, value in made._asdict().items() if value is None}
    if slot == "estimation" and isinstance(getattr(made.body, "model", None), RobotState):
        absent["body"] = _BODY._replace(model=made.body.model)
    return output._replace(**absent)


def _fitting(record: Any, template: Any, what: str, expected: str) -> tuple[Layout[Any], np.ndarray]:
    """The record flat; an error where it is not like the template, or not finite."""
    layout, what = Layout(template), f"{what}:"
    flat = np.zeros(layout.size)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", np.exceptions.ComplexWarning)
            layout.writer(flat)(record)
    except ValueError as error:
        raise UserCodeError(f"{what} {str(error).replace('expected ', f'expected {expected}', 1)}") from None
    except np.exceptions.ComplexWarning:
        raise UserCodeError(f"{what} got complex numbers, expected {expected}real ones") from None
    for name, part in layout.slices.items():
        if not np.isfinite(flat[part]).all():
            numbers = flat[part].tolist()
            raise UserCodeError(
                f"{what} {name}{name and ': '}got {numbers[0] if len(numbers) == 1 else numbers}, expected "
                "finite numbers in hover"
            )
    return layout, flat


def called(name: str) -> str:
    """An entry of what a step returns, in words: "signals pull"."""
    head, _, rest = name.partition(".")
    return " ".join(filter(None, (PARTS.get(head, head), rest)))


def _shown(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    kind = "nothing" if value is None else f"one {type(value).__name__}"
    return f"{len(value)} things" if type(value) is tuple else kind
