"""The thread that flies: it alone calls the session. It obeys commands and says what a page has to show."""

from __future__ import annotations

import gc
import math
import queue
import secrets
import time
from collections.abc import Callable
from typing import Any

from skylimb.apps.studio import messages
from skylimb.apps.studio.branching_flights import Say
from skylimb.apps.studio.live_state import live_state, next_event
from skylimb.apps.studio.pacing import Pacing
from skylimb.apps.studio.session import Session
from skylimb.base.errors import ConfigError, SkylimbError, choice_error

FRAME_PERIOD = 0.02
"""Seconds between two frames that are made; a page gets as many of them as it can show."""

POLL_PERIOD = 0.4
"""Seconds between two looks at the user's files, and two reports of how many ticks were late."""

PAST_PERIOD = 0.05
"""Flight time between two frames of a past that is sent anew, s."""

IDLE = 0.01
"""Longest sleep, s: no command is left waiting for more."""

_MOST_WAITING = 1000
"""Commands that wait; what a page says beyond them is refused."""


class FlightThread:
    """Flies a session on the wall clock, and has it do what pages want.

    Args:
        session: what is flown; nobody else may call it.
        say: takes `frame`, `past`, `scene`, `state`, `refused`, `scores` and the session's own events; it is
            called in this thread.

    Attributes:
        paused: whether nothing is flown.
    """

    def __init__(self, session: Session, say: Say) -> None:
        self._session, self._say = session, say
        self.pacing = Pacing(session.live.period)
        session.say = self._happened
        self._name = secrets.token_hex(8)  # by which a page knows that another studio answers
        self._commands: queue.Queue[Any] = queue.Queue(_MOST_WAITING)
        self._stopped = self.paused = False
        self._state: dict[str, Any] = {}
        # Numbers of the state, of the last one in which the flight became another, and of the scene.
        self._version = self._turned = self._number = 0
        self._new_scene = self._stale = True
        self._past = self._next_event = math.inf
        self._acts: dict[type, Callable[[Any], object]] = {
            messages.Pause: lambda c: self._pause(c.paused),
            messages.Speed: lambda c: setattr(self.pacing, "speed", c.times),
            messages.Step: lambda _: self._step(),
            messages.Restart: lambda _: session.restart(),
            messages.Rewind: lambda c: session.rewind(
                c.time, [(one.key, one.value, one.flight, one.entry) for one in c.changes]
            ),
            messages.Undo: lambda _: session.undo(),
            messages.Redo: lambda _: session.redo(),
            messages.Jump: lambda c: session.jump(c.branch),
            messages.Set: lambda c: session.set_key(c.key, c.value, c.flight, c.entry),
            messages.Back: lambda c: session.back(c.to == "preset", c.key),
            messages.Recover: lambda _: session.recover(),
            messages.Poke: lambda c: session.poke(c.link, c.point, c.force),
            messages.Release: lambda _: session.release(),
            messages.Surface: lambda c: session.surface(
                c.position, c.tilt, c.friction, c.stiffness, c.present
            ),
            messages.Keep: lambda c: session.keep(c.name),
            messages.Draw: lambda c: (
                session.draw(c.strokes if c.svg is None else c.svg, c.name)
                if c.text is None
                else session.write(c.text, c.font)
            ),
            messages.Controllers: lambda c: self._set_controllers(c.names),
            messages.Scores: lambda _: say("scores", session.scores()),
        }

    def command(self, command: Any) -> bool:
        """Have a checked command obeyed soon; from any thread. False where too many wait already."""
        try:
            self._commands.put_nowait(command)
        except queue.Full:
            return False
        return True

    def stop(self) -> None:
        """End `run` soon; from any thread."""
        self._stopped = True

    def run(self, first: Callable[[], object] = lambda: None) -> None:
        """Fly until stopped; `first` is done once the scene is shown, before anything is flown."""
        self._show()
        first()
        gc.collect()
        gc.freeze()  # what has been loaded stays; looking through it again would hold ticks up
        next_frame = next_poll = time.perf_counter()
        while not self._stopped:
            acted, now = self._obey_all(), time.perf_counter()
            if now >= next_poll:
                self._session.poll()
                self._say("pace", {"late": self.pacing.late, "flown": self.pacing.flown})
                next_poll = now + POLL_PERIOD
            # What was done is seen at once. Of a take-off nothing is flown before: its past begins there.
            if acted or self._new_scene or now >= next_frame:
                self._show()
                next_frame = max(min(next_frame, now) + FRAME_PERIOD, now)
            resting = self.paused or self._session.live.over
            if not resting:
                self.pacing.fly(self._session.advance)
            wait = next_frame - time.perf_counter()
            time.sleep(max(0.0, min(IDLE, wait if resting else min(wait, self.pacing.wait))))

    def _show(self) -> None:
        live = self._session.live
        self._stale |= live.time >= self._next_event or live.over != self._state.get("over")
        if self._new_scene:
            self._show_scene()
        elif self._stale:
            self._say("state", self._state_now())
        if self._past < math.inf:
            since, self._past = round(self._past / live.period), math.inf
            self._say("past", live.frames(since, PAST_PERIOD))
        self._say("frame", live.frame(self.pacing.reached, self.paused))

    def _state_now(self) -> dict[str, Any]:
        """The state that flies, under a number of its own."""
        mode = {"paused": self.paused, "speed": self.pacing.speed, "scene": self._number}
        self._stale, self._next_event = False, next_event(self._session)
        state = {**mode, **live_state(self._session)}
        if state != {key: value for key, value in self._state.items() if key != "version"}:
            self._version += 1
        self._state = {**state, "version": self._version}
        return self._state

    def _happened(self, event: str, content: Any) -> None:
        """Say what happens to the flights; of new scenes only the last is shown, with the next frame."""
        if event == "scene":
            self._new_scene = True
        elif event == "moved":
            self._past = min(self._past, content["since"])
            self.pacing.restart()
        else:
            self._say(event, content)
        if event in ("scene", "moved"):
            self._turned, self._stale = self._version + 1, True

    def _show_scene(self) -> None:
        session, self._new_scene = self._session, False
        gc.collect()  # the flights before are rings of objects, large ones, that would stay for long
        self._number += 1
        scene = {
            "number": self._number,
            "studio": self._name,
            "scene": session.live.scene(),
            "controls": session.controls(),
            "controllers": list(session.offered),
        }
        self._say("scene", {"hello": scene, "state": self._state_now()})
        before = self.pacing
        self.pacing = Pacing(session.live.period)  # its period may be another, and its schedule begins here
        self.pacing.speed, self.pacing.late, self.pacing.flown = before.speed, before.late, before.flown

    def _obey_all(self) -> bool:
        """Obey all that waits; of several pokes in a row only the last, as each of them is a branch.

        Returns:
            Whether anything waited.
        """
        waiting = []
        while not self._commands.empty():
            waiting.append(self._commands.get_nowait())
        for k, command in enumerate(waiting):
            following = waiting[k + 1 : k + 2]
            if following and isinstance(command, messages.Poke) and isinstance(following[0], messages.Poke):
                continue
            self._stale = True
            try:
                self._check(command)
                self._acts[type(command)](command)
            except SkylimbError as error:
                self._say("refused", {"text": " ".join(str(error).split())})
        return bool(waiting)

    def _check(self, command: Any) -> None:
        """Refuse what was meant for a flight that has become another meanwhile."""
        if isinstance(command, messages.OF_A_STATE) and (command.seen or self._turned) < self._turned:
            raise ConfigError("the flight has just become another; look again")

    def _pause(self, paused: bool) -> None:
        self.paused = paused
        self.pacing.restart()

    def _step(self) -> None:
        if not self.paused:
            raise ConfigError("a flight is flown tick by tick while it is paused")
        self._session.advance(1)

    def _set_controllers(self, names: list[str]) -> None:
        for name in names:
            if name not in self._session.offered:
                raise choice_error("controller", name, list(self._session.offered))
        self._session.set_controllers(names)
