"""The prediction of a body that moves and turns about every axis, against small steps of its equations."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from skylimb.base.rotations import hat, rotation_from_rpy
from skylimb.control.estimation.delay import (
    DEPTH,
    Delay,
    DelayState,
    delayed_wrench,
    predict,
    remember,
)
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.robots.description import GRAVITY

G = np.array([0.0, 0.0, GRAVITY])

DT = 0.005
MASS, INERTIA = 4.0, np.array([[0.11, 0.01, 0.02], [0.01, 0.21, -0.03], [0.02, -0.03, 0.3]])
MODEL: Any = SimpleNamespace(mass=MASS, gravity=G, inertia_C=INERTIA)
R0 = rotation_from_rpy(0.2, -0.1, 0.6)
EXTERNAL = Wrench(np.array([0.5, -1.0, 2.0]), np.array([0.02, 0.03, -0.05]))


def history() -> DelayState:
    """A wrench that changes with every tick, newest first."""
    rng = np.random.default_rng(2)
    wrenches = rng.normal(size=(DEPTH, 6)) * np.array([2.0, 2.0, 2.0, 0.05, 0.05, 0.05])
    return DelayState(tuple(wrenches))


def integrated(body: BodyState, wrenches: DelayState, latency: float) -> BodyState:
    """The same motion in steps of a thousandth of a tick: Newton, and Euler without the gyroscopic torque."""
    p, v, R, w = body.position.copy(), body.velocity.copy(), body.R_WC.copy(), body.angular_velocity.copy()
    count = round(1000 * latency / DT)
    step = latency / count
    for k in range(count):
        age = latency - (k + 0.5) * step
        acting = wrenches.wrenches[int(age / DT)]
        a = (acting[:3] + EXTERNAL.force) / MASS
        bend = np.linalg.solve(INERTIA, acting[3:] + EXTERNAL.torque)
        p, v = p + v * step + 0.5 * a * step**2, v + a * step
        turn = w * step + 0.5 * bend * step**2
        R, w = R @ (np.eye(3) + hat(turn) + 0.5 * hat(turn) @ hat(turn)), w + bend * step
    return body._replace(position=p, velocity=v, R_WC=R, angular_velocity=w)


@pytest.mark.parametrize("latency", [0.004, 0.02, 0.0225, 0.07])
def test_the_prediction_is_the_motion_that_the_history_makes(latency: float) -> None:
    position, velocity, spin = np.array([[1.0, 2.0, 3.0], [0.4, -0.2, 0.1], [0.3, -0.2, 0.1]])
    start = BodyState(position, velocity, R0, spin, MODEL)
    found = predict(Delay(latency), history(), start, EXTERNAL, DT)
    wanted = integrated(start, history(), latency)
    np.testing.assert_allclose(found.velocity, wanted.velocity, atol=1e-9)
    np.testing.assert_allclose(found.position, wanted.position, atol=1e-9)
    np.testing.assert_allclose(found.angular_velocity, wanted.angular_velocity, atol=1e-9)
    turned = float(np.linalg.norm(spin)) * latency + 0.5 * 0.6 * latency**2
    np.testing.assert_allclose(found.R_WC, wanted.R_WC, atol=turned**3 + 0.1 * turned**2 * latency)
    np.testing.assert_allclose(found.R_WC.T @ found.R_WC, np.eye(3), atol=1e-12)
    assert found.model is MODEL


def test_a_large_turn_is_predicted_as_a_rotation() -> None:
    """Cayley's form: the tangent of half the angle is half the vector."""
    spin = np.array([0.0, 0.0, 20.0])
    start = BodyState(np.zeros(3), np.zeros(3), np.eye(3), spin, MODEL)
    none = Wrench(np.zeros(3), np.zeros(3))
    found = predict(Delay(0.05), DelayState(), start, none, DT)
    assert np.arctan2(found.R_WC[1, 0], found.R_WC[0, 0]) == pytest.approx(2.0 * np.arctan(0.5))
    np.testing.assert_allclose(found.R_WC[2], [0.0, 0.0, 1.0], atol=1e-12)


def test_without_latency_nothing_is_predicted() -> None:
    start = BodyState(np.ones(3), np.ones(3), R0, np.ones(3), MODEL)
    found = predict(Delay(0.0), history(), start, EXTERNAL, DT)
    for name in ("position", "velocity", "R_WC", "angular_velocity"):
        np.testing.assert_array_equal(getattr(found, name), getattr(start, name))


def test_the_newest_wrench_comes_first_and_the_oldest_is_forgotten() -> None:
    before, new = history(), np.arange(6.0)
    after = remember(before, Wrench(new[:3], new[3:]))
    assert len(after.wrenches) == DEPTH == 26
    np.testing.assert_array_equal(after.wrenches[0], new)
    for old, kept in zip(before.wrenches[:-1], after.wrenches[1:], strict=True):
        assert kept is old
    assert len(DelayState().wrenches) == DEPTH
    assert not np.any(DelayState().wrenches)


@pytest.mark.parametrize(("ticks", "share"), [(0.0, 0.0), (1.0, 0.0), (1.25, 0.25), (4.6, 0.6)])
def test_the_delayed_wrench_lies_between_those_of_two_ticks(ticks: float, share: float) -> None:
    past = history()
    found = delayed_wrench(ticks * DT, past, DT)
    newer, older = past.wrenches[int(ticks)], past.wrenches[int(ticks) + 1]
    wanted = (1.0 - share) * newer + share * older
    np.testing.assert_allclose(found.force, wanted[:3], atol=1e-12)
    np.testing.assert_allclose(found.torque, wanted[3:], atol=1e-12)


def test_the_assumed_latency_is_20_ms_unless_a_preset_says_otherwise() -> None:
    assert Delay() == Delay(0.02)
