"""What every reader of a log needs: phases, axes, events, and stretches of time in which something holds."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from skylimb.base.errors import unknown_name

if TYPE_CHECKING:
    import xarray as xr

ADAPTATION_THRESHOLD = 0.005
"""The arm counts as adapting while its commanded reach is more than this (m) away from its reference."""


def phase_names(log: xr.Dataset) -> dict[str, int]:
    """The phases that the log knows, with the number each has in the signal `phase`."""
    return flag_names(log, "phase")


def flag_names(log: xr.Dataset, signal: str) -> dict[str, int]:
    """The names that a signal counts, with the number of each; none where the log lacks it."""
    if signal not in log:
        return {}
    attributes = log.variables[signal].attrs
    values = np.atleast_1d(attributes.get("flag_values", []))
    return dict(
        zip(str(attributes.get("flag_meanings", "")).split(), (int(value) for value in values), strict=True)
    )


def in_phase(log: xr.Dataset, name: str) -> np.ndarray:
    """At which samples the flight was in the phase `name`: booleans, shape (time,).

    A log without phases is never in any.

    Raises:
        UnknownNameError: if the log has phases, but none of that name.
    """
    known = phase_names(log)
    if not known:
        return np.zeros(log.sizes["time"], dtype=bool)
    if name not in known:
        raise unknown_name("phase", name, known)
    return np.asarray(log.variables["phase"].values == known[name])


class NoNumberError(Exception):
    """What a score is made of is not in a log, so that the flight has no number there."""


def recorded(log: xr.Dataset, signal: str) -> np.ndarray:
    """The samples of a signal, (time, ...).

    Raises:
        NoNumberError: where the log lacks it.
    """
    if signal not in log:
        raise NoNumberError(signal)
    return log.variables[signal].values


def while_sliding(log: xr.Dataset, signal: str) -> np.ndarray:
    """The samples of a signal over the sliding period, (k, ...).

    Raises:
        NoNumberError: where the log lacks it.
    """
    return recorded(log, signal)[np.flatnonzero(in_phase(log, "slide"))]


class Direction(NamedTuple):
    """A direction of the task: how it is called in a figure, and the unit vector in W, shape (3,)."""

    name: str
    vector: np.ndarray

    def along(self, values: Any) -> np.ndarray:
        """The part of vectors in W, shape (..., 3), along the direction."""
        return np.asarray(values) @ self.vector

    def __str__(self) -> str:
        return self.name


def contact_axis(log: xr.Dataset) -> Direction:
    """The direction in which the robot pushes; x where the log doesn't say.

    The attribute `contact_axis` holds a letter or the three components of a vector in W.
    """
    return direction(log.attrs.get("contact_axis", "x"), "n")


def off_mission(log: xr.Dataset, axis: Direction) -> np.ndarray:
    """How far the centre of gravity is from the mission's reference along a direction, m, (time,)."""
    return axis.along(log.cog_position.values - log.cog_position_reference.values)


def sliding_axes(log: xr.Dataset) -> tuple[Direction, Direction]:
    """The two directions in which the tip slides; y and z where the log doesn't say.

    The attribute `sliding_axes` holds two letters or the components of one vector and then of the other.
    """
    axes = log.attrs.get("sliding_axes", ("y", "z"))
    if isinstance(axes, str):
        axes = axes.replace(",", " ").split()
    first, second = np.reshape(axes, (2, -1)).tolist()
    return direction(first, "u"), direction(second, "v")


def post_axis(log: xr.Dataset) -> np.ndarray | None:
    """A point of the upright axis that the path is bent around, W, m, (3,); None where it is flat."""
    if "wrap_radius" not in log.attrs:
        return None
    middle = json.loads(log.attrs["path_center"])
    return behind(middle, float(log.attrs["wrap_radius"]), contact_axis(log).vector)


def behind(middle: Sequence[float] | np.ndarray, radius: float, contact: np.ndarray) -> np.ndarray:
    """The point of a post's axis behind the middle of the path on it, W, m, (3,)."""
    return np.asarray(middle) + radius * contact


def toward_axis(places: np.ndarray, axis: np.ndarray, upright: np.ndarray) -> np.ndarray:
    """Unit vectors straight from places (..., 3) to the line through the point `axis` along `upright`."""
    away = axis - places
    level = away - (away @ upright)[..., None] * upright
    return level / np.linalg.norm(level, axis=-1, keepdims=True)


def along_contact(log: xr.Dataset, vectors: np.ndarray) -> np.ndarray:
    """The part of vectors in W, (time, 3), along the contact axis of the moment.

    Around a post it turns with the path, elsewhere it stays.
    """
    axis = post_axis(log)
    if axis is None or "tip_position_reference" not in log:
        return contact_axis(log).along(vectors)
    toward = toward_axis(log.tip_position_reference.values, axis, sliding_axes(log)[1].vector)
    return np.sum(vectors * toward, axis=-1)


def direction(axis: Any, otherwise: str) -> Direction:
    """A direction from a letter or a vector; one that is no axis of W is called `otherwise`."""
    entries = np.ravel(axis).tolist()
    letters = ("x", "y", "z")
    if len(entries) == 1 and entries[0] in letters:
        return Direction(str(entries[0]), np.eye(3)[letters.index(entries[0])])
    vector = np.array(entries, dtype=float)
    along = int(np.argmax(np.abs(vector)))
    if abs(vector[along]) < 1.0 - 1e-9:
        return Direction(otherwise, vector)
    return Direction(letters[along] if vector[along] > 0.0 else f"-{letters[along]}", vector)


