"""The contact law of the preset `following`: where the surface leads, and how fast to go."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base.errors import ConfigError
from skylimb.base.packing import numeric
from skylimb.base.rotations import rotation_from_rpy
from skylimb.control.contact.laws import following
from skylimb.control.contact.lead import BRAKES, NEAR, SURE
from skylimb.control.contact.machine import (
    APPROACH,
    CLEAR,
    FREE,
    LOST,
    RECONTACT,
    RETREAT,
    SETTLE,
    SLIDE,
    MachineGains,
    MachineState,
)
from skylimb.control.estimation.records import Start
from skylimb.control.estimation.surface import SurfaceState, follow_surface
from skylimb.control.missions.reference import zero_reference
from skylimb.control.needs import Needs
from skylimb.control.press import EASED, LOADING, PLAIN, SEARCHING, WAITING
from skylimb.control.records import ContactView, LawInput
from skylimb.robots.description import GRAVITY

DT = 0.005
TURN = rotation_from_rpy(0.2, -0.3, 0.8)
A, U, V = TURN.T
"""Contact axis and sliding axes of the task in these tests."""
ARM = 1.1 * A + 0.05 * V
GAINS = following.Gains(
    approach_speed=0.04,
    approach_ramp=0.8,
    retreat_speed=0.12,
    axis_speed=0.02,
    least_pace=0.3,
    path_acceleration=0.05,
    wait_beyond=0.06,
    body_share=0.4,
    ease_beyond=(0.015, 0.04),
    least_ease=0.2,
    machine=MachineGains(rest_time=0.5),
)
Make = Callable[..., LawInput]


def task(*parts: float) -> np.ndarray:
    """A vector from its parts along contact axis and sliding axes."""
    return TURN @ np.array(parts)


def at_state(now: float, slope: tuple[float, float] = (0.0, 0.0), **changes: Any) -> following.State:
    """In a state of the machine for a while already; the pace has been the mission's own."""
    surface = SurfaceState()
    surface = surface._replace(estimate=np.array([1.1, *slope]), place=np.array([0.0, 0.05]))
    state = following.State(MachineState()._replace(state=now, since=0.3), surface, 1.1, 1.1, 0.0, 1.0, 0.0)
    return state._replace(**changes)


@pytest.fixture(scope="module")
def look(make_inputs: Make) -> Callable[..., tuple[following.State, ContactView, dict[str, Any]]]:
    """One step with the tip on its path, pressed with 1 N, while the mission wants touch."""

    def step(state: following.State, gains: Any = GAINS, **given: Any) -> Any:
        reference = {
            "contact_axis": A,
            "sliding_axis": U,
            "tip_position": ARM,
            "touch": 1.0,
            **given.pop("reference", {}),
        }
        usual = {"arm": ARM, "force": -A, "contact_force": -1.0}
        return following.step(numeric(gains), state, make_inputs(**{**usual, **given}, reference=reference))

    return step


def test_it_begins_in_the_air_at_the_missions_pace(make_start: Callable[..., Start]) -> None:
    state = following.initial_state(GAINS, make_start())
    assert state.machine == MachineState()
    assert state[2:7] == (0.0, 0.0, 0.0, 1.0, 0.0)
    assert following.needs(GAINS) == Needs(paced=True, supervised=True)


def test_the_tip_is_where_body_and_arm_put_it(look: Any) -> None:
    _, _, signals = look(at_state(SLIDE), position=task(0.1, 0.2, 0.3))
    np.testing.assert_allclose(signals["tip_position_estimate"], ARM + task(0.1, 0.2, 0.3), atol=1e-12)
    assert set(signals) == {
        "pace", "contact_state", "contact_reason", "normal_force_estimate", "surface_slope_estimate",
        "tip_position_estimate", "surface_gone",
    }  # fmt: skip


def test_the_distances_that_ease_are_in_order() -> None:
    for wrong in ((0.04, 0.02), (0.02, 0.02)):
        with pytest.raises(ConfigError, match="ease_beyond"):
            following.Gains(ease_beyond=wrong)


