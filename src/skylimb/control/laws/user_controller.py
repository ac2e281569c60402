"""A user's controller as the package flies it: its gains are keys, and it is compiled where it can be."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import pickle
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MethodType
from typing import Any, TypeVar

import numpy as np

from skylimb.base.config import to_mapping, with_overrides
from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.base.keys import Table, tables_of
from skylimb.base.keys.settings import settings_class
from skylimb.base.packing import numeric, structure
from skylimb.base.signals import Signal, declared_signals
from skylimb.base.sources import Source
from skylimb.base.split_function import Asked
from skylimb.base.user_code import UserCode, described, guarded, returned
from skylimb.control.estimation.records import Measurement
from skylimb.control.laws.results import checked
from skylimb.control.laws.user_functions import traceable, with_floats_of
from skylimb.control.laws.user_trace import PERIOD, plain_attributes, shaken_hover, unrepeatable, untraceable
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import Needs, needs_of
from skylimb.control.records import Command
from skylimb.robots.model import Robot

NEEDED = ("name", "gains", "initial_state", "step")
"""What a user's object has to have."""

R = TypeVar("R")

_RESERVED = ("name", "description", "file")


@dataclass(frozen=True)
class Origin:
    """The file that a user's controller was made from.

    Attributes:
        file: its path, as the user named it.
        make: its function `controller(robot)`; the same as long as no file that was read for it has changed.
        sources: every file that was read for it.
    """

    file: str
    make: Callable[[Robot], Any]
    sources: tuple[Source, ...]

    def made(self, robot: Robot) -> Any:
        """A controller that nothing has flown yet."""
        with UserCode(f"controller(robot) of '{Path(self.file).name}'"):
            return self.make(robot)