def in_contact(log: xr.Dataset) -> np.ndarray:
    """At which samples the tip touched: booleans, shape (time,)."""
    if "contact" not in log:
        return np.zeros(log.sizes["time"], dtype=bool)
    return log.contact.values > 0


class Transition(NamedTuple):
    """A change of the contact's state: when (s), from which state, to which, and why."""

    time: float
    before: str
    after: str
    reason: str


def contact_transitions(log: xr.Dataset) -> list[Transition]:
    """Every change of the contact's state that the controller made; none where it keeps no such state."""
    return [Transition(*entry) for entry in json.loads(log.attrs.get("contact_transitions", "[]"))]


class HappenedEvent(NamedTuple):
    """Something that happened to a flight besides what its mission asked: a push, a gain that changed, ...

    Attributes:
        kind: as `[[events]]` of an experiment name it.
        time: at which it began, s.
        duration: how long it took or was to last, s.
        words: what it was.
        table: all its keys with their values.
    """

    kind: str
    time: float
    duration: float
    words: str
    table: dict[str, Any]


def events_of(log: xr.Dataset) -> list[HappenedEvent]:
    """What happened to a flight, in the order of time; not what it did not live to see."""
    tables = json.loads(log.attrs.get("events", "[]"))
    found = [
        HappenedEvent(each["kind"], each["time"], each["duration"], each["words"], each) for each in tables
    ]
    return sorted((each for each in found if each.time <= log.time.values[-1]), key=lambda each: each.time)


def common_events(logs: Iterable[xr.Dataset]) -> list[HappenedEvent] | None:
    """What happened to all of some flights, as long as each lasted; None where it was not the same."""
    lists = [events_of(log) for log in logs]
    longest = max(lists, key=len, default=[])
    return longest if all(one == longest[: len(one)] for one in lists) else None


def adapting(log: xr.Dataset) -> np.ndarray:
    """At which samples the arm gave way: booleans, shape (time,).

    It does where its commanded reach is away from its reference.
    """
    if not {"reach_command", "reach_reference"} <= set(log.variables):
        return np.zeros(log.sizes["time"], dtype=bool)
    return np.abs(log.reach_command.values - log.reach_reference.values) > ADAPTATION_THRESHOLD


def spans(time: np.ndarray, mask: np.ndarray, bridge: float = 0.0) -> list[tuple[float, float]]:
    """The stretches of time in which `mask` holds, as (begin, end) in s.

    Args:
        time: shape (n,), s.
        mask: booleans, shape (n,).
        bridge: gaps up to this long (s) don't interrupt a stretch: a bouncing pen is still drawing.
    """
    found: list[tuple[float, float]] = []
    for begin, end in stretches(mask):
        joined = bool(found) and time[begin] - found[-1][1] <= bridge
        first = found.pop()[0] if joined else float(time[begin])
        found.append((first, float(time[end - 1])))
    return found


def stretches(mask: np.ndarray) -> list[tuple[int, int]]:
    """Begin and end (past the last) of every stretch of samples in which the mask, (n,), holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def moving_mean(time: np.ndarray, values: np.ndarray, window: float) -> np.ndarray:
    """Means over every stretch of `window` seconds that lies wholly inside the samples.

    Args:
        time: evenly spaced times (s), shape (n,).
        values: shape (n,).
        window: seconds; rounded to whole samples, and at least one sample.

    Returns:
        Shape (n - k + 1,) for a window of k samples.
    """
    step = (time[-1] - time[0]) / (len(time) - 1) if len(time) > 1 else window
    count = int(np.clip(round(window / step), 1, len(values)))
    total = np.cumsum(np.concatenate([[0.0], values]))
    return (total[count:] - total[:-count]) / count


def held_means(time: np.ndarray, values: np.ndarray, held: np.ndarray, window: float) -> np.ndarray:
    """The means of `moving_mean` over every stretch in which something is held, (k,): none goes over a gap.

    Args:
        time: evenly spaced times (s), shape (n,).
        values: shape (n,).
        held: booleans, shape (n,), of which some are true.
        window: seconds; a shorter stretch has one mean, over all of it.
    """
    parts = [moving_mean(time[a:b], values[a:b], window) for a, b in stretches(held)]
    return np.concatenate(parts)


def at_ticks(log: xr.Dataset, other: xr.Dataset) -> xr.Dataset:
    """The last sample of a log at each tick of another, whose clock is 0 at the first sample."""
    begin = log.time.values[0]
    return log.isel(time=np.searchsorted(log.time.values, other.time.values + begin + 1e-9, side="right") - 1)


def spacing(time: np.ndarray) -> float:
    """The time between two samples, s, of times (n,), n > 1, that may have gaps."""
    return float(np.median(np.diff(time)))


def samples_within(time: np.ndarray, window: float) -> int:
    """How many samples of evenly spaced times (s), shape (n,), a window (s) holds; at least one."""
    return max(1, round(window / spacing(time))) if len(time) > 1 else 1


def around(values: np.ndarray, count: int) -> np.ndarray:
    """The `count` samples around each, shape (n, ..., count); beyond the ends the last sample goes on."""
    room = [(count // 2, count - 1 - count // 2)] + [(0, 0)] * (values.ndim - 1)
    return np.lib.stride_tricks.sliding_window_view(np.pad(values, room, mode="edge"), count, axis=0)


def surface_of(log: xr.Dataset) -> dict[str, Any] | None:
    """The surface's description, or None where the log has none.

    It holds kind, origin (m), axis_u, axis_v, normal (unit vectors in W) and the surface's own parameters.
    """
    text = log.attrs.get("surface", "")
    surface = json.loads(text) if text else None
    if not surface or not {"origin", "axis_u", "axis_v", "normal"} <= set(surface):
        return None
    return surface
