"""What a law of each slot is: a module (or any object) with `Gains`, `initial_state` and `step`.

Every `step` returns three things: its new state, its output, and signals to record under their names.
States are records of arrays, or an empty tuple. A law that ships declares `PROVIDES`, `REQUIRES` and
`OPTIONAL`: which fields of the records between slots it gives and reads (`control.laws.fields`). A law may
define

- `needs(gains) -> Needs`, when it sets the mission's pace or wants a preview of the reference,
- `require(gains, dt)`, which raises a `ConfigError` when it cannot work at a control period of dt s.

An allocation law whose state has a field `residual`, a `Wrench`, says with it what its rotors fell short of.
The laws of the next tick find it as `LawInput.residual`, absent where the law has none; those that
integrate hold (`control.windup`).
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from skylimb.control.estimation.records import Estimate, Sensed, Signals, Start, Wrench
from skylimb.control.records import Allocated, ArmTarget, ContactView, Demand, LawInput
from skylimb.symbolic import Array


class Law(Protocol):
    """What laws of every slot have."""

    @property
    def Gains(self) -> type:
        """A frozen dataclass: the keys of the slot's table in a preset."""
        ...

    def initial_state(self, gains: Any, start: Start, /) -> Any:
        """The law's state before the first tick."""
        ...


class EstimationLaw(Law, Protocol):
    """Measurement to estimate."""

    def step(self, gains: Any, state: Any, sensed: Sensed, /) -> tuple[Any, Estimate, Signals]:
        """The estimate of this tick."""
        ...

    def commanded(self, gains: Any, state: Any, estimate: Estimate, rotors: Wrench, dt: float, /) -> Any:
        """The state that knows which wrench the rotors really make until the next tick."""
        ...


class ContactLaw(Law, Protocol):
    """Judges the contact, and may set the mission's pace by a signal "pace"."""

    def step(self, gains: Any, state: Any, inputs: LawInput, /) -> tuple[Any, ContactView, Signals]:
        """What the laws after it may know of the contact."""
        ...


class ShapeLaw(Law, Protocol):
    """What the arm does."""

    def step(
        self, gains: Any, state: Any, inputs: LawInput, reach_limits: tuple[float, float], /
    ) -> tuple[Any, ArmTarget, Signals]:
        """The wanted reach, m, within its limits."""
        ...


class TranslationLaw(Law, Protocol):
    """Keeps the centre of gravity, or the tip, where it should be."""

    def step(self, gains: Any, state: Any, inputs: LawInput, /) -> tuple[Any, Array, Signals]:
        """f_cmd in W, N, (3,); a signal "cog_position_target" where it leads the centre of gravity."""
        ...


class AttitudeLaw(Law, Protocol):
    """Keeps the attitude."""

    def step(
        self, gains: Any, state: Any, inputs: LawInput, R_target: Array, /
    ) -> tuple[Any, Array, Signals]:
        """tau_cmd in C, N m, (3,), for a target attitude R_W,Cref."""
        ...


class AllocationLaw(Law, Protocol):
    """Makes thrusts and vectoring angles of force and torque."""

    def aim(self, gains: Any, state: Any, inputs: LawInput, force: Array, /) -> Array:
        """The part of the wanted force that the tilt of the robot has to give, W, N, (3,)."""
        ...

    def step(
        self, gains: Any, state: Any, inputs: LawInput, demand: Demand, /
    ) -> tuple[Any, Allocated, Signals]:
        """The command, and the wrench that comes of it."""
        ...


class Laws(NamedTuple):
    """The law of every slot."""

    estimation: EstimationLaw
    contact: ContactLaw
    shape: ShapeLaw
    translation: TranslationLaw
    attitude: AttitudeLaw
    allocation: AllocationLaw
