"""Laws in plain Python inside of a compiled cascade.

Where such a law stands, the trace has symbols for what it makes (`base.split_function`). Its state is part of
the controller's flat state like any other, so a flight with it can be saved, rewound and flown again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.errors import UserCodeError
from skylimb.base.packing import Layout, is_numeric
from skylimb.base.split_function import Asked
from skylimb.base.user_code import returned
from skylimb.control.laws.monitor import unmonitored
from skylimb.control.laws.results import PARTS, called
from skylimb.control.laws.slots import Slot
from skylimb.control.laws.user_functions import Prepared, UserLaw
from skylimb.robots.model import Robot


class PythonFunction(NamedTuple):
    """A function of a law that cannot be compiled.

    Attributes:
        given: its arguments.
        made: what it returns.
        why: it cannot be compiled, in a sentence.
    """

    given: Layout[Any]
    made: Layout[Any]
    why: str


class OpenLaw:
    """A law that is traced: where a function of it flies in Python, symbols stand for what it makes.

    Args:
        filled: slot with the law.
        robot: the controller's.
        asked: gets what is asked of Python.
    """

    def __init__(self, filled: Slot, robot: Robot, asked: list[Asked]) -> None:
        self._filled, self._robot, self._asked = filled, robot, asked

    def __getattr__(self, name: str) -> Any:
        """What the law has."""
        known = self._filled.python.get(name)
        return getattr(self._filled.law, name) if known is None else partial(self._ask, name, known)

    def _ask(self, name: str, function: PythonFunction, *given: Any) -> Any:
        made = ca.SX.sym(name, function.made.size)
        flat = ca.SX(function.given.pack(unmonitored(given)))
        law = self._filled.law
        bind = partial(_bound, law, self._robot, name, function)
        self._asked.append(Asked(flat, made, bind, f"{law.what}: {name}"))
        return function.made.unpack(made)


def _bound(
    law: UserLaw, robot: Robot, name: str, function: PythonFunction, given: np.ndarray, made: np.ndarray
) -> Callable[[], None]:
    """Runs a law's function on flat arrays."""
    read, write, call = function.given.reader(given), function.made.writer(made), law.plain[name]
    first, output = read()[0], _output(name, function.made)
    if isinstance(first, Prepared) and not is_numeric(first.made):
        call = _preparing(law, robot, call, given[: Layout(first.gains).size])

    def told() -> str:
        """The function, with the line that returned what it did."""
        _, place = returned(call, *read())
        return f"{law.what}{f' in {place}' if place else ''}: {name}"

    def run() -> None:
        result = call(*read())
        try:
            write(result)
        except ValueError as error:
            said = PARTS.get(str(error)[0], str(error)[0]) + str(error)[1:]
            raise UserCodeError(f"{told()} returns other things than at load: {said}") from error
        for part, words in output:
            if not np.isfinite(made[part]).all():
                numbers = made[part].tolist()
                got = numbers[0] if len(numbers) == 1 else numbers
                raise UserCodeError(f"{told()} returns {words}: {got}, expected finite numbers")

    return run


def _output(name: str, made: Layout[Any]) -> list[tuple[slice, str]]:
    """Where the output stands among what a function of a law makes, each part in words; a state is none."""
    if name == "aim":
        return [(slice(0, made.size), "a force")]
    return [(part, called(key)) for key, part in made.slices.items() if name == "step" and key[:1] == "1"]


def _preparing(law: Any, robot: Robot, call: Callable[..., Any], gains: np.ndarray) -> Callable[..., Any]:
    """A function of a law that prepares an object of its own: anew whenever its flat gains have changed."""
    known: bytes | None = None
    made: Any = None

    def run(first: Prepared, *given: Any) -> Any:
        nonlocal known, made
        if (now := gains.tobytes()) != known:
            known, made = now, law.prepare(first.gains, robot)
        return call(Prepared(first.gains, made), *given)

    return run
