"""Servos against their commands: where a servo follows, nothing is astray; one that does not is seen."""

from __future__ import annotations

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.servos import ASTRAY, initial_servos, watch_servos

ROBOT, DT = skylimb.load_robot("hydrus_xi_quad"), 0.005
COUNT = ROBOT.n_joints + ROBOT.n_vectoring


def followed(commands: np.ndarray, spoilt: np.ndarray) -> list[float]:
    """What is seen of joints that follow as their servos should, but for what is added to their angles."""
    state, seen = initial_servos(ROBOT), []
    for k, (command, added) in enumerate(zip(commands, spoilt, strict=True)):
        angles = state.angles if k else commands[0]
        state, astray = watch_servos(ROBOT, state, command, angles + added, DT)
        seen.append(float(astray))
    return seen


def test_a_fast_move_and_a_slow_load_are_no_fault() -> None:
    commands = np.zeros((400, COUNT))
    commands[50:, 0], commands[50:, 4] = 0.3, 2.0
    load = np.minimum(np.arange(400) * DT, 1.0)[:, None] * 0.06 * np.eye(COUNT)[1]
    assert not any(followed(commands, load))


@pytest.mark.parametrize("joint", range(COUNT))
def test_a_joint_that_runs_away_is_seen_at_once_beyond_the_bound(joint: int) -> None:
    runs = np.maximum(np.arange(500) * DT - 1.0, 0.0)[:, None] * 0.5 * np.eye(COUNT)[joint]
    seen = followed(np.zeros((500, COUNT)), runs)
    first = seen.index(1.0)
    bound = ASTRAY + (0.0 if joint < ROBOT.n_joints else 0.0182 * 30.0 / 5.0)  # a rotor's drag bends as well
    assert bound / 0.5 <= first * DT - 1.0 < 1.6 * bound / 0.5
    assert all(seen[first:])


def test_a_robot_without_joints_has_none_astray() -> None:
    robot = skylimb.load_robot("tilted_hexarotor")
    none = np.zeros(0)
    assert watch_servos(robot, initial_servos(robot), none, none, DT)[1] == 0.0


def test_a_joint_follows_its_set_point_with_a_lag_of_friction_over_stiffness() -> None:
    state, step, known = initial_servos(ROBOT)._replace(started=1.0), 1e-3, ROBOT.description
    for _ in range(40):
        state, _ = watch_servos(ROBOT, state, np.full(COUNT, step), np.zeros(COUNT), DT)
    friction = known.servos.damping + [known.joint(name).damping for name in known.moving_joints]
    lag = friction / known.servos.stiffness
    np.testing.assert_allclose(state.angles, step * (1.0 - np.exp(-40 * DT / lag)), rtol=1e-6)
