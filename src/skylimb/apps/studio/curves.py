"""The strip charts of a live flight: which there are, and what each curve is worth at a moment."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from skylimb.analysis.scores.signals import Direction
from skylimb.apps.studio.live_flight import LiveFlight


class Moment(NamedTuple):
    """What the curves are made from.

    Attributes:
        signals: of the last tick, by name.
        force: contact force on the robot, smoothed, W, N.
        estimate: the external force as the controller knows it, smoothed, W, N; NaN without one.
        cog: true centre of gravity, W, m.
        reference: position of the centre of gravity that the mission asks for, W, m.
    """

    signals: dict[str, np.ndarray]
    force: np.ndarray
    estimate: np.ndarray
    cog: np.ndarray
    reference: np.ndarray


class Curve(NamedTuple):
    """A curve: how it is called, what it is (truth, estimate, reference, command or limit), its value."""

    label: str
    role: str
    value: Callable[[Moment], float]


class Panel(NamedTuple):
    """Curves over one axis, with its title and unit."""

    title: str
    unit: str
    curves: list[Curve]

    def described(self, column: int) -> dict[str, Any]:
        """The panel as a page takes it; its curves stand in the columns from `column` on."""
        rows = [
            {"label": curve.label, "role": curve.role, "seen": "both", "column": column + k}
            for k, curve in enumerate(self.curves)
        ]
        return {"title": self.title, "unit": self.unit, "curves": rows}


def panels_of(flight: LiveFlight, axes: Sequence[Direction]) -> list[Panel]:
    """The panels of a flight.

    Args:
        flight: that is shown.
        axes: the directions of errors; the last one is that of the contact.
    """
    slices = flight.slices
    errors = [
        Curve(f"along {axis}", "truth", lambda m, a=axis.vector: float((m.cog - m.reference) @ a))
        for axis in axes
    ]
    toward = axes[-1].vector
    force = [Curve("truth", "truth", lambda m: -float(m.force @ toward))]
    if "external_force_estimate" in slices:
        force.append(Curve("estimate", "estimate", lambda m: -float(m.estimate @ toward)))
    for name in ("contact_force_target", "contact_force_reference"):
        if name in slices:
            force.append(Curve("reference", "reference", _entry(name)))
            break
    contact = [Curve("touching", "truth", _entry("contact_duty"))]
    if "contact_state" in slices:
        contact.append(Curve("state", "estimate", _entry("contact_state")))
    return [
        Panel("Position error", "m", errors),
        Panel("Pressing force", "N", force),
        Panel("Thrust", "N", list(_thrusts(flight))),
        *_angles(flight),
        Panel("Contact", "", contact),
    ]


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
