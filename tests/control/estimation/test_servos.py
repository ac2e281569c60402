"""Servos against their commands: where a servo follows, nothing is astray; one that does not is seen."""

from __future__ import annotations

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.servos import ASTRAY, initial_servos, watch_servos

ROBOT, DT, FINE = skylimb.load_robot("hydrus_xi_quad"), 0.005, 10
COUNT = ROBOT.n_joints + ROBOT.n_vectoring
KNOWN = ROBOT.description
SERVOS = KNOWN.servos
JOINTS = np.array([KNOWN.joint(name).damping for name in KNOWN.moving_joints])


def turned(angles: np.ndarray, set_points: np.ndarray, command: np.ndarray, load: np.ndarray) -> None:
    """Joints without inertia a tick later, as the engine's servos turn them; `load` in N m."""
    for _ in range(FINE):
        step = SERVOS.speed_limit * DT / FINE
        set_points += np.clip(command - set_points, -step, step)
        spring = SERVOS.stiffness * (set_points - angles)
        free = (spring + load) / (SERVOS.damping + JOINTS)
        torque = np.clip(spring - SERVOS.damping * free, -SERVOS.torque_limit, SERVOS.torque_limit)
        angles += DT / FINE * (torque + load) / JOINTS


def followed(commands: np.ndarray, spoilt: np.ndarray, thrusts: np.ndarray | None = None) -> list[float]:
    """What is seen of joints that follow as the engine's do, but for what is added to their angles."""
    state, seen, thrusts = initial_servos(ROBOT), [], np.zeros((1, 4)) if thrusts is None else thrusts
    angles, set_points, before = commands[0].copy(), commands[0].copy(), commands[0]
    for k, (command, added) in enumerate(zip(commands, spoilt, strict=True)):
        given = thrusts[min(k, len(thrusts) - 1)]
        state, astray = watch_servos(ROBOT, state, before, angles + added, given, DT)
        seen.append(float(astray.max()))
        drag = 0.0182 * np.cos(0.35) * np.array([-1.0, 1.0, -1.0, 1.0]) * given
        turned(angles, set_points, command, np.concatenate([np.zeros(ROBOT.n_joints), drag]))
        before = command
    return seen


def test_a_fast_move_and_a_slow_load_are_no_fault() -> None:
    commands = np.zeros((400, COUNT))
    commands[50:, 0], commands[50:, 4] = 0.3, 2.0
    load = np.minimum(np.arange(400) * DT, 1.0)[:, None] * 0.06 * np.eye(COUNT)[1]
    assert not any(followed(commands, load))


def test_vectoring_angles_that_swing_faster_than_their_joints_can_are_no_fault() -> None:
    """Set points held to the joints' own speed were .24 rad behind, and ended one flight of three."""
    commands, time = np.zeros((400, COUNT)), np.arange(400) * DT
    commands[:, 3] = 0.5 * np.sin(2.0 * np.pi * 2.5 * time)
    commands[100:130, 5], commands[130:, 5] = -0.6, 0.6
    assert not any(followed(commands, np.zeros_like(commands)))


def test_thrusts_that_jump_bend_no_joint_astray() -> None:
    still, thrusts = np.zeros((200, COUNT)), np.full((200, 4), 1.0)
    thrusts[100:] = 30.0
    assert not any(followed(still, still, thrusts))


@pytest.mark.parametrize("joint", range(COUNT))
def test_a_joint_that_runs_away_is_seen_at_once_beyond_the_bound(joint: int) -> None:
    runs = np.maximum(np.arange(500) * DT - 1.0, 0.0)[:, None] * 0.5 * np.eye(COUNT)[joint]
    seen = followed(np.zeros((500, COUNT)), runs)
    first = seen.index(1.0)
    assert ASTRAY / 0.5 <= first * DT - 1.0 < 1.25 * ASTRAY / 0.5
    assert all(seen[first:])


def test_a_robot_without_joints_has_none_astray() -> None:
    robot = skylimb.load_robot("tilted_hexarotor")
    none = np.zeros(0)
    assert not watch_servos(robot, initial_servos(robot), none, none, np.zeros(6), DT)[1].size


def test_a_joint_follows_its_set_point_with_a_lag_of_friction_over_stiffness() -> None:
    state, step = initial_servos(ROBOT)._replace(started=1.0), 1e-3
    for _ in range(40):
        state, _ = watch_servos(ROBOT, state, np.full(COUNT, step), np.zeros(COUNT), np.zeros(4), DT)
    lag = (SERVOS.damping + JOINTS) / SERVOS.stiffness
    np.testing.assert_allclose(state.angles, step * (1.0 - np.exp(-40 * DT / lag)), rtol=1e-6)
