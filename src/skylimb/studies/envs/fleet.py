"""Flights in lock-step that are acted on, observed and paid for; it knows nothing of Gymnasium."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.config import from_mapping
from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.flight.drivers.native.lockstep import LockStep
from skylimb.flight.experiments.experiment import robot_of
from skylimb.flight.takeoff import Takeoff, prepare
from skylimb.simulation.rows import reference_layout
from skylimb.studies.campaign.draws import Draw
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.envs.actions import actions_of, controller_of
from skylimb.studies.envs.observations import Observations
from skylimb.studies.envs.rewards import Seen, term
from skylimb.studies.envs.tasks import EnvSettings


@configuration
class Size:
    """How many environments fly, and on how many threads."""

    num_envs: Annotated[int, Key("", "environments that fly together", low=1, high=100_000)]
    threads: Annotated[int, Key("", "on which they fly", low=1, high=1024)]


@dataclass(frozen=True)
class Stepped:
    """What came of a step in some places.

    Attributes:
        observations: (places, size).
        rewards: sum of the weighted terms, (places,).
        terms: each term by its name before its weight, (places,).
        lost: whether the flight was lost, (places,).
        over: whether it came to its end, (places,).
    """

    observations: np.ndarray
    rewards: np.ndarray
    terms: Mapping[str, np.ndarray]
    lost: np.ndarray
    over: np.ndarray


class Fleet:
    """Environments that fly together on the native batch.

    Args:
        count: how many.
        threads: on which they fly; what they fly does not depend on it.
        settings: keys of `EnvSettings`.

    Attributes:
        settings: what was set.
        actions: how the flights are acted on.
        flights: in lock-step.
        draws: which draw each environment flies, (count,).
        signals: layout of the signals.
        last: signals of the last tick of each, (count, signals).

    Raises:
        SkylimbError: naming what cannot be set or flown, before anything flies.
    """

    def __init__(self, count: int = 1, threads: int = 1, **settings: Any) -> None:
        size = from_mapping(Size, {"num_envs": count, "threads": threads}, "environment")
        count, threads = int(size.num_envs), int(size.threads)
        self.settings = from_mapping(EnvSettings, settings, "environment")
        self._campaign = freeze(self.settings.spec())
        self._known: dict[int, tuple[Draw, Takeoff]] = {}
        draw, first = self.start(0)
        self._numbers = tuple(key for key, value in draw.values.items() if isinstance(value, int | float))
        self.actions = actions_of(self.settings, first)
        self._shown = Observations(first, self.settings, self._numbers)
        self.flights = LockStep([first] * count, self.settings.ticks, threads)
        self.signals, self._asked = first.tick.signals, reference_layout(first.plant.robot)
        self._period = first.period
        self.count, self.draws = count, np.zeros(count, int)
        self._drawn = np.zeros((count, len(self._numbers)))
        self.last = np.zeros((count, first.tick.signals.size))
        self._before = np.tile(self.actions.neutral, (count, 1))
        self._history = np.zeros((count, self.settings.history, self._shown.size))

    @property
    def layout(self) -> tuple[tuple[str, int], ...]:
        """Name and size of each part of one observation."""
        return tuple((part.name, part.size) for part in self._shown.parts)

    @property
    def observed(self) -> int:
        """Numbers of an observation, its history included."""
        return self._shown.size * self.settings.history

    @property
    def step_time(self) -> float:
        """Time of a step, s."""
        return self.settings.ticks * self._period

    def restart(self, places: Sequence[int] | np.ndarray, draws: Sequence[int]) -> np.ndarray:
        """Take off anew in some places, and fly the first tick.

        Args:
            places: where.
            draws: which draw each flies.

        Returns:
            Observations, (places, observed).
        """
        for place, number in zip(places, draws, strict=True):
            draw, _ = self.start(number)
            self.draws[place] = number
            self._drawn[place] = [draw.values[key] for key in self._numbers]
        self.flights.restart(
            {place: self.start(number)[1] for place, number in zip(places, draws, strict=True)}
        )
        for place in places:
            self.actions.begin(self.flights, place)
        at = list(places)
        self._before[at] = self.actions.neutral
        self._fly(at, self._before[at], 1)
        self._history[at] = self._observed(at)[:, None]
        return self._history[at].reshape(len(at), -1)

    def step(self, places: Sequence[int] | np.ndarray, actions: ArrayLike) -> Stepped:
        """Fly a step in some places.

        Args:
            places: where.
            actions: between -1 and 1, what is beyond counts as its end, (places, actions).

        Raises:
            ConfigError: for actions of another shape, or that are no numbers; nothing has flown then.
        """
        at, actions = list(places), self.checked(places, actions)
        self._fly(at, actions, self.settings.ticks)
        flights = [self.flights.flights[place] for place in at]
        over = np.array([flight.over for flight in flights])
        lost = np.array([bool(flight.record.stopped) for flight in flights]) & ~over
        self._history[at] = np.concatenate([self._observed(at)[:, None], self._history[at][:, :-1]], axis=1)
        seen = Seen(
            self.last[at], self.signals, self._references(at), self._asked,
            self.flights.tips[at], actions, self._before[at], lost, self.settings.force,
        )  # fmt: skip
        terms = {name: term(name, seen) for name in self.settings.weights}
        paid = sum((self.settings.weights[name] * each for name, each in terms.items()), np.zeros(len(at)))
        self._before[at] = actions
        return Stepped(self._history[at].reshape(len(at), -1), paid, terms, lost, over)

    def checked(self, places: Sequence[int] | np.ndarray, actions: ArrayLike) -> np.ndarray:
        """Actions between -1 and 1; see `step`."""
        names = self.actions.names
        try:
            given = np.asarray(actions).astype(float, casting="same_kind")
        except (TypeError, ValueError):
            raise ConfigError(f"actions should be numbers: {', '.join(names)}") from None
        if given.shape[:1] != (len(places),):
            raise ConfigError(
                f"actions have shape {given.shape}; {len(places)} are needed: {', '.join(names)}"
            )
        if given.shape[1:] != (len(names),):
            raise ConfigError(
                f"an action has shape {given.shape[1:]}; {len(names)} numbers are needed: {', '.join(names)}"
            )
        if not np.isfinite(given).all():
            row, column = np.argwhere(~np.isfinite(given))[0]
            raise ConfigError(
                f"action '{names[column]}' of environment {places[row]} is {given[row, column]}; it should "
                "be a number between -1 and 1"
            )
        return np.clip(given, -1.0, 1.0)

    def _fly(self, places: list[int], actions: np.ndarray, ticks: int) -> None:
        """Fly, and keep the last row of each place that is all numbers."""
        for place, action in zip(places, actions, strict=True):
            self.actions.act(self.flights, place, action, ticks)
        flown = self.flights.fly(places, ticks)
        rows = self.flights.rows[places, np.maximum(flown - 1, 0)]
        # What a flight that is lost at this tick does not know stands as it was.
        self.last[places] = np.where(np.isfinite(rows), rows, self.last[places])

    def _references(self, places: list[int]) -> np.ndarray:
        """What is asked for now, as the mission has it, (places, entries)."""
        flights, asked = self.flights.flights, self.flights.asked
        return np.array([asked[place][int(flights[place].record.at)] for place in places])

    def _observed(self, places: list[int]) -> np.ndarray:
        asked, tips = self._references(places), self.flights.tips[places]
        return self._shown.of(self.last[places], asked, tips, self._drawn[places])

    def start(self, number: int) -> tuple[Draw, Takeoff]:
        """A draw and its take-off, which later episodes share."""
        if number not in self._known:
            draw = self._campaign.draw(number)
            experiment = self._campaign.experiment_of(draw)
            robot, (name,) = robot_of(experiment), self._campaign.names
            given = self._campaign.load(name, robot, self._campaign.gains_of(draw, name))
            controller = controller_of(self.settings, robot, given)
            self._known[number] = draw, prepare(experiment, robot, controller)
        return self._known[number]
