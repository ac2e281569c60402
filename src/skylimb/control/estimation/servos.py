"""Servos against their commands: whether a joint is where its servo should have turned it.

A servo's set point follows its command at a limited speed. The joint follows the set point with a lag of its
friction over its stiffness, at most as fast as the servo's torque turns it against what of that friction is
the joint's own:

    psi' = min(k (set point - psi) + load, torque limit) / friction.

The set point itself is not held back by that: one that were would lag behind commands that swing by .4 rad in
.15 s, and call the joint astray that follows them. The load of the rotors on the vectoring joints, drag and
thrust beside the axis, is known with the thrusts. What else bends a joint comes slowly, and is averaged away.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.robots.loads import thrust_lines
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, abs, clip, low_pass, stack, where

ASTRAY = 0.1
"""Way from where a joint should be that no load explains, rad; without a fault joints keep to 0.04."""

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


def watch_servos(
    robot: Robot, state: Servos, command: Array, angles: Array, thrusts: Array, dt: float
) -> tuple[Servos, Array]:
    """One step.

    Args:
        robot: the model.
        state: of the last tick.
        command: of the last tick, rad, (n,).
        angles: as measured, rad, (n,).
        thrusts: that the rotors should have made since, N, (n_rotors,).
        dt: control period, s.

    Returns:
        What is remembered, and 1 for each joint that is astray, (n,).
    """
    if not angles.shape[0]:
        return state, angles
    servos = _servos(robot)
    begun = [where(state.started > 0.5, before, angles) for before in state[:2]]
    set_points = begun[0] + clip(command - begun[0], -servos.turns * dt, servos.turns * dt)
    bends = stack(np.zeros(robot.n_joints), servos.load @ thrusts) if robot.n_vectoring else 0.0
    followed = low_pass(begun[1], set_points + bends, 1.0 / servos.lag, dt)
    expected = begun[1] + clip(followed - begun[1], -servos.speed * dt, servos.speed * dt)
    off = angles - expected
    astray = where(abs(off - state.bent) > servos.bound, 1.0, 0.0)
    bent = where(astray > 0.5, state.bent, low_pass(state.bent, off, MEAN, dt))
    return Servos(set_points, expected, bent, 1.0), astray


def servo_lags(robot: Robot) -> np.ndarray:
    """By how much each joint lags behind its servo's set point, s, (n,), shape and vectoring together."""
    return _servos(robot).lag


class _Known(NamedTuple):
    """What is known of the servos, of shape and vectoring joints together, (n,) each.

    Attributes:
        turns: greatest speed of the set points, rad/s.
        speed: the same of the joints, rad/s.
        lag: of the joints, s.
        bound: greatest way off, rad.
        load: what 1 N of each rotor bends each vectoring joint by, rad/N, (n_vectoring, n_rotors).
    """

    turns: np.ndarray
    speed: np.ndarray
    lag: np.ndarray
    bound: np.ndarray
    load: np.ndarray


@functools.lru_cache(maxsize=16)
def _servos(robot: Robot) -> _Known:
    """What the robot's file says of its servos."""
    known, servos = robot.description, robot.description.servos
    own = np.fmax([known.joint(name).damping for name in known.moving_joints], 1e-9)
    lag = np.fmax((servos.damping + own) / servos.stiffness, 1e-3)
    load, rest = _rotors_bend(robot)
    bound = ASTRAY + np.concatenate([np.zeros(robot.n_joints), rest])
    return _Known(servos.speed_limit, servos.torque_limit / own, lag, bound, load)


def _rotors_bend(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """What 1 N bends each vectoring joint by, rad/N, and what of it greatest thrusts leave unsaid, rad.

    Of a rotor that its joint carries it is the same at all angles. Where joints carry joints it is not: the
    mean stands for it.
    """
    known, n = robot.description, robot.n_vectoring
    if not n:
        return np.zeros((0, robot.n_rotors)), np.zeros(0)
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", n)
    lines = ca.horzcat(*(line.load for line in thrust_lines(robot, q, psi, psi)))
    function = ca.Function("load", [q, psi], [lines / known.vectoring_servos.stiffness])
    angles = known.vectoring_start + np.pi * np.linspace(-1.0, 1.0, 9)[:, None] * np.sqrt(1.0 + np.arange(n))
    loads = np.array([function(robot.nominal_posture(), row).full() for row in angles])
    load = loads.mean(axis=0)
    return load, np.abs(loads - load).max(axis=0) @ np.array([rotor.thrust_max for rotor in known.rotors])
