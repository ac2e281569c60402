"""The state by an IMU: no lag of the capture's, biases found, and on through a gap of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pytest

from skylimb.base.errors import SkylimbError
from skylimb.base.packing import Layout
from skylimb.base.rotations import rotation_error, rotation_from_rpy, rotation_from_vector
from skylimb.control.estimation.inertial import (
    DEPTH,
    Carried,
    Inertial,
    Place,
    body_of,
    carried,
    imu_of,
    navigated,
)
from skylimb.control.estimation.records import Imu
from skylimb.control.estimation.smoothing import Smoothing
from skylimb.robots.model import ImuPlace

DT, G = 0.005, np.array([0.0, 0.0, 9.80665])
GAINS = SimpleNamespace(position=10.0, velocity=10.0, attitude=10.0, bias=0.3)
Z3 = np.zeros(3)
MOUNT = ImuPlace(np.array([0.3, -0.1, 0.02]), rotation_from_rpy(0.1, -0.2, 0.7), Z3, Z3)
LATENCY = 0.015


class Given(NamedTuple):
    """What a step is given besides its state."""

    said: Imu
    seen: Place
    age: Any
    started: Any


GIVEN = Layout(Given(Imu(Z3, Z3), Place(), 0.0, 0.0))
KEPT, BODY = Layout(Inertial()), Layout(Place())


def _step() -> ca.Function:
    before, flat = ca.SX.sym("before", KEPT.size), ca.SX.sym("given", GIVEN.size)
    given = GIVEN.unpack(flat)
    kept, body = navigated(GAINS, KEPT.unpack(before), *given[:3], MOUNT, given.started, G, DT)
    return ca.Function("step", [before, flat], [KEPT.pack(kept), BODY.pack(body)])


STEP = _step()


class Flight(NamedTuple):
    """A path of the IMU, exact in what it says: its motion at every tick, and what is measured."""

    moved: list[Carried]
    said: list[Imu]


def flight(seconds: float, turning: float = 1.0) -> Flight:
    """Swings of some 0.2 m and 0.2 rad; the mean force of a tick is exact."""
    times = np.arange(round(seconds / DT)) * DT
    R = rotation_from_rpy(0.1, -0.1, 0.5)
    moved, said = list[Carried](), list[Imu]()
    position, velocity, before = np.array([1.0, 0.0, 1.0]), Z3, Z3
    for t in times:
        rates = turning * np.array([0.3 * np.sin(1.3 * t), 0.2 * np.cos(0.9 * t), 0.2 * np.sin(0.5 * t)])
        pushed = np.array([0.3 * np.cos(1.1 * t), 0.2 * np.sin(0.8 * t), 0.1 * np.cos(2.0 * t)])
        R = R @ rotation_from_vector(0.5 * DT * (rates + before))
        position, velocity = position + DT * (velocity + 0.5 * DT * pushed), velocity + DT * pushed
        moved.append(Carried(position, velocity, R, rates))
        said.append(Imu(rates, R.T @ (pushed + G)))
        before = rates
    return Flight(moved, said)


def estimated(flown: Flight, seen: list[Place], said: list[Imu], ages: np.ndarray) -> tuple[Any, list[Place]]:
    """What is remembered at the end, and the body at every tick."""
    given = [
        GIVEN.pack(Given(said[k], seen[k], float(ages[k]), float(k > 0))) for k in range(len(flown.moved))
    ]
    kept, bodies = STEP.mapaccum(len(given))(KEPT.pack(Inertial()), np.transpose(given))
    return KEPT.unpack(kept[:, -1].full().ravel()), [BODY.unpack(body) for body in bodies.full().T]


def late(flown: Flight, ages: np.ndarray, noise: float = 0.0, seed: int = 0) -> list[Place]:
    """What the capture shows at every tick: the body some time ago."""
    rng, true = np.random.default_rng(seed), [body_of(one, MOUNT) for one in flown.moved]
    seen = []
    for k, age in enumerate(ages):
        then = true[max(k - round(age / DT), 0)]
        R = then.R @ rotation_from_vector(noise * rng.standard_normal(3))
        position, velocity = (noise * rng.standard_normal(3) * size for size in (1.0, 5.0))
        seen.append(Place(then.position + position, then.velocity + velocity, R, then.rates))
    return seen


def test_the_imu_and_its_body_say_each_other() -> None:
    rng = np.random.default_rng(1)
    joints = MOUNT._replace(velocity=rng.normal(size=3), rates=rng.normal(size=3))
    body = Place(rng.normal(size=3), rng.normal(size=3), rotation_from_rpy(0.3, 0.2, 1.0), rng.normal(size=3))
    for one, other in zip(body_of(imu_of(body, joints), joints), body, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_at_rest_it_stays_and_falling_it_falls() -> None:
    R = rotation_from_rpy(0.2, 0.4, -1.0)
    still = Carried(R=R)
    stays = carried(still, Imu(Z3, R.T @ G), G, DT)
    np.testing.assert_allclose(np.concatenate([stays.position, stays.velocity]), 0.0, atol=1e-15)
    falls = carried(still, Imu(Z3, Z3), G, DT)
    np.testing.assert_allclose(falls.velocity, -DT * G)
    np.testing.assert_allclose(falls.position, -0.5 * DT**2 * G)


def test_what_is_seen_late_is_no_lag() -> None:
    """Exact sensors, frames 15 ms old: the state is that of now. Without the IMU it would be 3 mm behind."""
    flown = flight(6.0)
    ages = np.full(len(flown.moved), LATENCY)
    _, found = estimated(flown, late(flown, ages), flown.said, ages)
    for body, true in list(zip(found, flown.moved, strict=True))[600:]:
        wanted = body_of(true, MOUNT)
        np.testing.assert_allclose(body.position, wanted.position, atol=2e-4)
        np.testing.assert_allclose(body.velocity, wanted.velocity, atol=2e-3)
        np.testing.assert_allclose(rotation_error(body.R, wanted.R), 0.0, atol=2e-4)
        np.testing.assert_allclose(body.rates, wanted.rates, atol=2e-3)


def test_biases_are_found_slowly() -> None:
    flown, gyro, force = flight(30.0), np.array([0.004, -0.002, 0.003]), np.array([0.05, 0.1, -0.08])
    ages = np.full(len(flown.moved), LATENCY)
    said = [Imu(one.angular_velocity + gyro, one.specific_force + force) for one in flown.said]
    kept, _ = estimated(flown, late(flown, ages), said, ages)
    np.testing.assert_allclose(kept.imu.gyro_bias, gyro, atol=2e-4)
    np.testing.assert_allclose(kept.imu.accelerometer_bias, force, atol=5e-3)


@pytest.fixture(scope="module")
def carried_away() -> np.ndarray:
    """How far eight IMUs with noise and biases are off at each tick of a gap of 2 s, m: (8, ticks).

    The capture's frame stays as it was, and grows old.
    """
    gap = 2.0
    flown, ticks = flight(12.0 + gap), round(gap / DT)
    ages = np.full(len(flown.moved), LATENCY)
    ages[-ticks:] += DT * np.arange(1, ticks + 1)
    true = np.array([body_of(one, MOUNT).position for one in flown.moved[-ticks - 1 :]])
    away = []
    for seed in range(8):
        rng = np.random.default_rng(100 + seed)
        gyro, force = 0.002 * rng.standard_normal(3), 0.05 * rng.standard_normal(3)
        said = [
            Imu(
                one.angular_velocity + gyro + 0.002 * rng.standard_normal(3),
                one.specific_force + force + 0.05 * rng.standard_normal(3),
            )
            for one in flown.said
        ]
        seen = late(flown, np.full(len(ages), LATENCY), 1e-3, seed)
        seen[-ticks:] = [seen[-ticks - 1]] * ticks
        _, found = estimated(flown, seen, said, ages)
        error = np.array([one.position for one in found[-ticks - 1 :]]) - true
        away.append(np.linalg.norm(error[1:] - error[0], axis=1))
    return np.array(away)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gap", "median", "most"), [(0.1, 2e-3, 3e-3), (0.5, 4e-3, 5e-3), (2.0, 0.025, 0.035)]
)
def test_it_goes_on_through_a_gap_of_the_capture(
    carried_away: np.ndarray, gap: float, median: float, most: float
) -> None:
    away = carried_away[:, round(gap / DT) - 1]
    assert np.median(away) < median
    assert away.max() < most


def test_a_frame_that_is_too_old_corrects_nothing_however_wrong_it_is() -> None:
    flown = flight(3.0)
    ages = np.full(len(flown.moved), LATENCY)
    seen = late(flown, ages)
    ages[400:500] = 1e6
    seen[400:500] = [Place(np.full(3, 9.0), np.full(3, 9.0), rotation_from_rpy(1.0, 1.0, 1.0), Z3)] * 100
    _, found = estimated(flown, seen, flown.said, ages)
    for k in (450, 499, 599):
        np.testing.assert_allclose(found[k].position, body_of(flown.moved[k], MOUNT).position, atol=3e-4)
    assert DEPTH * DT < 0.1


def test_an_imu_that_nothing_is_made_of_is_refused() -> None:
    with pytest.raises(SkylimbError, match="needs on = true"):
        Smoothing(imu=True)
