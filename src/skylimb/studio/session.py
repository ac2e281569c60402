"""A studio's session: live flights of one experiment, and everything that people may do to them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skylimb.analysis.palette import CONTROLLER_COLOURS, OTHER_COLOURS, label
from skylimb.control.controller import Controller
from skylimb.errors import ConfigError, SkylimbError, unknown_name
from skylimb.experiments.experiment import Experiment
from skylimb.flights.public import DEFAULT_CONTROLLER, take_off
from skylimb.flights.record import scored
from skylimb.simulation.disturbance import PushConfig
from skylimb.simulation.surface_changes import SurfaceChange
from skylimb.studio.changes import with_gain, with_push, without_push
from skylimb.studio.controls import IN_FLIGHT, PREFIX, controls_of
from skylimb.studio.drawings import keep_drawing, strokes_as_svg
from skylimb.studio.frames import FlightView
from skylimb.studio.gains import changes_in_flight, gain_keys, settled_gains
from skylimb.studio.live_flight import LiveFlight
from skylimb.studio.surface_edits import BLEND, surface_change, surface_keys_in_flight, with_surface
from skylimb.studio.watching import Watcher, files_of_controller
from skylimb.user_code import place_of

if TYPE_CHECKING:
    from skylimb.studio.keeping import Kept

MOST_FLIGHTS = 4
"""Flights beside each other at most."""

RUNNING, PAUSED, OVER = 0, 1, 2
"""State of a session in a frame."""

RESTARTED = "restarted"

_MOST_EVENTS = 1000


class Session:
    """One or more live flights of one experiment, in lockstep; one thread calls it.

    A method that is handed a value that cannot be raises a `SkylimbError`, and nothing has changed then.

    Args:
        experiment: a name, a TOML file, or an experiment at hand.
        controllers: presets, TOML files, Python files or controllers at hand; the experiment's own or
            "hybrid" when there is none.
        set: dotted keys and new values, as of `skylimb.run`.
        seed: of the sensors' noise; the experiment's own when None.
        out: folder for all that is kept; it is made when something is.
    """

    def __init__(
        self,
        experiment: str | Experiment = "paper",
        controllers: Sequence[str | Controller] = (),
        set: Mapping[str, Any] | None = None,
        seed: int | None = None,
        out: str | Path = "studio",
    ) -> None:
        self.out = Path(out)
        self.paused, self.speed_reached = False, 0.0
        self._experiment, self._seed = experiment, seed
        self._events: deque[dict[str, Any]] = deque(maxlen=_MOST_EVENTS)
        self._reports: list[Kept] = []
        given = dict(set or {})
        self._gains_of_all = {key: given.pop(key) for key in list(given) if key.startswith(PREFIX)}
        self._begin(tuple(controllers) or (None,), given, [{} for _ in controllers or (None,)])

    def _begin(
        self,
        controllers: Sequence[str | Controller | None],
        keys: Mapping[str, Any],
        gains: Sequence[Mapping[str, Any]],
    ) -> None:
        """Take off anew; what cannot be flown raises, and leaves everything as it was."""
        if len(controllers) > MOST_FLIGHTS:
            raise ConfigError(
                f"{len(controllers)} controllers are too many beside each other: at most {MOST_FLIGHTS}"
            )
        flights = []
        for controller, own in zip(controllers, gains, strict=True):
            settings = {
                **keys,
                **self._gains_of_all,
                **{f"{PREFIX}{key}": value for key, value in own.items()},
            }
            (takeoff,) = take_off(self._experiment, (controller,), self._seed, settings)
            flights.append(LiveFlight(takeoff))
        self._controllers, self._keys = tuple(controllers), dict(keys)
        self._gains = [dict(own) for own in gains]
        self._flights: list[LiveFlight] = flights
        self._first = [flight.experiment for flight in flights]
        self._held: list[tuple[float, PushConfig | None]] = [(0.0, None)]
        self._was_over = False
        self._watcher = Watcher(
            path
            for given, flight in zip(controllers, flights, strict=True)
            for path in files_of_controller(given, flight.takeoff.controller)
        )
        self._views = [
            FlightView(flight, name, colour)
            for flight, name, colour in zip(flights, *_names_and_colours(flights), strict=True)
        ]

    # What is known of it.

    @property
    def flights(self) -> tuple[LiveFlight, ...]:
        """The flights, in the order of their controllers."""
        return tuple(self._flights)

    @property
    def period(self) -> float:
        """Of a tick, s."""
        return self._flights[0].takeoff.period

    @property
    def time(self) -> float:
        """Time since take-off of the flight that came farthest, s."""
        return max(flight.time for flight in self._flights)

    @property
    def end(self) -> float:
        """Time at which the flights end at the latest, s."""
        return max(flight.end for flight in self._flights)

    @property
    def over(self) -> bool:
        """Whether no flight goes on."""
        return all(flight.over for flight in self._flights)

    @property
    def verdict(self) -> list[str]:
        """Of each flight, in words: that it flies, that it is over, or why it was lost."""
        return [_verdict(flight) for flight in self._flights]

    def scores(self) -> dict[str, dict[str, Any]]:
        """The scores of every flight so far, by its name; some 0.1 s of work.

        They are those of the part that was flown: of another, easier task than the whole.
        """
        found: dict[str, dict[str, Any]] = {}
        for view, flight in zip(self._views, self._flights, strict=True):
            so_far = flight.flight()
            if not flight.over:
                so_far = type(so_far)(so_far.signals, so_far.layout, so_far.ticks, "")
            run = scored(flight.takeoff, so_far)
            found[view.name] = {
                key: value
                for key, value in run.metrics.items()
                if isinstance(value, int | float | str | None)
            }
        return found

    def scene(self) -> dict[str, Any]:
        """What a page needs once, ready for JSON: each flight's scene, and where a frame's numbers are."""
        layout: list[dict[str, list[int]]] = []
        at = 3
        for view in self._views:
            places = {}
            for name, size in view.layout.items():
                places[name] = [at, at + size]
                at += size
            layout.append(places)
        return {
            "experiment": self._flights[0].experiment.name,
            "period": self.period,
            "end": self.end,
            "layout": {"time": 0, "speed": 1, "state": 2, "flights": layout, "size": at},
            "flights": [view.scene() for view in self._views],
        }

    def frame(self) -> np.ndarray:
        """What a page needs now: time, speed, state, then each flight's numbers (`scene()["layout"]`)."""
        state = OVER if self.over else PAUSED if self.paused else RUNNING
        head = np.array([self.time, self.speed_reached, state])
        return np.concatenate([head, *(view.values() for view in self._views)]).astype(np.float32)

    def controls(self) -> list[dict[str, Any]]:
        """Every gain and key as a control; see `controls.controls_of`."""
        return controls_of(self._flights, [settled_gains(flight.experiment) for flight in self._flights])

    def events(self) -> list[dict[str, Any]]:
        """What has happened since the last call: `event`, `time` and what belongs to it."""
        found = list(self._events)
        self._events.clear()
        return found

    # What people do.

    def advance(self, ticks: int) -> int:
        """Fly some ticks of every flight that goes on; returns how many, 0 when paused or over."""
        if self.paused:
            return 0
        flown = 0
        for _ in range(ticks):
            if self.over:
                break
            for number, flight in enumerate(self._flights):
                self._tick(number, flight)
            flown += 1
        if self.over and not self._was_over:
            self._tell("over", verdict=self.verdict)
        self._was_over = self.over
        return flown

    def _tick(self, number: int, flight: LiveFlight) -> None:
        try:
            flight.tick()
        except SkylimbError as error:
            self._tell("error", flight=number, **_told(error))

    def set_gain(self, flight: int | None, key: str, value: Any) -> str:
        """Change a gain of one flight, or of all that have it (None), in flight where that can be.

        Returns:
            "in flight" or "restarted".
        """
        key, value = key.removeprefix(PREFIX), _value(value)
        chosen = self._flights if flight is None else [self._flight(flight)]
        having = [one for one in chosen if key in gain_keys(one)]
        if not having:
            raise unknown_name("gain", key, {name for one in chosen for name in gain_keys(one)})
        if isinstance(value, str) and value.endswith(".py"):
            raise ConfigError(f"{key} = '{value}': a file of your own is named where the studio is started")
        if all(changes_in_flight(one, key) for one in having):
            self._branch({one: with_gain(one.experiment, one.time, key, value) for one in having})
            return IN_FLIGHT
        gains = self._gains_now()
        for one in having:
            own = gains[self._flights.index(one)]
            if key.endswith(".law"):  # another law has other gains
                own = {
                    name: old for name, old in own.items() if name.partition(".")[0] != key.partition(".")[0]
                }
            gains[self._flights.index(one)] = {**own, key: value}
        self._begin_again(self._controllers, self._keys, gains, f"{key} = {value}")
        return RESTARTED

    def set_key(self, key: str, value: Any) -> str:
        """Change a key of the experiment, or a gain of all flights; a key restarts the flights.

        Returns:
            "in flight" or "restarted".
        """
        if key.startswith(PREFIX):
            return self.set_gain(None, key, value)
        known = [control["key"] for control in self.controls()]
        if key not in known:
            raise unknown_name("key that can be set here", key, known)
        value = _value(value)
        if key in surface_keys_in_flight(self._flights[0].experiment) and not self.over:
            name = key.removeprefix("surface.")
            self._change_surface(SurfaceChange(time=self.time, blend=BLEND, **{name: value}))
            self._keys[key] = value
            return IN_FLIGHT
        self._begin_again(
            self._controllers, {**self._keys, key: value}, self._gains_now(), f"{key} = {value}"
        )
        return RESTARTED

    def poke(self, link: str, point: Sequence[float], force: Sequence[float]) -> None:
        """Push with a force (N, W) at a point (m) of a link, in its axes, until it is changed or released."""
        time = self.time
        if not any(force):
            self.release()
            return
        push = PushConfig(
            start=time,
            duration=round(max(self.end - time, self.period), 9),
            force=_vector(force, "force"),
            link=link,
            point=_vector(point, "point"),
        )
        held = self._held[-1][1]
        self._branch(
            {
                one: with_push(without_push(one.experiment, held, time) if held else one.experiment, push)
                for one in self._flights
                if not one.over
            }
        )
        self._held.append((time, push))

    def release(self) -> None:
        """Take the pushing force off."""
        held = self._held[-1][1]
        if held is None:
            return
        time = self.time
        self._branch({one: without_push(one.experiment, held, time) for one in self._flights if not one.over})
        self._held.append((time, None))

    def surface(
        self,
        position: Sequence[float] | None = None,
        tilt: Sequence[float] | None = None,
        friction: float | None = None,
        stiffness: float | None = None,
        present: bool | None = None,
    ) -> None:
        """Move, tilt or change the surface of all flights, or take it away.

        Args:
            position: how far its origin is to be from where it was at take-off, W, m, (3,).
            tilt: slope and pitch on top of those that it had then, rad; and roll where there is a third.
            friction: Coulomb coefficient.
            stiffness: N/m.
            present: false takes the surface away, true brings it back.
        """
        first = self._flights[0].experiment.surface
        change = surface_change(self.time, first, position, tilt, friction, stiffness, present)
        self._change_surface(change)

    def _change_surface(self, change: SurfaceChange) -> None:
        self._branch({one: with_surface(one.experiment, change) for one in self._flights if not one.over})

    def restart(self) -> None:
        """Fly again from take-off; gains keep what they were changed to, pushes and moves are left out."""
        self._begin_again(self._controllers, self._keys, self._gains_now(), "")

    def set_controllers(self, controllers: Sequence[str | Controller]) -> None:
        """Fly these controllers beside each other, from take-off, with their own gains."""
        chosen = tuple(controllers) or (DEFAULT_CONTROLLER,)
        self._begin_again(chosen, self._keys, [{} for _ in chosen], "")

    def rewind(self, seconds: float) -> None:
        """Go back by some seconds; what comes then is flown anew, without what people did after that time."""
        if not (math.isfinite(seconds) and seconds >= 0.0):
            raise ConfigError(f"seconds = {seconds:g} to rewind should be 0 or more")
        tick = max(1, round((self.time - seconds) / self.period))
        for number, flight in enumerate(self._flights):
            try:
                flight.rewind(tick)
            except SkylimbError as error:
                self._tell("error", flight=number, **_told(error))
        self._was_over = self.over
        time = self.time
        self._held = [entry for entry in self._held if entry[0] <= time + 1e-9] or [(0.0, None)]
        self.release()
        self._tell("rewound")

    def keep(self, name: str = "") -> Kept:
        """Keep the flights so far in a folder below `out`; see `keeping.keep`. They go on."""
        from skylimb.studio.keeping import keep  # figures are slow to load

        kept = keep(self._flights, _folder_names(self._flights), self.out, name)
        self._reports.append(kept)
        self._tell("kept", folder=str(kept.folder), command=kept.command)
        return kept

    def draw(self, drawing: str | Sequence[Sequence[Sequence[float]]]) -> Path:
        """Draw on the surface, from take-off.

        Args:
            drawing: the text of an SVG file, in the size and at the place that the experiment's path has; or
                strokes of points (u, v) in the surface's axes, m, drawn where they are.

        Returns:
            The SVG file that was kept.
        """
        takeoff, keys = self._flights[0].takeoff, dict[str, Any]()
        if isinstance(drawing, str):
            svg = drawing
        else:
            svg, keys = strokes_as_svg(drawing, takeoff.experiment.surface, takeoff.mission.frame)
        path = keep_drawing(svg, self.out)
        keys |= {"trajectory.shape": "drawing", "trajectory.file": str(path.resolve()), "trajectory.text": ""}
        try:
            self._begin_again(self._controllers, {**self._keys, **keys}, self._gains_now(), "a new drawing")
        except SkylimbError:
            path.unlink()
            raise
        return path

    def poll(self) -> None:
        """Look after what goes on beside the flights: edited files of controllers, reports that are drawn.

        A file that was edited restarts the flights with it; one that has a mistake leaves them as they are.
        """
        for kept in list(self._reports):
            if kept.report.poll() is None:
                continue
            self._reports.remove(kept)
            _, said = kept.report.communicate()
            if kept.report.returncode > 1:
                text = said.decode(errors="replace").strip().rpartition("\n")[2]
                self._tell("error", text=f"the report of {kept.folder} could not be drawn: {text}")
            else:
                self._tell("report", folder=str(kept.folder))
        edited = [path.name for path in self._watcher.changed()]
        if not edited:
            return
        try:
            self._begin_again(
                self._controllers, self._keys, self._gains_now(), f"{', '.join(edited)} was edited"
            )
        except SkylimbError as error:
            self._tell("error", **_told(error))

    # How it is done.

    def _branch(self, experiments: Mapping[LiveFlight, Experiment]) -> None:
        """Let flights go on with other experiments; all or none."""
        ready = {flight: flight.takeoff.changed(experiment) for flight, experiment in experiments.items()}
        for flight, takeoff in ready.items():
            flight.go_on(takeoff)

    def _begin_again(
        self,
        controllers: Sequence[str | Controller | None],
        keys: Mapping[str, Any],
        gains: Sequence[Mapping[str, Any]],
        why: str,
    ) -> None:
        self._begin(controllers, keys, gains)
        self._tell(RESTARTED, why=why)
        self._tell("scene")

    def _gains_now(self) -> list[dict[str, Any]]:
        """The gains that were set, with what changed in flight."""
        return [
            {**own, **settled_gains(flight.experiment, first)}
            for own, flight, first in zip(self._gains, self._flights, self._first, strict=True)
        ]

    def _flight(self, number: int) -> LiveFlight:
        if not 0 <= number < len(self._flights):
            raise ConfigError(f"flight {number}: there are {len(self._flights)}, numbered from 0")
        return self._flights[number]

    def _tell(self, event: str, **what: Any) -> None:
        self._events.append({"event": event, "time": self.time, **what})


