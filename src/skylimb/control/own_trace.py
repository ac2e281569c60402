"""Whether a user's controller can be compiled: its step is tried on symbols, and held against numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.errors import SkylimbError
from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.needs import PACE, Needs
from skylimb.control.own_code import symbolic_record, traceable
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.records import Command
from skylimb.robots.model import Robot

_STEPS = 4
"""Ticks over which both ways are compared."""

PERIOD = 0.005
"""Control period of the trial, s."""

_TOLERANCE = 1e-7
"""Relative difference of numbers that are the same but for the order of operations."""


class _NoTrace(Exception):  # noqa: N818 - it is no error
    """Why a step cannot be compiled."""


def untraceable(make: Callable[[], Any], gains: Any, robot: Robot, needs: Needs, what: str) -> str:
    """Why a user's controller cannot be compiled, in a sentence; empty where it can.

    The traced step has to give the numbers of the Python step over some ticks. So a step that keeps something
    outside of its state, draws random numbers or asks a clock flies in Python.

    Args:
        make: makes an object like the one that will fly; the trial spoils it.
        gains: as arrays.
        robot: gives the sizes of measurement, reference and command.
        needs: what it needs of the loop.
        what: what the controller is called in messages.
    """
    try:
        made = make()
        state = made.initial_state()
        before = _attributes(made)
        traced, states, out = _traced(made, gains, state, robot, needs, what)
        problem = _difference(made, gains, state, traced, states, out, robot, needs)
        changed = sorted(name for name, text in _attributes(made).items() if before.get(name) != text)
        if changed:
            return f"its step changes its own '{changed[0]}'; what it remembers belongs into its state"
        return problem
    except _NoTrace as problem:
        return str(problem)
    except Exception as error:  # whatever it is, the flight in Python will tell it if it matters there
        return str(error) if isinstance(error, SkylimbError) else f"{type(error).__name__}: {error}"


def _traced(
    made: Any, gains: Any, state: Any, robot: Robot, needs: Needs, what: str
) -> tuple[ca.Function, Layout[Any], Layout[Any]]:
    """(gains, state, measurement, reference) -> (state, what it returns), flat, and the layouts of both."""
    states = Layout(state)
    symbols, records = symbolic_records(gains, state, robot, needs)
    new, command, signals = symbolic_record(traceable(made.step, what)(*records, PERIOD))
    if needs.paced and PACE not in signals:
        raise _NoTrace(f"it sets the mission's pace, but has no signal '{PACE}'")
    out = {"command": _command(command, robot), "signals": dict(signals)}
    layout = Layout(out)
    if Layout(new).shapes != states.shapes:
        raise _NoTrace(
            f"its new state has the shapes {Layout(new).shapes}, its initial state {states.shapes}; "
            "numbers of the state are floats, 0.0 and not 0"
        )
    results = [ca.densify(ca.SX(part)) for part in (states.pack(new), layout.pack(out))]
    return ca.Function("step", symbols, results), states, layout


def symbolic_records(gains: Any, state: Any, robot: Robot, needs: Needs) -> tuple[list[Any], list[Any]]:
    """Symbols for gains, state, measurement and reference: each flat, and as the record that a step takes."""
    layouts = [Layout(record) for record in (gains, state, _measurement(robot), _reference(robot, needs))]
    symbols = [ca.SX.sym(name, layout.size) for name, layout in zip("gsmr", layouts, strict=True)]
    return symbols, [layout.unpack(flat) for layout, flat in zip(layouts, symbols, strict=True)]


def _command(command: Any, robot: Robot) -> Command:
    """A command of the right sizes."""
    sizes = Command(robot.n_rotors, robot.n_joints, robot.n_vectoring)
    for name, size in sizes._asdict().items():
        found = Layout({name: getattr(command, name)}).size
        if found != size:
            raise _NoTrace(f"its command has {found} {name}, the robot takes {size}")
    return Command(*command)


def _difference(
    made: Any,
    gains: Any,
    state: Any,
    traced: ca.Function,
    states: Layout[Any],
    out: Layout[Any],
    robot: Robot,
    needs: Needs,
) -> str:
    """What the traced step gives otherwise than the Python step over some ticks; empty where nothing."""
    rng = np.random.default_rng(0)
    flat_gains, flat = Layout(gains).pack(gains), states.pack(state)
    for _ in range(_STEPS):
        measurement, reference = _measurement(robot, rng), _reference(robot, needs, rng)
        given = Layout(measurement).pack(measurement), Layout(reference).pack(reference)
        state, command, signals = made.step(gains, state, measurement, reference, PERIOD)
        flat, results = (part.full().ravel() for part in traced.call([flat_gains, flat, *given]))
        expected = out.pack({"command": Command(*command), "signals": dict(signals)})
        for layout, one, other in ((states, flat, states.pack(state)), (out, results, expected)):
            for name, part in layout.slices.items():
                if not np.allclose(one[part], other[part], _TOLERANCE, _TOLERANCE, equal_nan=True):
                    return (
                        f"on symbols its step gives another '{name.rpartition('.')[2] or 'state'}' than on "
                        "numbers; the step may depend on its arguments alone, and uses functions of "
                        "skylimb.symbolic in place of math's"
                    )
    return ""


def _attributes(made: Any) -> dict[str, str]:
    """The plain values that an object carries, as text: to see whether a step has changed them."""
    plain = (int, float, str, list, dict, tuple, set, np.ndarray, type(None))
    return {name: repr(value) for name, value in vars(made).items() if isinstance(value, plain)}


def _measurement(robot: Robot, rng: np.random.Generator | None = None) -> Measurement:
    """A robot in its nominal posture near the origin; disturbed where numbers are drawn."""
    q, psi = _posture(robot)
    exact = Measurement(
        np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3), np.zeros(3), q, psi
    )
    if rng is None:
        return exact
    noisy = Measurement(*(part + 0.01 * rng.standard_normal(part.shape) for part in exact))
    return noisy._replace(quaternion=noisy.quaternion / np.linalg.norm(noisy.quaternion))


def _reference(robot: Robot, needs: Needs, rng: np.random.Generator | None = None) -> Reference:
    """A reference of the nominal posture near the origin, with what lies ahead."""
    q, psi = _posture(robot)
    zero = zero_reference(robot.n_joints, robot.n_vectoring)
    x, y, z = np.eye(3)
    here = zero._replace(
        position=z,
        joint_angles=q,
        vectoring_angles=psi,
        contact_axis=x,
        sliding_axis=y,
        tip_position=z + x,
        reach=1.0,
    )
    if rng is not None:
        here = here._replace(
            position=z + 0.1 * rng.standard_normal(3),
            velocity=0.1 * rng.standard_normal(3),
            heading=0.1 * float(rng.standard_normal()),
            touch=1.0,
        )
    return here._replace(ahead=(here,) * len(needs.preview))


def _posture(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    family = posture_family(robot)
    theta = family.theta_nominal
    return family.joint_angles(theta), vectoring_table(robot).angles(theta)