def test_it_says_why_it_presses_as_it_does(look: Any) -> None:
    def reason(state: float, behind: float = 0.0, **gains: Any) -> float:
        return float(
            look(at_state(state), replace(GAINS, **gains), position=task(0.0, behind, 0.0))[1].reason
        )

    assert [reason(state) for state in (FREE, SLIDE, SETTLE, RETREAT)] == [SEARCHING, PLAIN, WAITING, PLAIN]
    assert {reason(state) for state in (APPROACH, LOST, RECONTACT)} == {SEARCHING}
    assert reason(SLIDE, behind=0.03, least_ease=0.2) == EASED
    # A pen that lags by less than what eases, and one that presses on, is not eased.
    assert reason(SLIDE, behind=0.01, least_ease=0.2) == reason(SLIDE, behind=0.03, least_ease=1.0) == PLAIN


def test_a_pen_eases_by_its_way_ahead_only_where_that_is_wanted(look: Any) -> None:
    def ease(ahead: float, across: float, share: float) -> float:
        gains, moving = replace(GAINS, ease_ahead=share), {"tip_velocity": task(0.0, 0.08, 0.0)}
        return float(
            look(at_state(SLIDE), gains, position=task(0.0, ahead, across), reference=moving)[1].ease
        )

    # Behind its path and beside it a pen eases as ever; ahead of it by that share alone.
    assert ease(-0.03, 0.0, 0.0) == ease(-0.03, 0.0, 1.0) == ease(0.03, 0.0, 1.0) < 1.0
    assert ease(0.0, 0.03, 0.0) == ease(0.0, 0.03, 1.0) < 1.0
    assert ease(0.03, 0.0, 0.0) == 1.0
    np.testing.assert_allclose(ease(0.03, 0.03, 0.0), ease(0.0, 0.03, 1.0), atol=1e-4)


# ---- what the machine is shown ----


@pytest.mark.parametrize(("share", "state"), [(0.11, APPROACH), (-0.13, FREE), (0.13, FREE)])
def test_a_robot_whose_thrust_is_far_off_does_not_approach(look: Any, share: float, state: float) -> None:
    found, _, _ = look(at_state(FREE), bias_force=np.array([1.0, 1.0, share * 4.0 * GRAVITY]))
    assert found.machine.state == state


def test_the_machine_sees_force_and_places(look: Any) -> None:
    """A touch by the raw force, a loss by the smooth one, and how far beyond and sunk the tip is wanted."""
    touched, _, signals = look(at_state(APPROACH, machine=at_state(APPROACH).machine._replace(strong=0.012)))
    assert touched.machine.state == signals["contact_state"] == SETTLE
    weak = at_state(SLIDE).machine._replace(weak=0.199)
    lost, _, _ = look(at_state(SLIDE, machine=weak), contact_force=-0.1)
    assert lost.machine.state == LOST
    kept, _, signals = look(at_state(SLIDE, machine=weak), contact_force=-0.9, force=0.0 * A)
    assert kept.machine.state == signals["contact_state"] == SLIDE
    missed, _, signals = look(at_state(APPROACH, axis_position=1.1 + 0.26), force=0.0 * A)
    assert missed.machine.state == RETREAT
    assert signals["contact_reason"] == missed.machine.reason
    slid = at_state(RECONTACT).machine._replace(slid=1.0)
    sunk, _, _ = look(at_state(RECONTACT, machine=slid, axis_position=1.25, lost_at=1.14), force=0.0 * A)
    assert sunk.machine.state == RETREAT
    still, _, _ = look(at_state(RECONTACT, machine=slid, axis_position=1.25, lost_at=1.16), force=0.0 * A)
    assert still.machine.state == RECONTACT


