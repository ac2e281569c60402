"""The thread that flies: it alone calls the session. It obeys commands and says what a page has to show."""

from __future__ import annotations

import gc
import queue
import time
from collections.abc import Callable, Sequence
from typing import Any

from skylimb.apps.studio import messages
from skylimb.apps.studio.pacing import Pacing
from skylimb.apps.studio.session import Say, Session
from skylimb.base.errors import SkylimbError, choice_error

FRAME_PERIOD = 0.02
"""Seconds between two frames that are made; a page gets as many of them as it can show."""

POLL_PERIOD = 0.4
"""Seconds between two looks at the user's files, and two reports of how many ticks were late."""

IDLE = 0.01
"""Longest sleep, s: no command is left waiting for more."""

_MOST_WAITING = 1000
"""Commands that wait; what a page says beyond them is refused."""


class FlightThread:
    """Flies a session on the wall clock, and has it do what pages want.

    Args:
        session: what is flown; nobody else may call it.
        say: takes `frame`, `scene`, `state`, `gain`, `refused`, `scores` and the session's own events; it is
            called in this thread.
        controllers: the names that a page may choose.

    Attributes:
        paused: whether nothing is flown.
    """

    def __init__(self, session: Session, say: Say, controllers: Sequence[str]) -> None:
        self._session, self._say, self._controllers = session, say, list(controllers)
        self.pacing = Pacing(session.live.period)
        session.say = self._happened
        self._commands: queue.Queue[Any] = queue.Queue(_MOST_WAITING)
        self._stopped = self.paused = self._new_scene = False
        self._state: dict[str, Any] = {}
        self._acts: dict[type, Callable[[Any], object]] = {
            messages.Pause: lambda c: self._pause(c.paused),
            messages.Speed: lambda c: setattr(self.pacing, "speed", c.times),
            messages.Restart: lambda _: session.restart(),
            messages.Rewind: lambda c: self._rewind(c.seconds),
            messages.Gain: lambda c: self._set_key(c.key, c.value, c.flight),
            messages.SetKey: lambda c: self._set_key(c.key, c.value),
            messages.Poke: lambda c: session.poke(c.link, c.point, c.force),
            messages.Release: lambda _: session.release(),
            messages.Surface: lambda c: session.surface(
                c.position, c.tilt, c.friction, c.stiffness, c.present
            ),
            messages.Keep: lambda c: session.keep(c.name),
            messages.Draw: lambda c: session.draw(c.strokes if c.svg is None else c.svg),
            messages.Controllers: lambda c: self._set_controllers(c.names),
            messages.Scores: lambda _: say("scores", session.live.scores()),
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

    def run(self) -> None:
        """Fly until stopped."""
        self._show_scene()
        gc.collect()
        gc.freeze()  # what has been loaded stays; looking through it again would hold ticks up
        next_frame = next_poll = time.perf_counter()
        while not self._stopped:
            self._obey_all()
            resting = self.paused or self._session.live.over
            if not resting:
                self.pacing.fly(self._session.advance)
            now = time.perf_counter()
            if now >= next_frame:
                self._show()
                next_frame = max(next_frame + FRAME_PERIOD, now)
            if now >= next_poll:
                self._session.poll()
                self._say("pace", {"late": self.pacing.late, "flown": self.pacing.flown})
                next_poll = now + POLL_PERIOD
            wait = next_frame - time.perf_counter()
            time.sleep(max(0.0, min(IDLE, wait if resting else min(wait, self.pacing.wait))))

    def _show(self) -> None:
        session = self._session
        if self._new_scene:
            self._show_scene()
        self._say("frame", session.live.frame(self.pacing.reached, self.paused))
        state = {"paused": self.paused, "over": session.live.over, "speed": self.pacing.speed}
        if session.live.over:
            state["verdict"] = session.live.verdict
        if state != self._state:
            self._state = state
            self._say("state", state)

    def _happened(self, event: str, content: Any) -> None:
        """Say what happens to the flights; of new scenes only the last is shown, with the next frame."""
        if event == "scene":
            self._new_scene = True
        else:
            self._say(event, content)

    def _show_scene(self) -> None:
        session, self._new_scene = self._session, False
        gc.collect()  # the flights before are rings of objects, large ones, that would stay for long
        before = self.pacing
        self.pacing = Pacing(session.live.period)  # the period is among what may have changed
        self.pacing.speed, self.pacing.late, self.pacing.flown = before.speed, before.late, before.flown
        scene, controls = session.live.scene(), session.live.controls()
        self._say("scene", {"scene": scene, "controls": controls, "controllers": self._controllers})

    def _obey_all(self) -> None:
        """Obey all that waits; of several pokes in a row only the last, as each of them is a branch."""
        waiting = []
        while not self._commands.empty():
            waiting.append(self._commands.get_nowait())
        for k, command in enumerate(waiting):
            following = waiting[k + 1 : k + 2]
            if following and isinstance(command, messages.Poke) and isinstance(following[0], messages.Poke):
                continue
            try:
                self._acts[type(command)](command)
            except SkylimbError as error:
                self._say("refused", {"text": " ".join(str(error).split())})
                self._tell_again(command)

    def _pause(self, paused: bool) -> None:
        self.paused = paused
        self.pacing.restart()

    def _rewind(self, seconds: float) -> None:
        self._session.rewind(seconds)
        self.pacing.restart()

    def _set_key(self, key: str, value: Any, flight: int | None = None) -> None:
        self._session.set_key(key, value, flight)
        self._say("gain", {"key": key, "value": value, "flight": flight})

    def _set_controllers(self, names: list[str]) -> None:
        for name in names:
            if name not in self._controllers:
                raise choice_error("controller", name, self._controllers)
        self._session.set_controllers(names)

    def _tell_again(self, command: Any) -> None:
        """What a key is, after a change of it was refused."""
        if isinstance(command, messages.Gain | messages.SetKey) and command.key in self._session.live.known:
            now = {control["key"]: control["value"] for control in self._session.live.controls()}
            self._say("gain", {"key": command.key, "value": now.get(command.key), "flight": None})
