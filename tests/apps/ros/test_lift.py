"""What thrust the rotors need: learned at take-off, or seen by whoever takes over a robot that flies."""

from __future__ import annotations

import numpy as np
import pytest

from skylimb.apps.ros.lift import EASE, MOST, SURE, Lift
from skylimb.apps.ros.seen_thrust import SeenThrust
from skylimb.flight.realtime.landing import LOW

G, DT, GROUND = 9.81, 0.005, 0.17


pytestmark = pytest.mark.usefixtures("rotors_come_up_slowly")


def spooled(lift: Lift, seconds: float, height: float = GROUND) -> Lift:
    for _ in range(round(seconds / DT)):
        lift = lift.after(height, DT, G)
    return lift


def test_one_wrong_frame_is_no_lift_off() -> None:
    lift = spooled(Lift(GROUND), 1.1)
    assert lift.share > LOW
    lift = spooled(spooled(lift, 0.5 * SURE, GROUND + 0.013), 0.1)
    assert not lift.lifted
    assert spooled(lift, 2.0 * SURE, GROUND + 0.013).lifted


@pytest.mark.parametrize("scale", [0.8, 1.0, 1.2])
def test_a_lift_off_tells_what_the_rotors_need(scale: float) -> None:
    lift, height, speed, told = Lift(GROUND), GROUND, 0.0, 0.0
    for _ in range(1000):
        if lift.lifted:
            break
        lift = lift.after(height, DT, G)
        told += DT / 0.05 * (lift.share - told)
        speed = max(speed + DT * G * (told / scale - 1.0), 0.0)
        height += DT * speed
    assert lift.needs == lift.share == pytest.approx(scale, abs=0.02)


def test_what_is_learned_of_a_height_that_is_wrong_is_bounded() -> None:
    lift = spooled(spooled(Lift(GROUND), 1.05), 1.0, GROUND + 0.3)
    assert lift.lifted
    assert lift.needs == LOW


def test_a_landing_takes_thrust_away_until_no_robot_flies_with_it() -> None:
    lift = Lift(GROUND).carried(1.2)
    assert not lift.too_little(1.2 * 0.95)
    lift = lift.lowered(1.0)
    assert lift.share == pytest.approx(1.2 - EASE)
    assert lift.needs == 1.2
    assert lift.too_little(0.69 * 1.2)
    assert lift.lowered(9.0).share == 0.0


def taken_over(scale: float, jerks: float = 0.0) -> float:
    """What is found of a robot whose rotors need so much; `jerks` is a noise of its measured speed, m/s."""
    rng, seen, speed, told = np.random.default_rng(0), SeenThrust(), 0.0, scale
    for _ in range(200):
        told += DT / 0.05 * (1.0 - told)
        speed += DT * G * (told / scale - 1.0)
        seen = seen.after(1.0, speed + jerks * rng.standard_normal(), DT)
        if seen.over:
            break
    return seen.needs(G)


@pytest.mark.parametrize("scale", [0.8, 1.0, 1.25])
def test_who_takes_over_sees_what_the_rotors_need(scale: float) -> None:
    assert taken_over(scale) == pytest.approx(scale, rel=0.01)
    assert taken_over(scale, 0.1) == pytest.approx(scale, rel=0.04)


def test_a_robot_that_moves_as_no_rotors_move_it_tells_nothing() -> None:
    assert taken_over(3.0) == taken_over(0.3) == 1.0
    seen = SeenThrust()
    for _ in range(200):
        seen = seen.after(1.0, None, DT)
    assert seen.needs(G) == 1.0
    assert Lift(GROUND).carried(3.0).needs == MOST
