"""The six slots of the cascade, and how a law is found for one of them."""

from __future__ import annotations

import functools
import importlib
import inspect
import os
import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, get_type_hints

from skylimb.base.errors import unknown_name
from skylimb.base.keys import keys_of
from skylimb.base.plugins import added_file, added_names
from skylimb.base.user_modules import load_module
from skylimb.control.laws import Laws
from skylimb.control.laws.user_functions import UserLaw
from skylimb.control.needs import Needs, declared_needs


class Slots(NamedTuple):
    """One thing for each slot, in the order of the pipeline: laws, gains or states.

    Attributes:
        estimation: what is known of body and wrench (control/estimation/laws).
        contact: what is made of the contact (control/contact/laws).
        shape: what the arm does (control/shape/laws).
        translation: what keeps the centre of gravity (control/translation/laws).
        attitude: what keeps the attitude (control/attitude/laws).
        allocation: what makes thrusts of force and torque (control/allocation/laws).
    """

    estimation: Any
    contact: Any
    shape: Any
    translation: Any
    attitude: Any
    allocation: Any


class LiveGains(NamedTuple):
    """The gains of each slot, and what laws prepare of them.

    Attributes:
        estimation, contact, shape, translation, attitude, allocation: gains of the slot.
        prepared: by its slot what the law's `prepare` made of them, where it is made of numbers alone.
    """

    estimation: Any
    contact: Any
    shape: Any
    translation: Any
    attitude: Any
    allocation: Any
    prepared: dict[str, Any]


SLOTS = Slots._fields
_FUNCTIONS = {"estimation": ("step", "commanded"), "allocation": ("aim", "step")}


@dataclass(frozen=True)
class Slot:
    """One filled slot.

    Attributes:
        name: the law's name in the preset.
        law: its module, see `control.laws`.
        gains: an instance of the law's `Gains`.
        gives: fields that it gives (`control.laws.fields`), where a tick has shown them.
        python: its functions that cannot be compiled, by name (`control.laws.python_laws`).
    """

    name: str
    law: Any
    gains: Any
    gives: frozenset[str] | None = field(default=None, compare=False)
    python: Mapping[str, Any] = field(default_factory=dict, compare=False)

    @property
    def needs(self) -> Needs:
        """What the law needs of the loop; nothing unless it says so."""
        if not hasattr(self.law, "needs"):
            return Needs()
        return declared_needs(self.law.needs(self.gains), f"needs of law '{self.name}'")

    def require(self, dt: float) -> None:
        """Raise a `ConfigError` where the law cannot work at a control period of `dt` s."""
        if hasattr(self.law, "require"):
            self.law.require(self.gains, dt)


def traced_functions(slot: str) -> tuple[str, ...]:
    """Names of the functions of a slot's law that end up in the tick."""
    return _FUNCTIONS.get(slot, ("step",))


@functools.cache
def law_names(slot: str) -> tuple[str, ...]:
    """The laws that ship for a slot: the files of its folder."""
    package = importlib.import_module(_folder(slot))
    return tuple(sorted(module.name for module in pkgutil.iter_modules(package.__path__)))


def find_law(slot: str, name: str, folder: Path) -> Any:
    """A law by name, or by the path of a user's own file (relative to the preset's folder).

    Raises:
        UnknownNameError: when there is no such law.
        ConfigError: when the file cannot be used as one.
    """
    file = law_file(slot, name, folder)
    if file is None:
        return importlib.import_module(f"{_folder(slot)}.{name}")
    needed = ("Gains", "initial_state", *traced_functions(slot))
    return _user_law(slot, load_module(file, needed), name)


def law_file(slot: str, name: str, folder: Path) -> Path | None:
    """The file of a law that is a user's own or an installed package's; None where it ships.

    Raises:
        UnknownNameError: when there is no such law.
        ConfigError: when a package adds the name and it is not the package's alone.
    """
    if name.endswith(".py"):
        return folder / name
    file = added_file("laws", f"{slot}.{name}", name in law_names(slot))
    if file is None and name not in law_names(slot):
        own = [f"{name}.py"] if os.path.isfile(folder / f"{name}.py") else []  # False for too long a name
        raise unknown_name(f"{slot} law", name, [*law_names(slot), *added_names("laws", f"{slot}."), *own])
    return file


def keys_of_law(law: Any) -> list[str]:
    """Dotted key of every gain of a law."""
    return list(keys_of(law.Gains))


def shipped_gains() -> list[str]:
    """Whole key of every gain of the laws that ship, as often as laws have it."""
    return [
        f"{slot}.{name}"
        for slot in SLOTS
        for law in law_names(slot)
        for name in keys_of_law(find_law(slot, law, Path()))
    ]


_RENAMED = {
    "delay.compensate": 'estimation.law = "predictive"',
    "delay.rotor_lag": "allocation.rotor_lag.time_constant",
    "delay.lead": "allocation.rotor_lag.lead",
    "vectoring.move": 'allocation.law = "vectored"',
    "vectoring.lift": "allocation.hold_lift",
}
"""Keys of presets before there were six slots, where more than the place has changed."""


def right_key(key: str) -> str | None:
    """The whole key that is meant by one without its slot: "allocation.leak.cutoff" by "leak.cutoff"."""
    if key in _RENAMED:
        return _RENAMED[key]
    known = shipped_gains()
    ending = [name for name in known if name.endswith(f".{key}")]
    head = f".{key.partition('.')[0]}."
    inside = [name.partition(head)[0] + head[:-1] for name in known if head in name]
    return next(iter([*ending, *inside]), None)


@functools.lru_cache(maxsize=64)
def _user_law(slot: str, module: ModuleType, name: str) -> UserLaw:
    """A user's law; the same object as long as its files are the same, so that it is traced once."""
    protocol = get_type_hints(Laws)[slot]
    called = {
        function: [*inspect.signature(getattr(protocol, function)).parameters][1:]
        for function in traced_functions(slot)
    }
    return UserLaw(module, f"{slot} law '{name}'", called)


def _folder(slot: str) -> str:
    return f"skylimb.control.{slot}.laws"