@pytest.mark.parametrize(("off", "state"), [(0.0, FREE), (0.0009, FREE), (-0.0009, FREE), (0.002, RETREAT)])
def test_a_retreat_ends_where_the_mission_has_the_tip(look: Any, off: float, state: float) -> None:
    found, _, _ = look(at_state(RETREAT, axis_position=1.1 + off), reference={"touch": 0.0})
    assert found.machine.state == state


# ---- along the contact axis ----


def test_free_the_tip_goes_with_the_mission(look: Any) -> None:
    reference = {"touch": 0.0, "tip_velocity": task(0.03, 0.1, 0.0), "tip_position": ARM + 0.02 * A}
    state, view, _ = look(at_state(FREE, axis_position=1.0), reference=reference)
    assert view.engaged == 0.0
    assert view.axis_position == state.axis_position == pytest.approx(1.12)
    assert view.axis_velocity == pytest.approx(0.03)


@pytest.mark.parametrize(("off", "speed"), [(0.2, 0.12), (-0.03, -0.1), (0.004, None)])
def test_free_the_tip_goes_softly_to_a_mission_that_has_left_it(
    look: Any, off: float, speed: float | None
) -> None:
    """As where a supervisor breaks a lift off: what counts next is the mission's place alone."""
    state = at_state(FREE, axis_position=1.1 - off)
    state = state._replace(machine=state.machine._replace(reason=CLEAR))
    found, view, _ = look(state, reference={"touch": 0.0, "tip_velocity": 0.03 * A})
    assert view.axis_velocity == pytest.approx(0.03 if speed is None else speed)
    assert found.axis_position == pytest.approx(1.1 if speed is None else 1.1 - off + speed * DT)


def over_a_surface(now: float, **changes: Any) -> following.State:
    """Above a surface that leans by 0.2 along u; the tip touched it at 1.1 m along the axis."""
    surface = SurfaceState(np.array([1.1, 0.2, 0.0]), np.diag([1e-6, 1e-4, 1e-4]))
    usual = {"surface": surface, "touched": np.array([0.0, 0.05]), "known": 1.0, "axis_position": 1.05}
    return at_state(now, **usual | changes)


LIFTED = {"touch": 0.0, "clearance": 0.05, "tip_position": ARM - 0.2 * A}


@pytest.mark.parametrize("toward", [-0.08, 0.0, 0.08])
def test_a_lifted_pen_keeps_the_clearance_to_a_surface_that_it_knows(look: Any, toward: float) -> None:
    """Below the pen and where it will be soon, less two deviations; the mission would go out by 200 mm."""
    soon = zero_reference(1, 1)._replace(tip_position=ARM - 0.2 * A + toward * U)
    state, (there, deviation) = over_a_surface(RETREAT), (1.1 + 0.2 * toward, 0.0)
    deviation = (1e-6 + 1e-4 * toward**2 + GAINS.surface.drift * abs(toward) ** 3) ** 0.5
    wanted = min(1.1 - SURE * 1e-3, there - SURE * deviation) - 0.05
    inputs = {"reference": {**LIFTED, "ahead": (soon,)}, "force": 0.0 * A, "contact_force": 0.0}
    for _ in range(299):
        state, _, _ = look(state, **inputs)
    state, view, _ = look(state, **inputs)
    assert state.machine.state == FREE
    assert state.axis_position == pytest.approx(wanted, abs=2e-3)
    assert view.axis_velocity == pytest.approx(0.0, abs=0.01)


def test_no_lift_goes_further_out_than_the_mission_says(look: Any) -> None:
    doubtful = over_a_surface(RETREAT)
    doubtful = doubtful._replace(surface=doubtful.surface._replace(covariance=np.eye(3)))
    unknown = over_a_surface(RETREAT, known=0.0)
    plain = LIFTED | {"clearance": 0.0}
    for before, reference in ((doubtful, LIFTED), (unknown, LIFTED), (over_a_surface(RETREAT), plain)):
        state = before
        for _ in range(300):
            state, _, _ = look(state, reference=reference, force=0.0 * A, contact_force=0.0)
        assert state.machine.state == FREE
        assert state.axis_position == pytest.approx(0.9, abs=1e-3)


