"""The filter of a body: exact where its model is, calm where sensors are not, safe where they fail."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout
from skylimb.base.rotations import quaternion_from_rotation, rotation_from_rpy, rotation_from_vector
from skylimb.control.estimation.body_filter import (
    FORCE,
    TORQUE,
    Biases,
    Filtered,
    Spread,
    initial_filter,
    moved,
    settled,
)
from skylimb.control.estimation.body_filter_imu import ImuSpread, drifts, felt, first_biases
from skylimb.control.estimation.body_filter_sight import looked
from skylimb.control.estimation.records import Imu, Measurement
from skylimb.robots.model import ImuPlace

DT, MASS, G = 0.005, 4.0, np.array([0.0, 0.0, 9.80665])
INERTIA = np.diag([0.1, 0.2, 0.3])
BODY_TO_C = rotation_from_rpy(0.1, -0.2, 0.0)
COG = np.array([0.2, -0.1, 0.05])
MODEL: Any = SimpleNamespace(mass=MASS, gravity=G, inertia_C=INERTIA, R_root_C=BODY_TO_C, cog_root=COG)
Z3 = np.zeros(3)
MOUNT = ImuPlace(np.array([0.4, -0.1, 0.02]), rotation_from_rpy(0.1, -0.2, 0.7), Z3, Z3)
FORCE_ON, TORQUE_ON = np.array([1.0, -2.0, 0.5]), np.array([0.02, 0.05, -0.03])
SPREAD, IMU = Spread(), ImuSpread(on=True)


class Given(NamedTuple):
    """What a step is given besides its state."""

    seen: Measurement
    imu: Imu
    known: np.ndarray


GIVEN = Layout(
    Given(Measurement(Z3, np.zeros(4), Z3, Z3, np.zeros(0), np.zeros(0), 0.0), Imu(Z3, Z3), np.zeros(6))
)


@functools.cache
def stepper(imu: bool) -> tuple[ca.Function, Layout[Filtered]]:
    """A compiled step of the filter, and where its state stands."""
    kept = Layout(initial_filter(SPREAD, first_biases(ImuSpread(on=imu))))
    before, flat = ca.SX.sym("before", kept.size), ca.SX.sym("given", GIVEN.size)
    state, given = kept.unpack(before), GIVEN.unpack(flat)
    state = state._replace(known_force=given.known[0:3], known_torque=given.known[3:6])
    state = moved(SPREAD, state, drifts(ImuSpread(on=imu)), MODEL, DT)
    state, shown = looked(SPREAD, state, given.seen, MODEL, Z3, DT)
    if imu:
        shown += felt(IMU, state, given.imu, MOUNT, MODEL)
    return ca.Function("step", [before, flat], [ca.densify(kept.pack(settled(state, MODEL, shown)))]), kept


MANY = 200
"""Steps that are one function: all flights here are multiples of it."""


@functools.cache
def many_steps(imu: bool) -> ca.Function:
    return stepper(imu)[0].mapaccum(MANY)


class Flown(NamedTuple):
    """A body under known and unknown wrench: what is measured without error, and how it really moves."""

    given: list[Given]
    motion: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]


@functools.cache
def flight(seconds: float, age: int = 0, pushed: float = 0.0) -> Flown:
    """Rotors that hover and swing a little; the unknown wrench acts from `pushed` (s) on.

    Args:
        seconds: how long.
        age: of the frames, ticks; a frame comes at every one.
        pushed: s.
    """
    position, velocity, omega = (
        np.array([1.0, 2.0, 1.5]),
        np.array([0.1, 0.0, -0.1]),
        np.array([0.1, 0.0, 0.05]),
    )
    R_WC = rotation_from_rpy(0.1, 0.05, 0.4)
    motion, given = [], list[Given]()
    known, specific = np.zeros(6), G
    spin = Z3
    for k in range(round(seconds / DT)):
        motion.append((position, velocity, R_WC, omega))
        p, v, R, w = motion[max(k - age, 0)]
        R_WB, rates = R @ BODY_TO_C.T, BODY_TO_C @ w
        seen = Measurement(
            p - R_WB @ COG,
            quaternion_from_rotation(R_WB),
            v - R_WB @ np.cross(rates, COG),
            rates,
            np.zeros(0),
            np.zeros(0),
            age * DT,
        )
        lever = BODY_TO_C.T @ (MOUNT.xyz - COG)
        from_C = MOUNT.R.T @ BODY_TO_C
        at_imu = from_C @ (
            R_WC.T @ specific + np.cross(spin, lever) + np.cross(omega, np.cross(omega, lever))
        )
        given.append(Given(seen, Imu(from_C @ omega, at_imu), known))
        acts = 1.0 if k * DT >= pushed else 0.0
        swing = np.array([0.5 * np.sin(0.02 * k), 0.4 * np.cos(0.03 * k), 0.2])
        known = np.concatenate([swing, [0.01 * np.sin(0.05 * k), -0.01, 0.004]])
        push, spin = (
            (known[0:3] + acts * FORCE_ON) / MASS,
            np.linalg.solve(INERTIA, known[3:6] + acts * TORQUE_ON),
        )
        specific = push + G
        position, velocity = position + DT * velocity + 0.5 * DT**2 * push, velocity + DT * push
        R_WC = R_WC @ rotation_from_vector(DT * (omega + 0.5 * DT * spin))
        omega = omega + DT * spin
    return Flown(given, motion)


class Estimates(Sequence[Filtered]):
    """States tick by tick, unpacked where one is looked at."""

    def __init__(self, rows: np.ndarray, kept: Layout[Filtered]) -> None:
        self._rows, self._kept = rows, kept

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, at: Any) -> Any:
        if isinstance(at, slice):
            return Estimates(self._rows[at], self._kept)
        return self._kept.unpack(self._rows[at])


def estimated(given: list[Given], imu: bool = False) -> Estimates:
    """The filter at every tick."""
    kept = stepper(imu)[1]
    rows = [kept.pack(initial_filter(SPREAD, first_biases(ImuSpread(on=imu))))[None]]
    told = np.array([GIVEN.pack(one) for one in given])
    for begin in range(0, len(told), MANY):
        rows.append(many_steps(imu)(rows[-1][-1], told[begin : begin + MANY].T).full().T)
    return Estimates(np.concatenate(rows[1:]), kept)


@pytest.mark.parametrize("age", [0, 3, 10])
@pytest.mark.parametrize("imu", [False, True])
def test_exact_sensors_however_late_leave_no_error(age: int, imu: bool) -> None:
    """A constant wrench is in the filter's model, so it comes out as it is, and so does the motion of now."""
    flown = flight(8.0, age)
    found = estimated(flown.given, imu)[-1]
    position, velocity, R_WC, omega = flown.motion[-1]
    np.testing.assert_allclose(found.force, FORCE_ON, atol=0.01)
    np.testing.assert_allclose(found.torque, TORQUE_ON, atol=2e-3)
    np.testing.assert_allclose(found.position, position, atol=2e-4)
    np.testing.assert_allclose(found.velocity, velocity, atol=2e-3)
    np.testing.assert_allclose(found.angular_velocity, omega, atol=2e-3)
    np.testing.assert_allclose(found.R_WB @ BODY_TO_C, R_WC, atol=1e-3)
    np.testing.assert_allclose(found.R_WB @ found.R_WB.T, np.eye(3), atol=1e-12)


