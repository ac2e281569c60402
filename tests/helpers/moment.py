"""What an object is like at a moment, to be brought back: the flight to it is flown once for many tests.

It is brought back in place: compiled functions read and write the memory of arrays that they were bound to.
"""

from __future__ import annotations

import copy
import dataclasses
import functools
from collections import deque
from collections.abc import Callable, Iterator
from enum import Enum
from functools import partial
from operator import attrgetter, itemgetter
from pathlib import PurePath
from types import CellType, FunctionType, MappingProxyType, MethodType, ModuleType
from typing import Any, TypeVar

import casadi as ca
import mujoco
import numpy as np

from skylimb.base.bound_function import BoundFunction

_STAYS = (
    bool, int, float, complex, str, bytes, range, slice, type, type(None), type(len), Enum, ModuleType,
    np.generic, ca.Function, ca.SX, ca.MX, ca.DM, attrgetter, itemgetter, MappingProxyType, PurePath,
)  # fmt: skip
"""What nobody can change, or nobody does."""


Held = TypeVar("Held")


@functools.cache
def _known(make: Callable[..., Any], *given: Any) -> tuple[Any, Moment]:
    made = make(*given)
    return made, Moment(made)


def again(make: Callable[..., Held], *given: Any) -> Held:
    """What `make` makes of what is given, made once: what was done with it since is undone."""
    made, moment = _known(make, *given)
    moment.bring_back()
    return made


class Moment:
    """All that an object holds, as it is now.

    Args:
        held: the object.

    Raises:
        TypeError: for something in it that could change without being brought back.
    """

    def __init__(self, held: Any) -> None:
        self._known: dict[int, Any] = {}
        self._ways = list[Callable[[], object]]()
        waiting = [held]
        while waiting:
            one = waiting.pop()
            if isinstance(one, _STAYS) or id(one) in self._known:
                continue
            self._known[id(one)] = one
            waiting += self._kept(one)

    def bring_back(self) -> None:
        """As it was then."""
        for way in self._ways:
            way()

    def _kept(self, one: Any) -> Iterator[Any]:
        """Know the way back of one object; what it holds."""
        match one:
            case np.ndarray():
                if one.dtype != object and one.flags.writeable:
                    self._ways.append(partial(np.copyto, one, one.copy()))
                elif one.dtype == object:
                    yield from one.ravel().tolist()
            case mujoco.MjData():
                yield one.model
                self._ways.append(partial(mujoco.mj_copyData, one, one.model, copy.copy(one)))
            case mujoco.MjModel():
                arrays = (getattr(one, name) for name in dir(one) if not name.startswith("_"))
                yield from (array for array in arrays if isinstance(array, np.ndarray))
            case list() | deque() | set():
                add = one.update if isinstance(one, set) else one.extend
                self._ways += [one.clear, partial(add, list(one))]
                yield from one
            case dict():
                self._ways += [one.clear, partial(one.update, dict(one))]
                yield from one.values()
            case tuple() | frozenset():
                yield from one
            case MethodType():
                yield one.__self__
            case FunctionType():
                yield from one.__closure__ or ()
            case CellType():
                self._ways.append(partial(setattr, one, "cell_contents", one.cell_contents))
                yield one.cell_contents
            case partial():
                yield from (one.func, one.args, one.keywords)
            case BoundFunction():  # the arrays are others'
                yield one._arrays
            case _ if hasattr(one, "__dict__"):
                yield vars(one)
            case _ if dataclasses.is_dataclass(one):
                yield from (getattr(one, field.name) for field in dataclasses.fields(one))
            case _:
                raise TypeError(f"{type(one)} cannot be brought back")