@pytest.mark.parametrize(("since", "share"), [(0.0, 0.0), (0.4, 0.5), (2.0, 1.0)])
@pytest.mark.parametrize("searching", [APPROACH, RECONTACT])
def test_the_tip_looks_for_the_surface_gathering_speed(
    look: Any, searching: float, since: float, share: float
) -> None:
    machine = at_state(searching).machine._replace(since=since - DT)
    state, view, _ = look(at_state(searching, machine=machine), force=0.0 * A, contact_force=0.0)
    assert state.machine.state == searching
    assert view.axis_velocity == pytest.approx(share * 0.04)
    assert view.axis_position == pytest.approx(1.1 + share * 0.04 * DT)


def test_a_surface_that_it_knows_is_approached_faster_until_it_is_near(look: Any) -> None:
    """It lies 1.1 m along the axis where the tip touched last, and may be anywhere within its variance."""
    gains = replace(GAINS, return_speed=0.1)
    sure = SurfaceState(np.array([1.1, 0.2, 0.0]), 1e-6 * np.eye(3))

    def velocity(
        at: float, known: float = 1.0, aside: float = 0.0, state: float = APPROACH, **own: Any
    ) -> float:
        given = {"surface": sure, "touched": np.array([0.0, 0.05]), **own}
        before = at_state(state, axis_position=at, known=known, **given)
        before = before._replace(machine=before.machine._replace(since=2.0))
        _, view, _ = look(before, gains, force=0.0 * A, position=task(0.0, aside, 0.0))
        return float(view.axis_velocity)

    assert velocity(0.8) == pytest.approx(0.1)
    assert velocity(0.8, known=0.0) == velocity(0.8, state=RECONTACT) == pytest.approx(0.04)
    near = 1.1 - NEAR - SURE * 1e-3
    assert velocity(near) == velocity(1.2) == pytest.approx(0.04)
    assert velocity(near - 0.03) == pytest.approx(0.04 + 0.03 / BRAKES)
    # Aside the slope and what it may have changed count; a surface that was seen badly is near from afar.
    further = 0.2 * 0.1 - SURE * (1e-6 * 1.01 + GAINS.surface.drift * 0.1**3) ** 0.5
    assert velocity(near - 0.03, aside=0.1) == pytest.approx(
        0.04 + max(0.03 + SURE * 1e-3 + further, 0.0) / BRAKES, rel=1e-6
    )
    assert velocity(0.9, surface=sure._replace(covariance=0.1**2 * np.eye(3))) == pytest.approx(0.04)


def test_a_surface_is_known_once_the_pen_has_slid_until_nothing_is_there(look: Any) -> None:
    assert look(at_state(SETTLE))[0].known == 0.0
    slid = look(at_state(SLIDE))[0]
    assert slid.known == 1.0
    np.testing.assert_allclose(slid.touched, [0.0, 0.05], atol=1e-12)
    missed = look(at_state(APPROACH, axis_position=1.1 + 0.26, known=1.0), force=0.0 * A)[0]
    assert missed.machine.given_up == 1.0
    assert missed.known == 0.0


def test_lost_it_holds_still(look: Any) -> None:
    state, view, _ = look(at_state(LOST, axis_position=1.13), force=0.0 * A)
    assert (state.machine.state, view.engaged) == (LOST, 0.0)
    assert (view.axis_position, view.axis_velocity) == (1.13, 0.0)


@pytest.mark.parametrize(("off", "velocity"), [(0.2, -0.12), (-0.2, 0.12), (0.0012, -0.12)])
def test_it_retreats_at_its_speed(look: Any, off: float, velocity: float) -> None:
    state, view, _ = look(at_state(RETREAT, axis_position=1.1 + off), reference={"touch": 0.0})
    assert state.machine.state == RETREAT
    assert view.axis_velocity == pytest.approx(velocity)
    assert view.axis_position == pytest.approx(1.1 + off + velocity * DT)