def test_a_step_is_seen_sooner_with_an_imu() -> None:
    times = {}
    for imu in (False, True):
        force = np.array([state.force[1] for state in estimated(flight(6.0, 3, 2.0).given, imu)])
        times[imu] = DT * np.argmax(force < -1.264) - 2.0  # 63 %
        assert force[100:400] == pytest.approx(0.0, abs=0.02)
    assert 0.05 < times[False] < 0.3
    assert times[True] < 0.85 * times[False]


def test_biases_of_an_imu_are_found() -> None:
    gyro, force = np.array([0.004, -0.002, 0.003]), np.array([0.05, 0.1, -0.08])
    flown = flight(25.0, 3, np.inf)
    given = [
        one._replace(imu=Imu(one.imu.angular_velocity + gyro, one.imu.specific_force + force))
        for one in flown.given
    ]
    found = estimated(given, True)[-1]
    assert isinstance(found.biases, Biases)
    np.testing.assert_allclose(found.biases.gyro, gyro, atol=4e-4)
    np.testing.assert_allclose(found.biases.accelerometer, force, atol=0.02)
    np.testing.assert_allclose(found.force, 0.0, atol=0.05)


@pytest.fixture(scope="module")
def noisy() -> np.ndarray:
    """Errors of force and torque of 24 flights of 2 s, over what the filter takes for their deviation."""
    rng, found = np.random.default_rng(3), []
    exact = flight(2.0, 3, np.inf).given
    for _ in range(24):
        # A frame whose errors are those that the filter is told, and a wrench that drifts as it is told.
        given = [one._replace(seen=spoilt(one.seen, rng)) for one in exact]
        last = estimated(given)[-1]
        deviation = np.sqrt(np.diag(last.covariance))
        both = np.concatenate([last.force, last.torque])
        found.append(both / deviation[FORCE : TORQUE + 3])
    return np.array(found)


