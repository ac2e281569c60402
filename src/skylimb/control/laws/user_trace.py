"""Whether a user's controller can be compiled: its step is tried on symbols, and held against numbers."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from skylimb.base.packing import Layout, with_floats
from skylimb.base.user_code import described
from skylimb.control.estimation.records import Imu, Measurement
from skylimb.control.laws.traced_step import TracedStep, traced_step
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.needs import PACE, Needs
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.records import Command
from skylimb.robots.model import Robot

STEPS = 4
"""Ticks over which both ways are compared."""

PERIOD = 0.005
"""Control period of the trial, s."""

_PLAIN = (int, float, str, list, dict, tuple, set, deque, np.ndarray, type(None))

TOLERANCE = 1e-7
"""Relative difference of numbers that are the same but for the order of operations."""


def untraceable(make: Callable[[], Any]) -> str:
    """Why a user's controller cannot be compiled, in a sentence; empty where it can.

    The traced step has to give the numbers of the Python step over some ticks. So a step that keeps something
    outside of its state, draws random numbers or asks a clock flies in Python.

    Args:
        make: makes a `CompiledUserController` like the one that will fly; the trial spoils it.
    """
    try:
        trial = make()
        before = _remembered(trial.made)
        step = traced_step(trial, PERIOD, len(trial.needs.preview))
        if trial.needs.paced and PACE not in step.signals.slices:
            return f"it sets the mission's pace, but has no signal '{PACE}'"
        problem = _difference(trial, step)
        changed = sorted(name for name, text in _remembered(trial.made).items() if before.get(name) != text)
        if changed:
            return f"its step changes its own '{changed[0]}'; what it remembers belongs into its state"
        return problem
    except Exception as error:  # whatever it is, the flight in Python will say so if it matters there
        return described(error)


def _difference(trial: Any, step: TracedStep) -> str:
    """What the traced step gives otherwise than the Python step over some ticks; empty where nothing."""
    rng = np.random.default_rng(0)
    gains, state, flat = trial.gains(), trial.made.initial_state(), step.state
    needs = trial.needs
    for _ in range(STEPS):
        measurement, reference = shaken_hover(trial.robot, rng, needs)
        given = step.inputs.measurement.pack(measurement), step.inputs.reference.pack(reference)
        state, command, signals = trial.made.step(gains, state, measurement, reference, PERIOD)
        flat, *results = (part.full().ravel() for part in step.function.call([flat, *given, step.gains]))
        layouts: tuple[Layout[Any], ...] = step.inputs.state, step.commands, step.signals
        python: tuple[Any, ...] = state, command, with_floats(dict(signals))
        for layout, one, record in zip(layouts, (flat, *results), python, strict=True):
            for name in differing(layout, one, layout.pack(record)):
                return (
                    f"on symbols its step gives another '{name.rpartition('.')[2] or 'state'}' than on "
                    "numbers; the step may depend on its arguments alone, and uses functions of "
                    "skylimb.symbolic in place of math's"
                )
    return ""


def unrepeatable(make: Callable[[], Any], needs: Needs, gains: Any, robot: Robot) -> str:
    """Which part of its command a user's controller gives otherwise where it is made anew; empty where none.

    Two that were made one after the other get the same measurements. So it is seen that it draws random
    numbers that no seed says, and that a global of its file goes on from one flight to the next.

    Args:
        make: makes the user's object; it is flown by nobody else.
        needs: of the controller.
        gains: that its step gets.
        robot: the controller's.
    """

    def commands() -> list[Command]:
        made, rng = make(), np.random.default_rng(0)
        state, given = made.initial_state(), list[Command]()
        for _ in range(STEPS):
            measurement, reference = shaken_hover(robot, rng, needs)
            state, command, _ = made.step(gains, state, measurement, reference, PERIOD)
            given.append(Command(*(np.array(part, dtype=float) for part in command)))
        return given

    for one, other in zip(commands(), commands(), strict=True):
        for name, first, second in zip(Command._fields, one, other, strict=True):
            if not np.array_equal(first, second, equal_nan=True):
                return name
    return ""


def differing(layout: Layout[Any], one: np.ndarray, other: np.ndarray) -> Iterator[str]:
    """Dotted names of the entries in which two flat records differ."""
    for name, part in layout.slices.items():
        if not np.allclose(one[part], other[part], TOLERANCE, TOLERANCE, equal_nan=True):
            yield name


def _remembered(made: Any) -> dict[str, str]:
    """What a step could keep outside of its state: in its object, its class and the globals of its file."""
    names = getattr(getattr(type(made), "step", None), "__globals__", {})
    file = dict(_plain_values(SimpleNamespace(**names), type(made).__module__, set()))
    return file | plain_attributes(made)


def plain_attributes(made: Any) -> dict[str, str]:
    """The plain values of an object or a module, as text: to see whether a step has changed them.

    What its own classes, functions and objects keep counts as well, as in `Filter.calls` or `filter.sum`.
    """
    home = made.__name__ if isinstance(made, ModuleType) else type(made).__module__
    return dict(_plain_values(made, home, set()))


def _plain_values(made: Any, home: str, seen: set[int], before: str = "") -> Iterator[tuple[str, str]]:
    """Name and text of each plain value in an object, and in those in it that the module `home` defines."""
    seen.add(id(made))
    for name, value in list(getattr(made, "__dict__", {}).items()):
        if name[:2] == "__":
            continue
        if isinstance(value, _PLAIN):
            yield f"{before}{name}", repr(value)
        elif id(value) not in seen and home in (getattr(value, "__module__", ""), type(value).__module__):
            yield from _plain_values(value, home, seen, f"{before}{name}.")


def shaken_hover(robot: Robot, rng: np.random.Generator, needs: Needs) -> tuple[Measurement, Reference]:
    """A robot near the origin in its nominal posture, shaken about, and a reference beside it.

    Args:
        robot: any robot.
        rng: shakes it.
        needs: of the controller that is to work on both.
    """
    q, psi = nominal_posture(robot, needs.vectoring)
    x, y, z = np.eye(3)
    exact = z, np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3), np.zeros(3), q, psi
    p, quaternion, *others = list[Any](part + 0.01 * rng.standard_normal(part.shape) for part in exact)
    reference = zero_reference(robot.n_joints, robot.n_vectoring)._replace(
        position=z + 0.1 * rng.standard_normal(3),
        velocity=0.1 * rng.standard_normal(3),
        heading=0.1 * float(rng.standard_normal()),
        joint_angles=q,
        vectoring_angles=psi,
        contact_axis=x,
        sliding_axis=y,
        tip_position=z + x,
        reach=1.0,
        touch=1.0,
    )
    shaken = Measurement(p, quaternion / np.linalg.norm(quaternion), *others)
    if needs.imu:
        said = np.zeros(3), robot.description.gravity * z
        shaken = shaken._replace(imu=Imu(*(part + 0.01 * rng.standard_normal(3) for part in said)))
    return shaken, reference._replace(ahead=(reference,) * len(needs.preview))