def test_in_contact_the_tips_place_is_kept_and_so_is_that_of_a_loss(look: Any) -> None:
    state, view, _ = look(at_state(SLIDE, axis_position=0.3, lost_at=0.7), position=task(0.02, 0.0, 0.0))
    assert view.engaged == 1.0
    assert view.axis_position == pytest.approx(1.12)
    assert state.lost_at == 0.7
    weak = at_state(SLIDE).machine._replace(weak=0.3)
    lost, _, _ = look(at_state(SLIDE, machine=weak), position=task(0.02, 0.0, 0.0), contact_force=0.0)
    assert lost.lost_at == pytest.approx(1.12)
    later, _, _ = look(lost, force=0.0 * A, position=task(0.04, 0.0, 0.0))
    assert later.lost_at == pytest.approx(1.12)


def test_the_anchor_is_the_body_until_contact_and_then_carried_along(look: Any) -> None:
    where = {"position": task(0.07, 0.0, 0.0), "reference": {"tip_velocity": task(0.0, 0.1, -0.05)}}
    free, view, _ = look(at_state(APPROACH), force=0.0 * A, **where)
    assert view.anchor == free.anchor == pytest.approx(0.07)
    touch = at_state(APPROACH).machine._replace(strong=1.0)
    fresh, view, _ = look(at_state(APPROACH, machine=touch, anchor=5.0), **where)
    assert fresh.machine.state == SETTLE
    assert view.anchor == pytest.approx(0.07)
    carried, view, _ = look(at_state(SLIDE, slope=(0.2, 0.6), anchor=0.3), **where)
    slope = carried.surface.estimate[1:]
    assert view.surface_velocity == pytest.approx(slope[0] * 0.1 - slope[1] * 0.05)
    assert view.anchor == carried.anchor == pytest.approx(0.3 + 0.4 * view.surface_velocity * DT)
    air, view, _ = look(at_state(LOST, slope=(0.2, 0.6)), force=0.0 * A, **where)
    assert (air.machine.state, view.surface_velocity) == (LOST, 0.0)


# ---- the surface ----


@given(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8), st.floats(-2.0, 2.0))
def test_friction_drops_out_of_the_normal_force(look: Any, s_u: float, s_v: float, rub: float) -> None:
    """A force of 1.7 N along the normal, and any in the surface."""
    normal = -task(1.0, -s_u, -s_v) / np.sqrt(1.0 + s_u**2 + s_v**2)
    in_surface = task(s_u + 0.5 * s_v, 1.0, 0.5)
    assert abs(normal @ in_surface) < 1e-12
    state = at_state(SLIDE, slope=(s_u, s_v))
    _, view, signals = look(state, force=1.7 * normal + rub * in_surface, contact_force=-1.0)
    assert view.normal_force == signals["normal_force_estimate"] == pytest.approx(1.7)


def test_the_surface_is_followed_as_the_tip_goes(look: Any) -> None:
    """What the filter is told: place in the task's frame, whether it touches, and what the force shows."""
    s = np.array([0.25, -0.4])
    path, position = np.array([0.06, 0.08]), task(0.02, 0.01, -0.03)
    speed = np.hypot(*path)
    along, across = path / speed, np.array([-path[1], path[0]]) / speed
    normal = -np.array([1.0, -s[0], -s[1]])
    tangent = np.array([s @ along, *along])
    force = TURN @ (1.5 * normal - 0.6 * tangent)
    seen = (across @ (TURN.T @ force)[1:]) / (A @ force)
    place = TURN.T @ (position + ARM)
    before = at_state(SLIDE, slope=(0.1, 0.2))
    state, _, signals = look(
        before, position=position, force=force, reference={"tip_velocity": task(0.0, *path)}
    )
    shown = np.array([*across, seen])
    wanted = follow_surface(numeric(GAINS.surface), before.surface, place, 1.0, 0.0, np.zeros(2), shown, DT)
    np.testing.assert_allclose(state.surface.estimate, wanted.estimate, atol=1e-9)
    np.testing.assert_allclose(state.surface.covariance, wanted.covariance, atol=1e-9)
    slope = state.surface.estimate[1:]
    np.testing.assert_allclose(signals["surface_slope_estimate"], slope[0] * U + slope[1] * V, atol=1e-12)


