"""A studio's session: live flights of one experiment, and everything that people may do to them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skylimb.apps.studio.changes import with_gain, with_push
from skylimb.apps.studio.controls import IN_FLIGHT, PREFIX
from skylimb.apps.studio.drawings import keep_drawing, strokes_as_svg
from skylimb.apps.studio.flight_setup import FlightSetup
from skylimb.apps.studio.live_flights import LiveFlights
from skylimb.apps.studio.surface_edits import DURATION, surface_change, surface_keys_in_flight, with_surface
from skylimb.apps.studio.watching import Watcher, files_of_controller
from skylimb.base.errors import ConfigError, SkylimbError, unknown_name
from skylimb.base.user_code import place_of
from skylimb.control.controller import Controller
from skylimb.flight.events import Push, SurfaceChange
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.loading import DEFAULT_CONTROLLER

if TYPE_CHECKING:
    from skylimb.apps.studio.keeping import KeptFlights

Say = Callable[[str, Any], None]
"""Takes the name of an event and what belongs to it."""

RESTARTED = "restarted"
"""What a change did that no flight can take in flight."""


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

    Attributes:
        say: takes the name of what happens and what belongs to it, its time among that.
        live: the flights, and what a page shows of them.
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
        self.say: Say = lambda event, content: None
        self._reports: list[KeptFlights] = []
        self._begin(FlightSetup(experiment, tuple(controllers) or (None,), seed, dict(set or {})))

    def _begin(self, setup: FlightSetup) -> None:
        """Take off anew; what cannot be flown raises, and leaves everything as it was."""
        self.live = live = LiveFlights(setup)
        self._was_over = False
        self._watcher = Watcher(
            path
            for given, flight in zip(setup.controllers, live.flights, strict=True)
            for path in files_of_controller(given, flight.takeoff.controller)
        )

    def _begin_again(self, setup: FlightSetup, why: str) -> None:
        self._begin(setup)
        self._tell(RESTARTED, why=why)
        self._tell("scene")

    # What people do.

    def advance(self, ticks: int) -> int:
        """Fly some ticks of every flight that goes on; returns how many, 0 when all are over."""
        flown = 0
        while flown < ticks and not self.live.over:
            for number, flight in enumerate(self.live.flights):
                self._try(number, flight.tick)
            flown += 1
        if self.live.over and not self._was_over:
            self._tell("over", verdict=self.live.verdict)
        self._was_over = self.live.over
        return flown

    def set_key(self, key: str, value: Any, flight: int | None = None) -> str:
        """Change a key of the experiment, or a gain of one flight or of all that have it (None).

        It acts in flight where it can; else the flights take off anew.

        Returns:
            "in flight" or "restarted".
        """
        control = self.live.known.get(key)
        if control is None:
            raise unknown_name("key that can be set here", key, self.live.known)
        if isinstance(value, str) and value not in control["choices"] and _names_a_file(value):
            raise ConfigError(f"{key} = '{value[:60]}' names a file; name it on the command line with --set")
        if key.startswith(PREFIX):
            return self._set_gain(control, _value(value), flight)
        return self._set_of_experiment(key, _value(value))

    def _set_gain(self, control: Mapping[str, Any], value: Any, flight: int | None) -> str:
        live, key = self.live, control["key"].removeprefix(PREFIX)
        chosen = control["flights"] if flight is None else [flight]
        if not set(chosen) <= set(control["flights"]):
            raise ConfigError(
                f"flight {flight} has no gain '{key}'; those that have it are {control['flights']}"
            )
        having = [self.live.flights[number] for number in chosen]
        if control["acts"] == IN_FLIGHT and all(one.time < one.end for one in having):
            live.branch({one: with_gain(one.experiment, one.time, key, value) for one in having})
            return IN_FLIGHT
        gains = list(live.gains())
        for number in chosen:
            gains[number] = {**_without_law(gains[number], key), key: value}
        self._begin_again(replace(live.setup, gains=tuple(gains)), f"{key} = {value}")
        return RESTARTED

    def _set_of_experiment(self, key: str, value: Any) -> str:
        setup = self.live.setup.with_keys({key: value})
        if key in surface_keys_in_flight(self.live.flights[0].experiment) and not self.live.over:
            name = key.removeprefix("surface.")
            self._change_surface(SurfaceChange(self.live.time, duration=DURATION, **{name: value}))
            self.live.setup = setup
            return IN_FLIGHT
        self._begin_again(replace(setup, gains=self.live.gains()), f"{key} = {value}")
        return RESTARTED

    def poke(self, link: str, point: Sequence[float], force: Sequence[float]) -> None:
        """Push with a force (N, W) at a point (m) of a link, in its axes, until it is changed or released."""
        if not any(force):
            self.release()
            return
        time, live = self.live.time, self.live
        lasting = round(max(live.end - time, live.period), 9)
        self._push(Push(time, duration=lasting, force=_value(force), link=link, point=_value(point)))

    def release(self) -> None:
        """Take the pushing force off."""
        self._push()

    def _push(self, *push: Push) -> None:
        """Let go of what is held, and push so instead."""
        going = [one for one in self.live.flights if not one.over]
        self.live.branch({one: with_push(one.experiment, one.first, self.live.time, *push) for one in going})

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
        first = self.live.flights[0].experiment.surface
        self._change_surface(
            surface_change(self.live.time, first, position, tilt, friction, stiffness, present)
        )

    def _change_surface(self, change: SurfaceChange) -> None:
        self.live.branch(
            {one: with_surface(one.experiment, change) for one in self.live.flights if not one.over}
        )

    def restart(self) -> None:
        """Fly again from take-off; gains keep what they were changed to, pushes and moves are left out."""
        self._begin_again(self._setup_now(), "")

    def set_controllers(self, controllers: Sequence[str | Controller]) -> None:
        """Fly these controllers beside each other, from take-off, with their own gains."""
        self._begin_again(
            replace(self.live.setup, controllers=tuple(controllers) or (DEFAULT_CONTROLLER,), gains=()), ""
        )

    def rewind(self, seconds: float) -> None:
        """Go back by some seconds; what comes then is flown anew, without what people did after that time."""
        if not (math.isfinite(seconds) and seconds >= 0.0):
            raise ConfigError(f"seconds = {seconds:g} to rewind should be 0 or more")
        tick = max(1, round((self.live.time - seconds) / self.live.period))
        for number, flight in enumerate(self.live.flights):
            self._try(number, lambda flight=flight: flight.rewind(tick))
        self._was_over = self.live.over
        self.release()  # what was held at that time is held no more
        self._tell("rewound")

    def keep(self, name: str = "") -> KeptFlights:
        """Keep the flights so far in a folder below `out`; see `keeping.keep`. They go on."""
        from skylimb.apps.studio.keeping import keep  # figures are slow to load

        kept = keep(self.live.flights, self.live.names, self.out, name)
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
        takeoff, keys = self.live.flights[0].takeoff, dict[str, Any]()
        if isinstance(drawing, str):
            svg = drawing
        else:
            svg, keys = strokes_as_svg(drawing, takeoff.experiment.surface, takeoff.mission.frame)
        path = keep_drawing(svg, self.out)
        keys |= {"trajectory.shape": "drawing", "trajectory.file": str(path.resolve()), "trajectory.text": ""}
        try:
            self._begin_again(self._setup_now().with_keys(keys), "a new drawing")
        except SkylimbError:
            path.unlink()
            raise
        return path

    def poll(self) -> None:
        """Look after what goes on beside the flights: edited files of controllers, reports that are drawn.

        A file that was edited restarts the flights with it; one that has a mistake leaves them as they are.
        """
        for kept in [kept for kept in self._reports if kept.drawn]:
            self._reports.remove(kept)
            if mistake := kept.mistake():
                self._tell("error", text=f"the report of {kept.folder} could not be drawn: {mistake}")
            else:
                self._tell("report", folder=str(kept.folder))
        edited = [path.name for path in self._watcher.changed()]
        if edited:
            self._try(None, lambda: self._begin_again(self._setup_now(), f"{', '.join(edited)} was edited"))

    # How it is done.

    def _setup_now(self) -> FlightSetup:
        """What is flown, with the gains as they have become."""
        return replace(self.live.setup, gains=self.live.gains())

    def _try(self, flight: int | None, act: Callable[[], object]) -> None:
        """Do something that runs the user's code; what goes wrong there is an event, and ends nothing."""
        try:
            act()
        except SkylimbError as error:
            what: dict[str, Any] = {} if flight is None else {"flight": flight}
            if place := place_of(error):  # in a file of the user's
                what |= {"file": place.file, "line": place.line}
            self._tell("error", text=str(error), **what)

    def _tell(self, event: str, **what: Any) -> None:
        self.say(event, {"time": self.live.time, **what})


def _value(value: Any) -> Any:
    """A value from a page as a configuration has it."""
    return tuple(map(_value, value)) if isinstance(value, list | tuple) else value


def _names_a_file(text: str) -> bool:
    """Whether a text reads like a path or a file's name, with or without a function behind it."""
    stem, dot, ending = text.partition(":")[0].rpartition(".")
    return "/" in text or "\\" in text or bool(stem and dot and ending.isalnum() and not ending.isdigit())


def _without_law(gains: Mapping[str, Any], key: str) -> dict[str, Any]:
    """The gains without those of a slot whose law `key` changes: another law has other gains."""
    slot, _, name = key.partition(".")
    return {old: value for old, value in gains.items() if name != "law" or old.partition(".")[0] != slot}