class UserController:
    """A user's controller; it flies in Python.

    Args:
        made: the user's object: `name`, `gains()`, `initial_state()` and `step(...)`.
        robot: the model that it believes in.
        origin: where it was made; None for an object at hand.
        gains: a dataclass in place of what `made.gains()` returns.

    Attributes:
        what: what it is called in messages.
    """

    def __init__(self, made: Any, robot: Robot, origin: Origin | None = None, gains: Any = None) -> None:
        self.made, self.robot, self.origin = made, robot, origin
        self.what = f"controller '{self.name}'"
        self._before = {} if origin else plain_attributes(made)
        with UserCode(self.what):
            given = made.gains() if gains is None else gains
        self._settings = given if dataclasses.is_dataclass(given) and not isinstance(given, type) else None
        if self._settings is None:
            self._gains = given
            return
        settings_class(type(self._settings), "gains()", self.what)
        for field in dataclasses.fields(self._settings):
            if field.name in _RESERVED:
                raise ConfigError(f"{self.what}: a gain cannot be called '{field.name}'; choose another name")
        self._gains = numeric(self._settings)

    @property
    def name(self) -> str:
        """The user's own name for it."""
        return str(self.made.name)

    @property
    def needs(self) -> Needs:
        """What it needs of the loop."""
        return needs_of(self.made)

    @property
    def signals(self) -> Mapping[str, Signal]:
        """Unit, frame and meaning of the signals that it declares as `SIGNALS`."""
        return declared_signals(self.made, self.what)

    @property
    def source(self) -> Path | None:
        """The file that it was made from; None for an object at hand."""
        return Path(self.origin.file) if self.origin else None

    @property
    def sources(self) -> tuple[Source, ...]:
        """Every file that was read for it."""
        return self.origin.sources if self.origin else ()

    def gains(self) -> Any:
        """The gains as arrays; whatever the user's `gains` returns where that is no dataclass."""
        return self._gains

    def initial_state(self) -> Any:
        """The state before the first tick."""
        with UserCode(self.what):
            return self.made.initial_state()

    def step(
        self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[Any, Command, Mapping[str, Any]]:
        """The user's own step; it cannot write into what it is given, with which flight and record go on."""
        return self.made.step(gains, state, _to_read(measurement), _to_read(reference), dt)

    def try_step(self) -> None:
        """One step on numbers of a robot in hover, of an object that nothing has flown yet.

        Raises:
            UserCodeError: where it fails, or returns what the loop cannot take.
        """
        try:
            made = self._remade()
        except UserCodeError:
            raise
        except Exception:  # what cannot be copied is not tried: its step may change it
            return
        state = guarded(made.initial_state, self.what)()
        hover = shaken_hover(self.robot, np.random.default_rng(0), self.needs)
        with np.errstate(all="ignore"):  # what is not finite is named
            result, place = returned(
                guarded(made.step, self.what), self._gains, state, *map(_to_read, hover), PERIOD
            )
        what = f"{self.what}{f' in {place}' if place else ''}: step"
        if isinstance(result, tuple | list) and len(result) == 3 and not hasattr(result, "_fields"):
            result = (), *result[1:]  # its state may be anything
        checked(result, "controller", "step", what, (), self.robot, self.signals)

    def with_gains(self, changes: Mapping[str, Any]) -> UserController:
        """The same with other values of some gains, by dotted key.

        Raises:
            ConfigError: when its gains are no dataclass, or cannot have these values.
        """
        if not changes:
            return self
        changed = self._changed(changes, self.what)
        return user_controller(self._remade(), self.robot, self.origin, changed)

    def check_gain(self, key: str, value: Any, where: str, dt: float) -> None:
        """Raise a `ConfigError` that begins with `where` unless the gain of this key may have this value.

        Its own `require` knows the control period `dt` (s), and nothing of gains.
        """
        self._changed({key: value}, where)

    def key_tables(self) -> Iterator[Table]:
        """Every gain with value, unit, range and meaning; none where they are no dataclass."""
        return iter(()) if self._settings is None else tables_of(self._settings)

    def tables(self) -> dict[str, Any]:
        """Name, file and gains as plain tables."""
        file = {"file": self.origin.file} if self.origin else {}
        gains = {} if self._settings is None else to_mapping(self._settings)
        return {"name": self.name, **file, **gains}

    @cached_property
    def untraceable(self) -> str:
        """Why it cannot be compiled, in a sentence; empty where it can."""
        return untraceable(self._trial)

    @property
    def changed(self) -> str:
        """The first attribute of an object at hand that its flight has changed; empty where none."""
        now = {} if self.origin else plain_attributes(self.made)
        return next((name for name in sorted(now) if now[name] != self._before.get(name)), "")

    @cached_property
    def unrepeatable(self) -> str:
        """Why a flight with it cannot be repeated from its file, in a sentence; empty where it can."""
        if self.origin is None:
            return ""
        try:
            odd = unrepeatable(self._remade, self.needs, self._gains, self.robot)
        except Exception as error:  # whatever it is, the flight that is over has not met it
            return f"{self.what} fails when it is made anew: {described(error)}"
        if not odd:
            return ""
        return (
            f"{self.what} gives other {odd} when it is made anew: it draws random numbers without a seed, or "
            "remembers something in a global of its file; what it remembers belongs into its state, or into "
            "the object that controller(robot) makes"
        )

    def _trial(self) -> CompiledUserController:
        """The same as if it could be compiled, of an object that nothing has flown yet."""
        trial = CompiledUserController(self._remade(), self.robot, self.origin, self._settings)
        trial.what = "on symbols it"
        return trial

    def _remade(self) -> Any:
        return self.origin.made(self.robot) if self.origin else _copied(self.made)

    def _changed(self, changes: Mapping[str, Any], where: str) -> Any:
        if self._settings is None:
            raise ConfigError(
                f"{where}: gains can be set where `gains()` returns a frozen dataclass; here it returns "
                f"{type(self._gains).__name__}"
            )
        return with_overrides(self._settings, changes, where)


class CompiledUserController(UserController):
    """A user's controller whose step runs on symbols: it is compiled like the controllers that ship."""

    def initial_state(self) -> Any:
        """The state before the first tick, as arrays."""
        return numeric(super().initial_state())

    def step(
        self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[Any, Command, Mapping[str, Any]]:
        """The user's own step, on numbers or symbols."""
        step = with_floats_of(traceable(self.made.step, self.what))
        return step(gains, state, measurement, reference, dt)

    def opened(self) -> tuple[CompiledUserController, list[Asked]]:
        """The same to be traced; it asks nothing of Python."""
        return self, []

    @property
    def in_python(self) -> dict[str, str]:
        """Nothing: the whole of it is compiled."""
        return {}

    def settled(self, gains: Any) -> Any:
        """The gains themselves: nothing is computed of them."""
        return gains

    def require(self, dt: float) -> None:
        """Raise a `ConfigError` where the user's own `require(dt)` does."""
        if hasattr(self.made, "require"):
            with UserCode(self.what):
                self.made.require(dt)

    def structure(self) -> Hashable:
        """Everything that its traced step depends on besides numbers; the same for files of one content."""
        return self._structure

    @cached_property
    def _structure(self) -> Hashable:
        shapes = structure(self.gains()), structure(self.initial_state())
        if self.origin is None:
            return _identity(self.made), self.robot, *shapes
        return self.origin.make, _fingerprint(self.made, self.robot), self.robot, *shapes


def user_controller(
    made: Any, robot: Robot, origin: Origin | None = None, gains: Any = None
) -> UserController:
    """A user's object as a controller, compiled where it can be; arguments are those of `UserController`.

    Raises:
        ConfigError: when the object lacks something.
    """
    missing = [name for name in NEEDED if not hasattr(made, name)]
    if missing:
        said = f"controller(robot) in '{origin.file}' returns" if origin else "the controller is"
        kind = "nothing, expected an object with" if made is None else "an object without"
        raise ConfigError(f"{said} {kind} {', '.join(missing)}")
    if isinstance(made, type):
        raise ConfigError(
            f"the controller is the class {made.__name__}, expected an object: {made.__name__}()"
        )
    plain = UserController(made, robot, origin, gains)
    plain.try_step()
    return plain if plain.untraceable else CompiledUserController(made, robot, origin, gains)


def _to_read(record: R) -> R:
    """The same record of arrays and numbers, whose arrays cannot be written to; asked at every tick."""
    if isinstance(record, np.ndarray):
        record = record.view()
        record.flags.writeable = False
        return record
    if not isinstance(record, tuple):
        return record
    parts = map(_to_read, record)
    return record._make(parts) if hasattr(record, "_make") else tuple(parts)  # type: ignore[attr-defined]


def _identity(value: Any) -> Hashable:
    """Equal for one object alone, and keeps it alive: a method is compared by what it is bound to."""
    return MethodType(type, value)


def _copied(made: Any) -> Any:
    """A copy that shares the robots, which never change."""
    shared = {id(value): value for value in vars(made).values() if isinstance(value, Robot)}
    return copy.deepcopy(made, shared)


def _fingerprint(made: Any, robot: Robot) -> Hashable:
    """The numbers that an object carries, which end up as constants in its traced step."""
    known = {name: value for name, value in vars(made).items() if value is not robot}
    try:
        return hashlib.sha256(pickle.dumps(sorted(known.items()))).hexdigest()
    except Exception:  # whatever cannot be pickled is compared by identity
        return _identity(made)