@pytest.mark.parametrize(
    ("contact_force", "pressed", "touching", "known"),
    [(-1.0, 1.0, 1.0, 1.0), (-0.2, 1.0, 0.0, 1.0), (-0.3, 1.0, 1.0, 1.0), (-1.0, 0.2, 1.0, 0.0)],
)
def test_a_weak_touch_teaches_nothing(
    look: Any, contact_force: float, pressed: float, touching: float, known: float
) -> None:
    before = at_state(SLIDE, slope=(0.1, 0.2))
    force = TURN @ np.array([-pressed, 0.1, 0.3])
    state, _, _ = look(
        before,
        force=force,
        contact_force=contact_force,
        position=task(0.01, 0.002, 0.0),
        reference={"tip_velocity": task(0.0, 0.05, 0.0)},
    )
    shown = np.array([0.0, known, 0.3 / -max(pressed, 0.3)])
    place = TURN.T @ (ARM + task(0.01, 0.002, 0.0))
    wanted = follow_surface(
        numeric(GAINS.surface), before.surface, place, touching, 0.0, np.zeros(2), shown, DT
    )
    np.testing.assert_allclose(state.surface.estimate, wanted.estimate, atol=1e-9)


def test_a_fresh_touch_is_taken_as_it_is_and_a_slow_path_shows_less(look: Any) -> None:
    machine = at_state(APPROACH).machine._replace(strong=1.0)
    state, _, _ = look(at_state(APPROACH, machine=machine), position=task(0.2, 0.0, 0.0), contact_force=0.0)
    assert state.surface.estimate[0] == pytest.approx(1.3, abs=1e-3)
    slow = {"tip_velocity": task(0.0, 0.01, 0.0)}
    before = at_state(SLIDE, slope=(0.1, 0.2))
    state, _, _ = look(before, force=TURN @ [-1.0, 0.0, 0.5], position=task(0.0, 0.01, 0.0), reference=slow)
    place = TURN.T @ (ARM + task(0.0, 0.01, 0.0))
    shown = np.array([0.0, 0.5, -0.5])
    wanted = follow_surface(numeric(GAINS.surface), before.surface, place, 1.0, 0.0, np.zeros(2), shown, DT)
    np.testing.assert_allclose(state.surface.estimate, wanted.estimate, atol=1e-7)


# ---- pace ----

WAIT = {"touch": 1.0, "wait": 1.0, "tip_velocity": task(0.0, 0.1, 0.0)}


def paced(look: Any, state: following.State, reference: dict[str, Any] = WAIT, **given: Any) -> Any:
    state, view, signals = look(state, reference=reference, **given)
    assert state.pace == signals["pace"]
    return state, view, float(signals["pace"])


def test_the_mission_waits_for_touch_unless_it_was_given_up(look: Any) -> None:
    for machine in (FREE, APPROACH, SETTLE, LOST, RECONTACT):
        _, _, pace = paced(look, at_state(machine, speed=1.0), force=0.0 * A)
        assert pace == 0.0
    given_up = at_state(FREE).machine._replace(given_up=1.0)
    _, _, pace = paced(look, at_state(FREE, machine=given_up, speed=1.0))
    assert pace == 1.0
    _, _, pace = paced(look, at_state(SLIDE, speed=1.0))
    assert pace == 1.0
    _, _, pace = paced(look, at_state(APPROACH, pace=0.2), {**WAIT, "wait": 0.0})
    assert pace == 1.0


