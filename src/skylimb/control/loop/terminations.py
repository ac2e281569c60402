"""When a flight counts as lost: small functions with limits that the experiment states.

Each function sees a stretch of a flight and says for every tick whether the flight is lost there. The first
tick at which any of them says so ends the flight, and its words are the flight's cause.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Annotated, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.packing import Layout
from skylimb.control.loop.flight import CONFIGURATION, Flight, mission_ticks
from skylimb.control.missions.mission import Mission


@configuration
class Terminations:
    """Limits beyond which a flight is lost. A flight whose numbers are not finite is always lost."""

    tilt: Annotated[
        float, Key("rad", "tilt of the measured link against the vertical", low=0.05, high=3.15)
    ] = 1.0
    distance: Annotated[
        float, Key("m", "distance of the measured link from the reference position", low=0.01, high=1000.0)
    ] = 2.0
    height: Annotated[
        float,
        Key(
            "m",
            "height of the measured link; below it the robot has hit the floor",
            low=-1000.0,
            high=100.0,
        ),
    ] = 0.05


class Stretch(NamedTuple):
    """What terminations look at: some ticks of a flight.

    Attributes:
        position: of the measured link, W, m, (k, 3).
        quaternion: its attitude, (k, 4).
        reference: position that the mission asks for, W, m, (k, 3).
        finite: whether every watched number of the tick is finite, (k,).
    """

    position: np.ndarray
    quaternion: np.ndarray
    reference: np.ndarray
    finite: np.ndarray


def not_finite(seen: Stretch, limits: Terminations) -> tuple[np.ndarray, str]:
    """A watched number is NaN or infinite."""
    return ~seen.finite, "diverged"


def tilt(seen: Stretch, limits: Terminations) -> tuple[np.ndarray, str]:
    """The measured link tilts too far."""
    x, y = seen.quaternion[:, 1], seen.quaternion[:, 2]
    angle = np.arccos(np.clip(1.0 - 2.0 * (x**2 + y**2), -1.0, 1.0))
    return angle > limits.tilt, f"lost attitude: tilt above {limits.tilt:g} rad"


def distance(seen: Stretch, limits: Terminations) -> tuple[np.ndarray, str]:
    """The measured link is too far from the reference."""
    away = np.linalg.norm(seen.position - seen.reference, axis=1)
    return away > limits.distance, f"lost position: more than {limits.distance:g} m from the reference"


def height(seen: Stretch, limits: Terminations) -> tuple[np.ndarray, str]:
    """The measured link is on the floor."""
    return seen.position[:, 2] < limits.height, f"hit the floor: below {limits.height:g} m"


TERMINATIONS: tuple[Callable[[Stretch, Terminations], tuple[np.ndarray, str]], ...] = (
    not_finite,
    tilt,
    distance,
    height,
)
"""In the order in which they are named when several hold at one tick."""


def find_loss(
    flight: Flight, mission: Mission, limits: Terminations, first: int = 0
) -> tuple[int, str] | None:
    """The first tick from `first` on at which a flight is lost, and why; None while it is not.

    Args:
        flight: as far as it has come.
        mission: what was to be flown.
        limits: of the experiment.
        first: where to begin.
    """
    seen = _stretch(flight, mission, first)
    with np.errstate(invalid="ignore"):
        checks = [termination(seen, limits) for termination in TERMINATIONS]
    found = [(int(np.argmax(lost)), cause) for lost, cause in checks if lost.any()]
    if not found:
        return None
    index, cause = min(found, key=lambda item: item[0])
    tick = first + index
    if not seen.finite[index]:
        watched = ", ".join(_not_finite(flight, tick, watched=True))
        cause = f"{cause}: {watched} not finite"
    others = _not_finite(flight, tick, watched=False)
    said = [
        f"; {name} not finite since t = {start * mission.period:.3f} s (tick {start})"
        for name, start in others.items()
    ]
    return tick, f"{cause} at t = {tick * mission.period:.3f} s{''.join(said[:3])}"


def _not_finite(flight: Flight, tick: int, watched: bool) -> dict[str, int]:
    """Signals that are no finite numbers at a tick, watched ones or others, and since which tick.

    The earliest comes first; of several those that a law records itself, which stand last in the layout.
    """
    found: dict[str, int] = {}
    for name, part in reversed(flight.layout.slices.items()):
        finite = np.asarray(np.isfinite(flight.signals[: tick + 1, part]).all(axis=1))
        if not finite[tick] and (name in _WATCHED) == watched and name not in _OFTEN_NAN:
            found[name] = tick - int(np.argmax(finite[::-1])) + 1 if finite.any() else 0
    return dict(sorted(found.items(), key=lambda item: item[1]))


def _stretch(flight: Flight, mission: Mission, first: int) -> Stretch:
    layout, rows = flight.layout, flight.signals[first : flight.ticks]
    reference = mission.reference.position[mission_ticks(mission, flight, first).astype(int)]
    if flight.has(CONFIGURATION):
        pose = rows[:, layout.slices[CONFIGURATION]]
        position, quaternion = pose[:, 0:3], pose[:, 3:7]
    else:
        position = rows[:, layout.slices["root_position_measured"]]
        quaternion = rows[:, layout.slices["root_quaternion_measured"]]
    finite = np.all(np.isfinite(rows[:, watched_columns(layout)]), axis=1)
    return Stretch(position, quaternion, reference, np.asarray(finite))


_WATCHED = (
    CONFIGURATION,
    "configuration_velocity",
    "root_position_measured",
    "root_quaternion_measured",
    "thrusts_command",
    "joint_angles_command",
    "contact_force",
)


_OFTEN_NAN = ("contact_point",)
"""Signals that are no number while there is no contact."""


@functools.lru_cache(maxsize=16)
def watched_columns(layout: Layout[dict[str, object]]) -> np.ndarray:
    """Columns of a log that must be finite; a user's controller may leave its own signals open.

    What a sensor says may be no number where the truth is known.
    """
    seen = [name for name in _WATCHED if name in layout.slices]
    names = [name for name in seen if CONFIGURATION not in seen or not name.endswith("_measured")]
    return np.concatenate([np.arange(layout.size)[layout.slices[name]] for name in names])
