"""A studio's session: live flights of one experiment, and everything that people may do to them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skylimb.apps.studio.branching_flights import RESTARTED
from skylimb.apps.studio.changes import with_push
from skylimb.apps.studio.controls import IN_FLIGHT, values_of
from skylimb.apps.studio.drawing_flights import DrawingFlights
from skylimb.apps.studio.flight_setup import FlightSetup
from skylimb.apps.studio.key_edits import Edit, as_value, back_edit, key_edit
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.apps.studio.presets import Presets, names_of
from skylimb.apps.studio.surface_edits import (
    surface_change,
    with_surface,
)
from skylimb.base.errors import ConfigError, SkylimbError
from skylimb.control.controller import Controller
from skylimb.flight.events import Push, SurfaceChange
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.experiments.listing import list_controllers
from skylimb.flight.loading import DEFAULT_CONTROLLER

if TYPE_CHECKING:
    from skylimb.apps.studio.keeping import KeptFlights


class Session(DrawingFlights):
    """One live flight, or two, of one experiment, in lockstep; one thread calls it.

    A method that is handed a value that cannot be raises a `SkylimbError`, and nothing has changed then.

    Args:
        experiment: a name, a TOML file, or an experiment at hand.
        controllers: one or two presets, TOML files, Python files or controllers at hand; the experiment's
            own or "hybrid" when there is none.
        set: dotted keys and new values, as of `skylimb.run`.
        seed: of the sensors' noise; the experiment's own when None.
        out: folder for all that is kept; it is made when something is.

    Attributes:
        offered: the controllers that a page may name, by the name that it has for each.
        preset: what every key is as long as nobody changes it, by key and flight; None for all.
    """

    def __init__(
        self,
        experiment: str | Experiment = "paper",
        controllers: Sequence[str | Controller] = (),
        set: Mapping[str, Any] | None = None,
        seed: int | None = None,
        out: str | Path = "studio",
    ) -> None:
        setup = FlightSetup(experiment, tuple(controllers) or (None,), seed, dict(set or {}))
        self._presets = Presets(setup.keys)
        super().__init__(setup, Path(out))
        self._reports: list[KeptFlights] = []
        self.offered = dict(zip(self.flown, setup.controllers, strict=True))
        self.offered |= {name: name for name in list_controllers() if name not in self.offered}

    def _begin(self, setup: FlightSetup) -> None:
        super()._begin(setup)
        self.preset = self._presets.of(self.live)

    def controls(self) -> list[dict[str, Any]]:
        """Every gain and key as a control (`controls_of`), with its `preset`: one for each flight."""
        found = []
        for control in self.live.controls():
            presets = [
                self.preset.get((control["key"], number), value) for number, value in values_of(control)
            ]
            found.append({**control, "preset": presets if "flights" in control else presets[0]})
        return found

    @property
    def flown(self) -> list[str]:
        """The controllers that fly, by the names under which they are offered."""
        return names_of(self.live)

    # What people do.

    def set_key(self, key: str, value: Any, flight: int | None = None, entry: int | None = None) -> str:
        """Change a key of the experiment, or a gain of one flight or of all that have it (None).

        It acts in flight where it can; else the flights take off anew. Where an entry of a vector is named,
        counted from 0, the others stay what they are now.

        Returns:
            "in flight" or "restarted".
        """
        return self._do(key_edit(self.live, key, value, flight, entry), f"{key} {flight}")

    def rewind(self, time: float, changes: Iterable[tuple[str, Any, int | None, int | None]] = ()) -> None:
        """Go back to a time (s), and fly on from there with changes, without what came after it.

        Args:
            time: since take-off, s.
            changes: each as `set_key` takes it.
        """
        super().rewind(time)
        try:
            for change in changes:
                self.set_key(*change)
        except SkylimbError:
            self.undo()
            raise

    def back(self, to_preset: bool, key: str | None = None) -> None:
        """Bring a key, or every key, back to what it was at take-off or before anybody changed it here."""
        self._do(back_edit(self.live, self.preset if to_preset else None, self.begun_with, key), "")

    def _do(self, edit: Edit, kind: str) -> str:
        """Fly on with a change of keys, or take off anew with it."""
        if edit.experiments is None:
            self._begin_again(edit.setup, edit.words)
            return RESTARTED
        self._branch(edit.experiments, edit.words, kind)
        self.live.setup = edit.setup
        return IN_FLIGHT

    def poke(self, link: str, point: Sequence[float], force: Sequence[float]) -> None:
        """Push with a force (N, W) at a point (m) of a link, in its axes, until it is changed or released."""
        self._require_going()
        if not any(force):
            self.release()
            return
        time, live = self.live.time, self.live
        lasting = round(max(live.end - time, live.period), 9)
        push = Push(time, duration=lasting, force=as_value(force), link=link, point=as_value(point))
        self._branch(self._pushing(push), f"push on {link}", "" if self.pushed is None else "push")

    def release(self) -> None:
        """Take the pushing force off."""
        if self.pushed is not None:
            self.live.branch(self._pushing())

    def _pushing(self, *push: Push) -> dict[LiveFlight, Experiment]:
        """The experiments in which what is held is let go, and it is pushed so instead."""
        time = self.live.time
        return {one: with_push(one.experiment, one.first, time, *push) for one in self.live.going}

    @property
    def pushed(self) -> Push | None:
        """The push by hand that is held now."""
        shown, now = self.live.shown, self.live.time
        held = [
            one for one in shown.experiment.events if isinstance(one, Push) and one not in shown.first.events
        ]
        return next((one for one in held if one.time + one.duration > now + 1e-9), None)

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
        material = {"friction": friction, "stiffness": stiffness, "present": present}
        shown = self.live.shown
        self._change_surface(surface_change(self.live.time, shown.experiment, position, tilt, **material))

    def _change_surface(self, change: SurfaceChange) -> None:
        self._require_going()
        going = {one: with_surface(one.experiment, change) for one in self.live.going}
        self._branch(going, change.words, f"surface {sorted(change.changed)}")

    def _require_going(self) -> None:
        if self.live.over:
            raise ConfigError("the flight is over; take off again (R)")

    def restart(self) -> None:
        """Fly again from take-off; gains keep what they were changed to, pushes and moves are left out."""
        self._begin_again(self._setup_now(), "")

    def set_controllers(self, controllers: Sequence[str | Controller]) -> None:
        """Fly these controllers beside each other, from take-off; one that stays keeps its gains.

        Args:
            controllers: those that are offered by their names, or others.
        """
        given = tuple(
            self.offered.get(one, one) if isinstance(one, str) else one
            for one in controllers or (DEFAULT_CONTROLLER,)
        )
        self._begin_again(self._setup_now().with_controllers(given), "", "other controllers")

    def recover(self) -> None:
        """Take off again with the last gains that flew well (`good_gains`), else with those of the preset."""
        good, setup = self._good_now(), self.live.setup
        gains = good.with_controllers(setup.controllers).gains if good else ()
        self._begin_again(replace(setup, gains=gains), "the last good gains")

    def keep(self, name: str = "") -> KeptFlights:
        """Keep the flights so far in a folder below `out`; see `keeping.keep`. They go on."""
        from skylimb.apps.studio.keeping import keep  # figures are slow to load

        kept = keep(self.live.flights, self.live.names, self.out, name)
        self._reports.append(kept)
        self._tell("kept", folder=str(kept.folder), commands=kept.commands)
        return kept

    def poll(self) -> None:
        """Look after what goes on beside the flights: edited files of controllers, reports, a full disk.

        A file that was edited restarts the flights with it; one that has a mistake leaves them as they are.
        """
        for kept in [kept for kept in self._reports if kept.drawn]:
            self._reports.remove(kept)
            if mistake := kept.mistake():
                self._tell("trouble", text=f"the report of {kept.folder} could not be drawn: {mistake}")
            else:
                self._tell("report", folder=str(kept.folder))
        if self._recorder is not None and self._recorder.faults:
            self._tell("trouble", text="; ".join(self._recorder.faults))
            self._recorder = None
        edited = [path.name for path in self._watcher.changed()]
        if edited:
            names = ", ".join(edited)
            flying = f"What flies is {names} as it was at {self._begun:%H:%M:%S}."
            self._try(None, lambda: self._begin_again(self._setup_now(), f"{names} was edited"), flying)
