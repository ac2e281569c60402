"""Velocity and rates beside the poses that come: what works is never in doubt, what sticks soon is."""

import functools

import casadi as ca
import numpy as np
import pytest

from skylimb.base.packing import Layout
from skylimb.base.rotations import quaternion_product
from skylimb.control.estimation.records import Measurement
from skylimb.control.estimation.twist_check import SAME, TwistCheck, TwistGates, check_twist

DT = 0.005
GATES = TwistGates()


def swinging(
    time: float,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
    rate: float = 2.0 * np.pi,
    size: float = 1.0,
) -> Measurement:
    """A robot that swings: 0.1 m to and fro, and by 0.2 rad about an axis, or a share of both."""
    rng = rng or np.random.default_rng(0)
    axis = np.array([0.6, 0.0, 0.8])
    turn = 0.2 * size * np.sin(rate * time)
    small = noise * rng.standard_normal((4, 3))
    attitude = np.array([np.cos(0.5 * turn), *np.sin(0.5 * turn) * axis])
    q = quaternion_product(attitude, np.array([1.0, *0.5 * small[1]]))
    position = np.array([0.1 * size * np.sin(rate * time), 0.0, 1.0]) + small[0]
    velocity = np.array([0.1 * size * rate * np.cos(rate * time), 0.0, 0.0]) + 5.0 * small[2]
    rates = 0.2 * size * rate * np.cos(rate * time) * axis + 5.0 * small[3]
    return Measurement(position, q, velocity, rates, np.zeros(3), np.zeros(4))


SEEN, STATE = Layout(swinging(0.0)), Layout(TwistCheck())


@functools.cache
def checker(gates: TwistGates) -> ca.Function:
    """A compiled check: (state, what is seen, what was before, new, known) -> (state, velocity, rates)."""
    flat, now, before = (ca.SX.sym("flat", size) for size in (STATE.size, SEEN.size, SEEN.size))
    new, known = ca.SX.sym("new"), ca.SX.sym("known")
    seen, was = SEEN.unpack(now), SEEN.unpack(before)
    state, *twist = check_twist(gates, STATE.unpack(flat), seen, was, seen, 1.0, new, known, DT)
    return ca.Function("check", [flat, now, before, new, known], [ca.densify(STATE.pack(state)), *twist])


def checked(
    change, every: int = 1, noise: float = 1e-3, time: float = 6.0, gates: TwistGates = GATES
) -> list[TwistCheck]:
    """What is remembered at each tick of a flight whose poses come at every so many ticks."""
    rng, ticks = np.random.default_rng(1), np.arange(round(time / DT))
    came = [swinging(0.0, noise, rng)]
    for k in ticks:
        came.append(came[-1] if k % every else change(k * DT, swinging(k * DT, noise, rng)))
    packed = np.array([SEEN.pack(one) for one in came]).T
    new, known = (flag[None].astype(float) for flag in (ticks % every == 0, ticks > 0))
    states, *twist = checker(gates).mapaccum(len(ticks))(
        STATE.pack(TwistCheck()), packed[:, 1:], packed[:, :-1], new, known
    )
    found = [STATE.unpack(one) for one in states.full().T]
    right = [k for k in ticks if not found[k].wrong]
    for name, made in zip(("velocity", "angular_velocity"), twist, strict=True):
        np.testing.assert_array_equal(made.full().T[right], [getattr(came[k + 1], name) for k in right])
    return found


@pytest.mark.parametrize(("every", "noise"), [(1, 0.0), (1, 1e-3), (1, 3e-3), (2, 1e-3), (6, 1e-3)])
def test_sensors_that_work_are_far_from_the_gates(every: int, noise: float) -> None:
    states = checked(lambda time, seen: seen, every, noise)
    assert not states[-1].wrong
    # A pose that comes seldom is led on by the twist of its own frame.
    allowed = 0.25 if every < 6 else 0.7
    assert max(np.linalg.norm(one.off_way) for one in states) < allowed * GATES.twist_way
    assert max(np.linalg.norm(one.off_turn) for one in states) < allowed * GATES.twist_turn
    assert max(max(one.same_velocity, one.same_rates) for one in states) <= 1.0