def _names_and_colours(flights: Sequence[LiveFlight]) -> tuple[list[str], list[str]]:
    names, colours = [], []
    others = iter(OTHER_COLOURS)
    for flight in flights:
        name = flight.takeoff.controller.name
        called, number = label(name), 2
        while called in names:
            called, number = f"{label(name)} {number}", number + 1
        colour = CONTROLLER_COLOURS.get(name)
        colours.append(next(others) if colour is None or colour in colours else colour)
        names.append(called)
    return names, colours


def _verdict(flight: LiveFlight) -> str:
    if not flight.over:
        return "flying"
    return flight.cause or flight.flight().cause or "came to its end"


def _value(value: Any) -> Any:
    """A value from a page as a configuration has it."""
    return tuple(map(_value, value)) if isinstance(value, list | tuple) else value


def _vector(numbers: Sequence[float], what: str) -> tuple[float, float, float]:
    if len(numbers) != 3:
        raise ConfigError(f"{what} has {len(numbers)} numbers; it takes three")
    x, y, z = map(float, numbers)
    return x, y, z


def _told(error: SkylimbError) -> dict[str, Any]:
    place = place_of(error)
    return {"text": str(error), **({"file": place.file, "line": place.line} if place else {})}


def _folder_names(flights: Sequence[LiveFlight]) -> list[str]:
    """The controllers' names, with a number where two are called alike."""
    names: list[str] = []
    for flight in flights:
        name, number = flight.takeoff.controller.name, 2
        called = name
        while called in names:
            called, number = f"{name}-{number}", number + 1
        names.append(called)
    return names