@pytest.mark.parametrize(("slope", "pace"), [(0.1, 1.0), (0.2, 1.0), (0.4, 0.5), (-0.4, 0.5), (3.0, 0.3)])
def test_a_surface_that_comes_fast_slows_the_path(look: Any, slope: float, pace: float) -> None:
    """At 0.1 m/s a slope of 0.2 makes the 0.02 m/s that are allowed along the axis; 0.3 is the least pace."""
    before = at_state(SLIDE, slope=(min(max(slope, -2.0), 2.0), 0.0), pace=pace, speed=1.0)
    _, view, found = paced(look, before, {**WAIT, "tip_velocity": task(0.0, 0.1 * pace, 0.0)})
    allowed = 0.02 * pace / max(abs(view.surface_velocity), 1e-9)
    assert found == pytest.approx(min(max(allowed, 0.3), 1.0), rel=1e-3)
    assert found == pytest.approx(pace, rel=0.02)


@pytest.mark.parametrize(
    ("behind", "share"), [(0.0, 1.0), (0.03, 1.0), (0.045, 0.5), (0.06, 0.1), (0.5, 0.1)]
)
def test_the_path_waits_for_a_pen_that_is_behind(look: Any, behind: float, share: float) -> None:
    reference = {
        **WAIT,
        "tip_position": ARM + behind * task(0.3, 0.6, 0.8),
        "tip_velocity": task(0.0, 1e-3, 0.0),
    }
    _, _, pace = paced(look, at_state(SLIDE, pace=share, speed=1.0), reference)
    assert pace == pytest.approx(share, rel=1e-3)


def test_the_path_gathers_and_loses_speed_no_faster_than_it_may(look: Any) -> None:
    """From 0.02 m/s: at most 0.05 m/s^2 more or less, in shares of the 0.1 m/s that the mission has."""
    change = 0.05 * DT
    slow = {**WAIT, "tip_velocity": task(0.0, 0.02, 0.0)}
    state, view, pace = paced(look, at_state(SLIDE, pace=0.2, speed=0.02), slow)
    assert view.speed == pytest.approx(0.02)
    assert pace == pytest.approx((0.02 + change) / 0.1, rel=1e-4)
    assert state.speed == pytest.approx(0.02 + change, rel=1e-4)
    fast = {**WAIT, "tip_velocity": task(0.0, 0.1, 0.0)}
    state, _, pace = paced(look, at_state(SLIDE, slope=(1.5, 0.0), speed=0.1), fast)
    assert pace == pytest.approx(1.0 - change / 0.1, rel=1e-4)
    assert state.speed == pytest.approx(0.1 - change, rel=1e-4)


def test_a_path_that_stood_still_gathers_speed_from_nothing(look: Any) -> None:
    crawling = {**WAIT, "tip_velocity": task(0.0, 0.0, 0.0)}
    _, view, pace = paced(look, at_state(SLIDE, pace=0.0, speed=0.0), crawling)
    assert view.speed == 0.0
    assert 0.0 < pace <= 1.0
    creeping = {**WAIT, "tip_velocity": task(0.0, 0.03 * 0.1, 0.04 * 0.1)}
    _, view, pace = paced(look, at_state(SLIDE, pace=0.05, speed=0.0), creeping)
    assert view.speed == pytest.approx(0.005)
    assert pace == pytest.approx(0.05 * DT * 0.05 / 0.005, rel=1e-3)


# ---- easing ----


@pytest.mark.parametrize(
    ("behind", "ease"), [(0.0, 1.0), (0.015, 1.0), (0.0275, 0.5), (0.035, 0.2), (0.2, 0.2)]
)
def test_a_pen_that_stays_behind_presses_less(look: Any, behind: float, ease: float) -> None:
    reference = {"tip_position": ARM + behind * task(0.0, 0.6, -0.8) + 0.3 * A}
    _, view, _ = look(at_state(SLIDE), reference=reference)
    assert view.ease == pytest.approx(ease)
    _, view, _ = look(at_state(LOST), force=0.0 * A, reference=reference)
    assert view.ease == 1.0