@pytest.mark.parametrize(
    "change",
    [
        lambda seen: seen._replace(angular_velocity=np.zeros(3)),
        lambda seen: seen._replace(angular_velocity=seen.angular_velocity * 0.0 + 0.3),
        lambda seen: seen._replace(angular_velocity=-seen.angular_velocity),
        lambda seen: seen._replace(angular_velocity=57.3 * seen.angular_velocity),
        lambda seen: seen._replace(angular_velocity=seen.angular_velocity + np.array([0.0, 0.6, 0.0])),
        lambda seen: seen._replace(velocity=np.array([0.3, 0.0, 0.0])),
        lambda seen: seen._replace(velocity=-seen.velocity),
        lambda seen: seen._replace(velocity=seen.velocity + np.array([0.0, 0.0, -0.6])),
    ],
)
def test_a_twist_that_does_not_fit_the_poses_is_wrong_soon_and_for_good(change) -> None:
    states = checked(lambda time, seen: change(seen) if 2.0 <= time < 3.0 else seen)
    wrong = np.array([one.wrong for one in states])
    assert 2.0 < np.argmax(wrong) * DT < 2.5
    assert wrong[np.argmax(wrong) :].all()


@pytest.mark.parametrize(("speeds", "factor"), [
    ("angular_velocity", 0.5), ("angular_velocity", 2.0), ("velocity", 0.5), ("velocity", 2.0)
])  # fmt: skip
def test_speeds_that_are_scaled_are_wrong_long_before_that_adds_up(speeds: str, factor: float) -> None:
    def scaled(time: float, _: Measurement) -> Measurement:
        seen = swinging(time, 1e-3, rng, size=0.6 if factor < 1.0 else 0.4)
        return seen._replace(**{speeds: getattr(seen, speeds) * (factor if time >= 2.0 else 1.0)})

    rng = np.random.default_rng(2)
    states = checked(scaled)
    wrong = np.array([one.wrong for one in states])
    assert 2.0 < np.argmax(wrong) * DT < 3.0
    assert max(np.linalg.norm(one.off_way) for one in states) < GATES.twist_way
    assert max(np.linalg.norm(one.off_turn) for one in states) < GATES.twist_turn
    rng = np.random.default_rng(2)
    assert not checked(scaled, gates=TwistGates(twist_share=1e3))[-1].wrong  # only what adds up counts


@pytest.mark.parametrize("older", [-0.02, 0.02])
def test_a_twist_that_is_older_or_younger_than_its_pose_is_not_scaled(older: float) -> None:
    def of_another_time(time: float, seen: Measurement) -> Measurement:
        size = min(time, 1.0)
        other = swinging(time - older, rate=4.0 * np.pi, size=size)
        here = swinging(time, 1e-3, rng, rate=4.0 * np.pi, size=size)
        return here._replace(velocity=other.velocity, angular_velocity=other.angular_velocity)

    rng = np.random.default_rng(2)
    states = checked(of_another_time)
    assert max(np.linalg.norm(one.off_turn) for one in states) > 0.3 * GATES.twist_turn
    assert not states[-1].wrong


def test_bits_that_stay_as_poses_change_are_seen_first() -> None:
    stuck = {}

    def sticks(time: float, seen: Measurement) -> Measurement:
        if time < 2.0:
            return seen
        return seen._replace(angular_velocity=stuck.setdefault("rates", seen.angular_velocity))

    wrong = [bool(one.wrong) for one in checked(sticks)]
    assert np.argmax(wrong) * DT - 2.0 <= (SAME + 2) * DT


def test_a_capture_that_jumps_or_is_gone_says_nothing_of_the_twist() -> None:
    jump = np.array([0.5, 0.0, 0.0])
    states = checked(lambda time, seen: seen._replace(position=seen.position + jump * (time >= 2.0)))
    assert not states[-1].wrong


def test_one_pose_that_is_elsewhere_after_a_gap_says_nothing_of_the_twist() -> None:
    state, rng, before = TwistCheck(), np.random.default_rng(3), swinging(0.0)
    for k in range(1000):
        small = 1e-4 * rng.standard_normal((3, 3))
        elsewhere = 0.3 * np.ones(3) * (k >= 500)
        seen = before._replace(position=elsewhere + small[0], velocity=small[1], angular_velocity=small[2])
        new = 0.0 if 400 <= k < 500 else 1.0
        seen = seen if new else before
        state, _, _ = check_twist(GATES, state, seen, before, seen, 1.0, new, float(k > 0), DT)
        before = seen
    assert not state.wrong


def test_no_number_is_no_twist_and_no_fault_of_one() -> None:
    state, good = TwistCheck(), swinging(0.0)
    bad = good._replace(velocity=np.full(3, np.nan), position=np.full(3, np.nan))
    for seen, sane in ((good, 1.0), (bad, 0.0), (good, 1.0)):
        state, velocity, _ = check_twist(GATES, state, seen, good, good, sane, sane, 1.0, DT)
        if sane:
            assert np.isfinite(velocity).all()
    assert np.isfinite(np.hstack([np.ravel(part) for part in state])).all()
    assert not state.wrong
