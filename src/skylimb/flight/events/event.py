"""What every event is, and what its kinds may do to a flight."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np

from skylimb.base.errors import unknown_name
from skylimb.base.keys import Key, configuration, refused
from skylimb.control.controller import Controller
from skylimb.robots.model import Robot
from skylimb.simulation.sensors import SensorConfig
from skylimb.simulation.surfaces import Surface

if TYPE_CHECKING:
    from skylimb.simulation.plant import Plant


class EventContext(NamedTuple):
    """What an event may name: who flies, and what is touched.

    Attributes:
        robot: as it is described.
        controller: what flies it.
        surface: as it is before take-off.
        period: of the control, s.
        touches: "ball", "foot" or "peg": what the robot touches it with.
        sensors: that measure it.
        supervised: whether a supervisor stands between controller and plant.
        plant: the simulated robot and surface; None where no engine simulates them.
    """

    robot: Robot
    controller: Controller
    surface: Surface
    period: float
    touches: str = "ball"
    sensors: SensorConfig = SensorConfig()
    supervised: bool = False
    plant: Plant | None = None


@configuration
class Event(abc.ABC):
    """Something that happens to a flight besides what its mission asks: when, what, for how long."""

    kind: Annotated[str, Key("", "what happens; skylimb show event.KIND has the other keys")] = field(
        kw_only=True
    )
    time: Annotated[float, Key("s", "time since take-off at which it begins", low=0.0, high=1e5)]
    duration: Annotated[float, Key("s", "how long it takes or lasts", low=0.0, high=1e5)] = field(
        default=0.0, kw_only=True
    )
    latest: Annotated[
        float | None,
        Key("s", "last time at which it may begin: the seed draws one from time on", low=0.0, high=1e5),
    ] = field(default=None, kw_only=True)

    on: ClassVar[Literal["controller", "plant"]]
    """What it changes: numbers of the controller, which every driver has, or the simulated plant."""

    lasts: ClassVar[bool] = False
    """Whether its duration is how long it acts, in whole control periods; else how long a change takes."""

    def check(self) -> None:
        """Refuse a last onset that comes before the first."""
        if self.latest is not None and self.latest < self.time:
            raise refused(self, "latest", f"comes before time = {self.time:g} s")

    @property
    @abc.abstractmethod
    def words(self) -> str:
        """What happens, in a few words, for lists and plots."""

    @abc.abstractmethod
    def require(self, context: EventContext) -> None:
        """Raise a `ConfigError` unless what it names is there and may be changed like this."""

    @property
    def changed(self) -> Mapping[str, Any]:
        """What gets a new value, by name; two events of one time may not give it two."""
        return {}

    @classmethod
    @abc.abstractmethod
    def effect(cls, events: Sequence[Any], context: EventContext, times: np.ndarray) -> Effect:
        """What all events of this kind do to a flight, tick by tick.

        Args:
            events: of this kind, in any order; at least one.
            context: what they act on; with a plant for kinds that act on it.
            times: of every tick that the flight may have, s.
        """

    def drawn(self, seed: int, number: int) -> Self:
        """The same event at the time that a flight's seed draws, evenly from `time` to `latest`.

        Args:
            seed: of the flight.
            number: of the event in its experiment, so that two events have times of their own.
        """
        if self.latest is None:
            return self
        time = np.random.default_rng([seed, number]).uniform(self.time, self.latest)
        return replace(self, time=round(float(time), 6), latest=None)

    def lasting(self, times: np.ndarray) -> slice:
        """The ticks in which an event acts that lasts for its duration; to the flight's end where it is 0."""
        end = self.time + self.duration if self.duration > 0.0 else np.inf
        return slice(*np.searchsorted(times, [self.time - 1e-9, end - 1e-9]))

    def __str__(self) -> str:
        return f"{self.kind} at {self.time:g} s"


def require_known(kind: str, name: str, known: Sequence[str], optional: bool = True) -> None:
    """Refuse a name of something that the robot has not.

    Args:
        kind: of what is named, and by what.
        name: of it.
        known: every name that would be right.
        optional: whether none may be named.

    Raises:
        ConfigError: with the nearest right name.
    """
    if (name or not optional) and name not in known:
        raise unknown_name(kind, name, known)


@dataclass(frozen=True)
class GainRows:
    """The controller's gains that change, at every tick.

    Attributes:
        columns: where they stand in the flat gains, (m,).
        values: what they are, one row for every tick that the flight may have, (k, m).
    """

    columns: np.ndarray
    values: np.ndarray


class Place(NamedTuple):
    """Some numbers of the engine's model.

    Attributes:
        field: array of `mujoco.MjModel`.
        row: of that array.
        entries: how many numbers of the row, from its first one on.
        column: of the first one among the numbers that are written (`ModelRows.values`).
    """

    field: str
    row: int
    entries: int
    column: int


@dataclass(frozen=True)
class ModelRows:
    """Numbers of the engine's model at every tick.

    Attributes:
        places: where they are written to.
        values: what they are, one row for every tick that the flight may have, (k, m).
    """

    places: tuple[Place, ...]
    values: np.ndarray

    @classmethod
    def untouched(cls, model: Any, fields: Sequence[tuple[str, int, int]], times: np.ndarray) -> ModelRows:
        """Numbers that nothing has changed yet.

        Args:
            model: `mujoco.MjModel`.
            fields: array, row, and how many entries of it, in the order of the columns.
            times: of the ticks, s.
        """
        begins = np.cumsum([0, *(entries for _, _, entries in fields)])
        places = tuple(Place(*one, int(begin)) for one, begin in zip(fields, begins, strict=False))
        first = np.concatenate([np.ravel(getattr(model, name)[row])[:count] for name, row, count in fields])
        return cls(places, np.tile(first, (len(times), 1)))


@dataclass(frozen=True)
class TickRows:
    """What is added to the numbers that are known of every tick before take-off.

    Attributes:
        added: to `simulation.rows.TickRow`, packed, one row for every tick that the flight may have, (k, m).
    """

    added: np.ndarray


Effect = GainRows | ModelRows | TickRows | tuple[Any, ...]
"""What a kind of event does: gains, numbers of the model or of the sensors, or a tuple of `Wrench`."""


class Change(NamedTuple):
    """Numbers that go to new values: from when on, in how long, s, and to which, (m,)."""

    time: float
    duration: float
    to: np.ndarray


def write_changes(
    table: np.ndarray, columns: Any, changes: Sequence[Change], times: np.ndarray, smooth: bool = False
) -> None:
    """Write changes of the same numbers into a table.

    Each begins at what the numbers are at its time, also in the middle of an earlier change.

    Args:
        table: a row for every tick.
        columns: where the numbers stand in it.
        changes: in any order.
        times: of the ticks, s.
        smooth: as a smooth step; else along a straight line.
    """
    ordered = sorted(changes, key=lambda change: change.time)
    begins = [int(np.searchsorted(times, change.time - 1e-9)) for change in ordered]
    # Up to the next change, which reads there where it begins.
    for change, begin, following in zip(ordered, begins, [*begins, len(times)][1:], strict=True):
        rows = slice(begin, following + 1)
        since = times[rows] - change.time
        part = np.clip(since / change.duration, 0.0, 1.0) if change.duration > 0.0 else np.ones(len(since))
        part = (part * part * (3.0 - 2.0 * part) if smooth else part)[:, None]
        # Written so that it is the new value to the bit in the end.
        table[rows, columns] = (1.0 - part) * table[begin : begin + 1, columns] + part * change.to
