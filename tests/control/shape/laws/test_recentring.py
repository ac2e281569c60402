"""The arm that brings the body back to its anchor."""

from collections.abc import Callable

import pytest

from law_records import IN_THE_AIR
from skylimb.base.rotations import rot_z
from skylimb.control.estimation.records import Start
from skylimb.control.records import LawInput
from skylimb.control.shape.laws import recentring

DT, LIMITS = 0.005, (1.0, 1.15)
ENGAGED = IN_THE_AIR._replace(engaged=1.0)
Make = Callable[..., LawInput]


def test_it_begins_at_the_nominal_reach_and_at_rest(make_start: Callable[..., Start]) -> None:
    assert recentring.initial_state(recentring.Gains(), make_start(1.07)) == (1.07, 0.0)


def test_one_tick_in_contact_in_numbers(make_inputs: Make) -> None:
    gains = recentring.Gains(rate=0.4, arm_share=0.6)
    turn = rot_z(0.7)
    view = ENGAGED._replace(anchor=0.5, surface_velocity=0.03)
    at = make_inputs(
        contact=view,
        position=turn @ [0.52, 3.0, 1.0],
        reference={"contact_axis": turn[:, 0], "sliding_axis": turn[:, 1]},
    )
    state, arm, signals = recentring.step(gains, recentring.State(1.08, 0.01), at, LIMITS)
    rate = 0.6 * 0.03 + 0.4 * (0.52 - 0.5)
    assert state.reach == pytest.approx(1.08 + rate * DT, abs=1e-12)
    assert state.rate == pytest.approx(rate, abs=1e-9)
    assert arm == (state.reach, 0.01)
    assert signals == {}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_arm_keeps_to_its_limits(make_inputs: Make, sign: float) -> None:
    gains = recentring.Gains(rate_limit=0.06)
    far = make_inputs(contact=ENGAGED._replace(anchor=-sign))
    state, arm, _ = recentring.step(gains, recentring.State(1.09, 0.0), far, LIMITS)
    assert arm.reach - 1.09 == pytest.approx(sign * 0.06 * DT)
    for _ in range(1000):
        state, arm, _ = recentring.step(gains, state, far, LIMITS)
    assert arm == (1.15 if sign > 0.0 else 1.0, 0.0)


@pytest.mark.parametrize("offset", [0.0, 0.02])
def test_out_of_contact_it_goes_home(make_inputs: Make, offset: float) -> None:
    gains = recentring.Gains(rate=0.5, offset=offset)
    state = recentring.State(1.0, 0.0)
    at = make_inputs(reference={"reach": 1.05})
    new, _, _ = recentring.step(gains, state, at, LIMITS)
    assert new.reach - 1.0 == pytest.approx(0.5 * (0.05 + offset) * DT)
    for _ in range(6000):
        state, _, _ = recentring.step(gains, state, at, LIMITS)
    assert state.reach == pytest.approx(1.05 + offset, abs=1e-4)
