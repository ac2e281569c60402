"""The strip charts of a live flight: which there are, and what each curve is worth at a moment."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from skylimb.analysis.scores.signals import Direction, behind, toward_axis
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.base.signal_table import SIGNALS
from skylimb.base.signals import Signal
from skylimb.control.contact.machine import STATES
from skylimb.control.controller import controller_signals


class Moment(NamedTuple):
    """What the curves are made from.

    Attributes:
        signals: of the last tick, by their names in the log.
        force: contact force on the robot, smoothed, W, N.
        estimate: the external force as the controller knows it, smoothed, W, N; NaN without one.
    """

    signals: dict[str, np.ndarray]
    force: np.ndarray
    estimate: np.ndarray

    def apart(self, name: str, axis: np.ndarray) -> float:
        """How far something is from its reference along an axis, mm."""
        off = self.signals[f"{name}_position"] - self.signals[f"{name}_position_reference"]
        return 1e3 * float(off @ axis)


class Curve(NamedTuple):
    """A curve: how it is called, what it is (truth, estimate, reference, command or limit), its value."""

    label: str
    role: str
    value: Callable[[Moment], float]


class Panel(NamedTuple):
    """Curves over one axis, with its title and unit; `names` are those of whole numbers on the axis."""

    title: str
    unit: str
    curves: list[Curve]
    names: tuple[str, ...] = ()

    def described(self, column: int) -> dict[str, Any]:
        """The panel as a page takes it; its curves stand in the columns from `column` on."""
        rows = [
            {"label": curve.label, "role": curve.role, "seen": "both", "column": column + k}
            for k, curve in enumerate(self.curves)
        ]
        return {"title": self.title, "unit": self.unit, "curves": rows, "names": self.names}


def panels_of(flight: LiveFlight, axes: Sequence[Direction]) -> list[Panel]:
    """The panels of a flight, the task first.

    Args:
        flight: that is shown.
        axes: the directions of errors; the last one is that of the contact.
    """
    slices = flight.slices
    along = [
        Curve(f"along {axis}", "truth", lambda m, a=axis.vector: m.apart("tip", a)) for axis in axes[:-1]
    ]
    errors = [Curve(f"along {axis}", "truth", lambda m, a=axis.vector: m.apart("cog", a)) for axis in axes]
    toward = _contact_axis(flight, axes)
    force = [Curve("true", "truth", lambda m: -float(m.force @ toward(m)))]
    if "external_force_estimate" in slices:
        force.append(Curve("felt", "estimate", lambda m: -float(m.estimate @ toward(m))))
    for name in ("contact_force_target", "contact_force_reference"):
        if name in slices:
            force.append(Curve("wanted", "reference", _entry(name)))
            break
    contact = Panel(
        "Contact", "", [Curve("touching", "truth", _entry("contact_duty"))], ("in the air", "touching")
    )
    if "contact_state" in slices:
        contact = Panel("Contact state", "", [Curve("state", "truth", _entry("contact_state"))], STATES)
    return [
        Panel("Pen to path", "mm", along),
        Panel("Pressing force", "N", force),
        contact,
        Panel("Attitude", "deg", list(_attitude(flight))),
        Panel("Thrust", "N", list(_thrusts(flight))),
        Panel("Body to reference", "mm", errors),
        *_angles(flight),
    ]


def _contact_axis(flight: LiveFlight, axes: Sequence[Direction]) -> Callable[[Moment], np.ndarray]:
    """The contact axis of a moment, W: around a post it turns with the path."""
    experiment, (_, upright, contact) = flight.takeoff.experiment, (axis.vector for axis in axes)
    if experiment.wrap.radius is None:
        return lambda m: contact
    axis = behind(experiment.path_center, experiment.wrap.radius, contact)
    return lambda m: toward_axis(m.signals["tip_position_reference"], axis, upright)


def described_signals(flight: LiveFlight, implied: Mapping[str, np.ndarray]) -> list[dict[str, Any]]:
    """All signals of a flight, recorded and implied ones, under the names of the log.

    Returns:
        For each: `name`, `unit`, `meaning`, `labels` of its entries, and the `column` of the first one.
    """
    controller, description = flight.takeoff.controller, flight.takeoff.robot.description
    declared = controller_signals(controller)
    entries = {
        "axis": "xyz",
        "quaternion": "wxyz",
        "rotor": [rotor.name for rotor in description.rotors],
        "joint": description.shape_joints,
        "vectoring": description.vectoring_joints,
    }
    found, column = [], 0
    recorded = {name: part.stop - part.start for name, part in flight.slices.items()}
    for name, width in {**recorded, **{name: len(values) for name, values in implied.items()}}.items():
        known, own = SIGNALS.get(name), declared.get(name, Signal())
        unit, meaning = (known.units, known.long_name) if known else (own.unit, own.meaning)
        labels = list(entries.get(known.dims[0], ())) if known and known.dims else []
        labels = labels if len(labels) == width else [str(k + 1) for k in range(width)]
        found.append(
            {
                "name": name,
                "unit": unit,
                "meaning": meaning,
                "labels": labels if width > 1 else [""],
                "column": column,
            }
        )
        column += width
    return found


def _attitude(flight: LiveFlight) -> Iterator[Curve]:
    """Roll and pitch with where they are to be, and how far yaw is from there: it may be anything."""
    known, wanted = "attitude_estimate", "attitude_target"
    if known not in flight.slices:
        return
    for i, name in enumerate(("roll", "pitch")):
        yield Curve(name, "truth", lambda m, i=i: math.degrees(m.signals[known][i]))
        if wanted in flight.slices:
            yield Curve(f"{name} command", "command", lambda m, i=i: math.degrees(m.signals[wanted][i]))
    if wanted in flight.slices:
        turn = 2.0 * math.pi
        yield Curve(
            "yaw from its command",
            "truth",
            lambda m: math.degrees(math.remainder(m.signals[known][2] - m.signals[wanted][2], turn)),
        )


def _angles(flight: LiveFlight) -> Iterator[Panel]:
    """Angles of the arm's joints and of the rotors, where the robot has such."""
    plant, description = flight.takeoff.plant, flight.takeoff.robot.description
    for title, kind, names, place in (
        ("Joint angles", "joint", description.shape_joints, plant.joint_qpos),
        ("Vectoring angles", "vectoring", description.vectoring_joints, plant.vectoring_qpos),
    ):
        angles = []
        for i, (name, at) in enumerate(zip(names, place, strict=True)):
            angles.append(Curve(name, "truth", lambda m, at=at: float(m.signals["configuration"][at])))
            angles.append(Curve(f"{name} command", "command", _entry(f"{kind}_angles_command", i)))
        if angles:
            yield Panel(title, "rad", angles)


def _thrusts(flight: LiveFlight) -> Iterator[Curve]:
    robot = flight.takeoff.robot
    low, high = robot.thrust_limits()
    for i, rotor in enumerate(robot.description.rotors):
        yield Curve(rotor.name, "truth", _entry("thrusts", i))
    yield Curve("smallest", "limit", lambda m: float(np.min(low)))
    yield Curve("largest", "limit", lambda m: float(np.max(high)))


def _entry(name: str, index: int = 0) -> Callable[[Moment], float]:
    return lambda m: float(m.signals[name][index])