def spoilt(seen: Measurement, rng: np.random.Generator) -> Measurement:
    w, x, y, z = seen.quaternion
    turn = np.array([1.0, *(0.5 * SPREAD.attitude * rng.normal(size=3))])
    product = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]]) @ turn
    return seen._replace(
        position=seen.position + SPREAD.position * rng.normal(size=3),
        velocity=seen.velocity + SPREAD.velocity * rng.normal(size=3),
        quaternion=product / np.linalg.norm(product),
        angular_velocity=seen.angular_velocity + SPREAD.rates * rng.normal(size=3),
    )


def test_the_filter_knows_how_sure_it_is(noisy: np.ndarray) -> None:
    """No wrench at all where it allows for one that drifts: its errors are less than it says, not much so."""
    assert 0.3 < np.sqrt(np.mean(noisy**2)) < 1.0
    assert abs(noisy.mean()) < 0.15


NAN = np.full(3, np.nan)
SPOILT = {
    "position": {"position": NAN},
    "attitude": {"quaternion": np.zeros(4)},
    "infinite rates": {"angular_velocity": np.array([np.inf, 0.0, 0.0])},
    "too old": {"position": np.full(3, 9.0), "capture_age": 1e6},
    "age that is none": {"position": np.full(3, 9.0), "capture_age": np.nan},
    "an old frame again": {"position": np.full(3, 9.0), "capture_age": 0.5},
}


@pytest.mark.parametrize("what", SPOILT)
def test_what_cannot_be_believed_changes_nothing(what: str) -> None:
    flown = flight(3.0, 3)
    given = list(flown.given)
    for k in range(400, 440):
        given[k] = given[k]._replace(seen=given[k].seen._replace(**SPOILT[what]))
    states = estimated(given)
    for k in (420, 439, 480, 599):
        np.testing.assert_allclose(states[k].position, flown.motion[k][0], atol=2e-3)
        np.testing.assert_allclose(states[k].force, FORCE_ON, atol=0.15)
    assert np.isfinite(Layout(states[-1]).pack(states[-1])).all()
    # Less sure with every tick that nothing is seen.
    assert states[439].covariance[FORCE, FORCE] > states[399].covariance[FORCE, FORCE]


def test_a_frame_counts_once() -> None:
    """The same frame, as it grows older, shows nothing new."""
    flown = flight(2.0)
    given, frame = list(flown.given), flown.given[300].seen
    for k in range(301, 400):
        given[k] = given[k]._replace(seen=frame._replace(capture_age=(k - 300) * DT))
    states = estimated(given)
    counted = [np.trace(state.covariance) for state in states[300:310]]
    assert np.all(np.diff(counted) > 0.0)


def test_an_imu_that_says_no_number_is_left_out() -> None:
    given = [one._replace(imu=Imu(NAN, NAN)) for one in flight(3.0, 3).given]
    with_it, without = estimated(given, True)[-1], estimated(given, False)[-1]
    np.testing.assert_allclose(with_it.force, without.force, atol=1e-9)
    np.testing.assert_allclose(with_it.covariance[:18, :18], without.covariance, atol=1e-9)


def test_it_waits_for_a_first_frame() -> None:
    flown = flight(2.0, 0)
    given = list(flown.given)
    for k in range(50):
        given[k] = given[k]._replace(seen=given[k].seen._replace(position=NAN))
    states = estimated(given)
    assert states[49].started == 0.0
    np.testing.assert_allclose(states[50].position, flown.motion[50][0], atol=1e-9)
    np.testing.assert_allclose(states[-1].force, FORCE_ON, atol=0.1)


def test_the_covariance_stays_one() -> None:
    rng = np.random.default_rng(4)
    given = [one._replace(seen=spoilt(one.seen, rng)) for one in flight(12.0, 3).given]
    for state in estimated(given, True)[::400]:
        assert np.linalg.eigvalsh(state.covariance).min() > 0.0
        np.testing.assert_array_equal(state.covariance, state.covariance.T)


def test_what_cannot_be_is_refused_by_name() -> None:
    with pytest.raises(ConfigError, match="velocity"):
        Spread(velocity=0.0)
    with pytest.raises(ConfigError, match="accelerometer"):
        ImuSpread(accelerometer=-1.0)
