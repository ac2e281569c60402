"""The push of whoever pokes: one at a time, held until it is changed or released."""

from __future__ import annotations

from collections.abc import Sequence

from skylimb.apps.studio.changes import with_events, without_push
from skylimb.apps.studio.live_flights import LiveFlights
from skylimb.base.errors import ConfigError
from skylimb.flight.events import Push


class HeldPush:
    """Pushes the robots of a live; what it holds lasts to the flights' end unless it lets go."""

    def __init__(self) -> None:
        self._held: list[tuple[float, Push | None]] = [(0.0, None)]

    def push(self, live: LiveFlights, link: str, point: Sequence[float], force: Sequence[float]) -> None:
        """Push with a force (N, W) at a point (m) of a link, in its axes, in place of what is held."""
        if not any(force):
            self.release(live)
            return
        time, held = live.time, self._held[-1][1]
        push = Push(
            time=time,
            duration=round(max(live.end - time, live.period), 9),
            force=_vector(force, "force"),
            link=link,
            point=_vector(point, "point"),
        )
        live.branch(
            {
                one: with_events(without_push(one.experiment, held, time) if held else one.experiment, push)
                for one in live.flights
                if not one.over
            }
        )
        self._held.append((time, push))

    def release(self, live: LiveFlights) -> None:
        """Take the pushing force off."""
        held = self._held[-1][1]
        if held is None:
            return
        time = live.time
        live.branch({one: without_push(one.experiment, held, time) for one in live.flights if not one.over})
        self._held.append((time, None))

    def rewound(self, live: LiveFlights) -> None:
        """The live was set back: let go of what was held at that time."""
        time = live.time
        self._held = [entry for entry in self._held if entry[0] <= time + 1e-9] or [(0.0, None)]
        self.release(live)


def _vector(numbers: Sequence[float], what: str) -> tuple[float, float, float]:
    if len(numbers) != 3:
        raise ConfigError(f"{what} has {len(numbers)} numbers; it takes three")
    x, y, z = map(float, numbers)
    return x, y, z
