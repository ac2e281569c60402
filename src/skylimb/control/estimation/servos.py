"""Servos against their commands: whether a joint is where its servo should have turned it.

A servo's set point follows its command at a limited speed, and the joint follows the set point with a lag of
its friction over its stiffness, no faster than its torque allows. What a load bends it by comes slowly, and
is averaged away, but for what a rotor's drag bends at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.robots.model import Robot
from skylimb.symbolic import Array, abs, clip, low_pass, max, where

ASTRAY = 0.1
"""Way from where a joint should be that no load explains, rad; without a fault shape joints keep to .01."""

MEAN = 1.0
"""Rate at which what a load bends is averaged, 1/s."""


class Servos(NamedTuple):
    """What is remembered, of shape and vectoring joints together, (n,) each, rad.

    Attributes:
        set_points: that the servos follow.
        angles: where they should have turned the joints.
        bent: mean of how far the joints are from there.
        started: 0 before the first tick, 1 after it.
    """

    set_points: Array
    angles: Array
    bent: Array
    started: Any


def initial_servos(robot: Robot) -> Servos:
    """Nothing is known yet."""
    still = np.zeros(robot.n_joints + robot.n_vectoring)
    return Servos(still, still, still, 0.0)


def watch_servos(robot: Robot, state: Servos, command: Array, angles: Array, dt: float) -> tuple[Servos, Any]:
    """One step.

    Args:
        robot: the model.
        state: of the last tick.
        command: of the last tick, rad, (n,).
        angles: as measured, rad, (n,).
        dt: control period, s.

    Returns:
        What is remembered, and 1 where a joint is astray.
    """
    speed, lag, bound = _servos(robot)
    begun = [where(state.started > 0.5, before, angles) for before in state[:2]]
    set_points = begun[0] + clip(command - begun[0], -speed * dt, speed * dt)
    expected = low_pass(begun[1], set_points, 1.0 / lag, dt)
    off = angles - expected
    astray = where(abs(off - state.bent) > bound, 1.0, 0.0)
    bent = where(astray > 0.5, state.bent, low_pass(state.bent, off, MEAN, dt))
    return Servos(set_points, expected, bent, 1.0), max(astray) if astray.shape[0] else 0.0


def _servos(robot: Robot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speed, rad/s, lag, s, and greatest way off, rad, of each joint.

    A rotor's drag bends the vectoring joint that it sits on, as fast as its thrust changes.
    """
    known, servos = robot.description, robot.description.servos
    drag = max(np.array([abs(rotor.drag_torque_coefficient) * rotor.thrust_max for rotor in known.rotors]))
    bend = drag / known.vectoring_servos.stiffness
    friction = servos.damping + np.array([known.joint(name).damping for name in known.moving_joints])
    speed = np.fmin(servos.speed_limit, servos.torque_limit / np.fmax(friction, 1e-9))
    lag = np.fmax(friction / servos.stiffness, 1e-3)
    return speed, lag, ASTRAY + np.concatenate([np.zeros(robot.n_joints), bend])