@pytest.mark.parametrize(
    ("force", "grows", "further"),
    [
        *(
            (0.4, 2.0, 1.0),
            (1.0, 2.0, 1.0),
            (1.5, 2.0, 1.5),
            (2.0, 2.0, 2.0),
            (3.0, 2.0, 4 / 3),
            (5.0, 2.0, 1.0),
        ),
        *((1.5, 3.0, 1.5), (2.0, 3.0, 2.0), (3.0, 3.0, 3.0), (4.0, 3.0, 2.25), (9.0, 3.0, 1.0)),
    ],
)
def test_who_presses_harder_lets_the_pen_stay_further_behind(
    look: Any, force: float, grows: float, further: float
) -> None:
    """As friction does; force times distance stays beyond a force."""
    gains = replace(GAINS, ease_grows=grows)
    for behind, ease in ((0.015, 1.0), (0.0275, 0.5), (0.04, 0.2)):
        state = at_state(SLIDE, loaded=10.0)
        _, view, _ = look(state, gains, wanted=force, position=task(0.0, further * behind, 0.0))
        assert float(view.ease) == pytest.approx(ease, abs=1e-9)


@pytest.mark.parametrize("force", [1.0, 2.0])
def test_a_press_of_up_to_two_newtons_comes_at_once(look: Any, force: float) -> None:
    _, view, _ = look(at_state(SETTLE), replace(GAINS, growth=1.0), wanted=force)
    assert (view.ramp, view.ease, view.reason) == (1.0, 1.0, WAITING)


def test_a_harder_press_grows_from_two_newtons(look: Any) -> None:
    gains = replace(GAINS, growth=1.0)
    state, view, _ = look(at_state(SETTLE, loaded=0.5), gains, wanted=5.0)
    assert state.loaded == pytest.approx(0.5 + DT)
    assert view.ramp == view.ease == pytest.approx((2.5 + DT) / 5.0)
    assert view.reason == LOADING
    _, view, _ = look(at_state(SLIDE, loaded=3.0), gains, wanted=5.0)
    assert (view.ramp, view.reason) == (1.0, PLAIN)
    # Out of touch it begins anew, and what is commanded then is whole.
    state, view, _ = look(at_state(LOST, loaded=3.0), gains, wanted=5.0, force=0.0 * A)
    assert (state.loaded, view.ramp) == (0.0, 1.0)


def test_the_machine_gets_the_laws_own_gains(look: Any) -> None:
    gains = following.Gains(machine=MachineGains(settle_time=0.2))
    state, _, _ = look(at_state(SETTLE), gains)
    assert state.machine.state == SLIDE


@pytest.mark.parametrize(
    ("deeper", "felt", "gone"),
    [(0.008, 0.2, 1.0), (0.008, 0.44, 0.5), (0.0045, 0.2, 0.5), (0.008, 0.6, 0.0), (0.002, 0.0, 0.0)],
)
def test_a_surface_has_gone_where_the_tip_goes_on_and_feels_little(
    look: Any, deeper: float, felt: float, gone: float
) -> None:
    before = at_state(SLIDE, place=np.array([1.1, 0.0, 0.05]), pressed=1.0)
    state, view, signals = look(before, position=task(deeper, 0.02, 0.0), force=-felt * A)
    assert state.sunk == pytest.approx(deeper, abs=1e-5)
    assert view.gone == signals["surface_gone"] == pytest.approx(gone, abs=0.02)
    # What is no touch says nothing of the surface, and a new touch begins anew.
    assert (state.surface.estimate[0] == before.surface.estimate[0]) == (felt < 0.3)
    assert look(state._replace(machine=at_state(LOST).machine))[0].sunk == 0.0


def test_a_slope_that_is_known_is_no_way_into_the_surface(look: Any) -> None:
    before = at_state(SLIDE, slope=(0.2, 0.0), place=np.array([1.1, 0.0, 0.05]), pressed=1.0)
    state, view, _ = look(before, position=task(0.004, 0.02, 0.0), force=-0.1 * A)
    assert (state.sunk, view.gone) == pytest.approx((0.0, 0.0), abs=1e-4)
