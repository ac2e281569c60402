"""The paper's equations as they are printed, where those cannot fly; see docs/errata.md.

They are here to be shown and tested, and nowhere else: everything that flies has the corrected forms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from skylimb.control.cascade import Cascade
from skylimb.control.controller import cascade_from_tables
from skylimb.control.laws.preset import preset_mapping
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.records import ArmTarget
from skylimb.control.shape.laws import admittance
from skylimb.control.translation.laws import impedance
from skylimb.robots.model import Robot
from skylimb.symbolic import clip

Acceleration = Callable[[Any, Any, Any, Any], Any]
"""(gains, push f - f_ref, extension r_ref - r, rate r') -> r''."""


def admittance_as_printed(gains: Any, push: Any, extension: Any, rate: Any) -> Any:
    """eq:admittance control: m_a (r_ref'' - r'') + c_a (r_ref' - r') + k_a (r_ref - r) = f, for r''."""
    return (gains.stiffness * extension - gains.damping * rate - push) / gains.mass


def difference_as_printed(gains: Any, push: Any, extension: Any, rate: Any) -> Any:
    """eq:difference method1, r'' = (f - k_a (r_ref - r) + c_a r') / m_a: spring and damper drive."""
    return (push - gains.stiffness * extension + gains.damping * rate) / gains.mass


class _Law:
    """A law that stands in for a module: its gains and state, another step. Equal to itself alone."""

    def __init__(self, like: Any, step: Callable[..., Any]) -> None:
        self.Gains, self.initial_state, self.step = like.Gains, like.initial_state, step


def hybrid_with(acceleration: Acceleration, robot: Robot) -> Cascade:
    """The hybrid preset with another equation for its arm."""

    def step(gains: Any, state: admittance.State, inputs: Any, reach_limits: tuple[float, float]) -> Any:
        push = (inputs.estimate.contact_force - gains.force_reference) * inputs.reference.adapt
        extension = inputs.reference.reach - state.reach
        rate = state.rate + acceleration(gains, push, extension, state.rate) * inputs.dt
        reach = clip(state.reach + rate * inputs.dt, *reach_limits)
        return admittance.State(reach, rate), ArmTarget(reach, state.rate), {}

    return _with_step("hybrid", robot, "shape", step)


def impedance_with_mass_times_force(robot: Robot) -> Cascade:
    """eq:thrust translation 2: the impedance preset, its thrusts allocated for m f_cmd."""

    def step(gains: Any, state: Any, inputs: Any) -> Any:
        state, force, signals = impedance.step(gains, state, inputs)
        return state, force * inputs.estimate.body.model.mass, signals

    return _with_step("impedance", robot, "translation", step)


def _with_step(preset: str, robot: Robot, slot: str, step: Callable[..., Any]) -> Cascade:
    """A preset whose law of one slot makes another step."""
    cascade = cascade_from_tables(*preset_mapping(preset), robot)
    filled = getattr(cascade.preset.slots, slot)
    other = replace(filled, name="printed", law=_Law(filled.law, step))
    return replace(cascade, preset=cascade.preset.with_slot(slot, other))


def leak_matrix(robot: Robot, theta: float) -> np.ndarray:
    """Q_t pinv(Q_r), (3, 3): force in C of a torque in C, N per N m; eq:thrust rotation 1 takes it to be 0.

    Args:
        robot: which.
        theta: configuration angle of the paper's family of postures, rad.
    """
    posture = [np.pi / 2 - theta, 2 * theta, -theta]
    Q = robot.at(posture, vectoring_table(robot).angles(theta)).allocation_C
    return Q[:3] @ np.linalg.pinv(Q[3:])
