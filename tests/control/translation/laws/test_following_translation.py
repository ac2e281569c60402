"""The translation law of the preset `following`, in the frame of the task and in numbers."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from law_records import IN_THE_AIR
from skylimb.base.packing import numeric
from skylimb.base.rotations import rotation_from_rpy
from skylimb.base.signal_table import PLACE_TERMS
from skylimb.control.estimation.records import Start, Wrench
from skylimb.control.press import EASED, PLAIN, SATURATED, SEARCHING, UNLOADING, WAITING
from skylimb.control.records import ArmTarget, LawInput
from skylimb.control.translation.laws import following
from skylimb.control.translation.tank import Pressed
from skylimb.robots.description import GRAVITY

DT, MASS = 0.005, 4.0
MODEL: Any = SimpleNamespace(mass=MASS, gravity=np.array([0.0, 0.0, GRAVITY]))
X, Y, Z = np.eye(3)
ARM = np.array([1.09, 0.0, 0.1])
GAINS = following.Gains(
    stiffness=(5.0, 8.0, 6.0),
    damping_ratio=(0.8, 0.7, 0.9),
    press_mass_ratio=1.0,
    cancel=(0.5, 0.8),
    cancel_cutoff=(5.0, 2.0),
    force_integral=2.0,
)
ENGAGED = IN_THE_AIR._replace(engaged=1.0, normal_force=1.0)
CALM = {"force": -X, "arm": ARM, "reference": {"tip_position": ARM}}
"""At rest on the path, pushed back with the wanted force."""

Make = Callable[..., LawInput]


def step(at: LawInput, gains: Any = GAINS, state: Any = None) -> tuple[Any, np.ndarray, np.ndarray]:
    """State, force less weight, and target."""
    state = pressing(0.0, GAINS.tank) if state is None else state
    state, force, signals = following.step(numeric(gains), state, at)
    assert list(signals) == [
        "cog_position_target", "contact_force_reference", "contact_force_target", "contact_force_integral",
        "press_reason", *PLACE_TERMS,
    ]  # fmt: skip
    # Springs and dampers, and the integral, are of what it commands.
    along = at.reference.contact_axis
    told = MASS * signals["place_integral"]
    np.testing.assert_allclose(told, signals["contact_force_integral"] * along, atol=1e-12)
    return state, force - np.array([0.0, 0.0, MASS * GRAVITY]), signals["cog_position_target"]


def pressing(integral: float, tank: float, carried: float = 0.0) -> following.State:
    """A state of that press, at rest."""
    return following.State(Pressed(integral, tank, carried), np.zeros(2), np.zeros(3))


def test_it_begins_without_integral_and_with_a_full_tank(make_start: Callable[..., Start]) -> None:
    state = following.initial_state(
        following.Gains(GAINS.stiffness, GAINS.damping_ratio, tank=0.7), make_start()
    )
    assert (state.press, state.rubbing.tolist()) == ((0.0, 0.7, 0.0), [0.0, 0.0])


def test_at_rest_with_the_wanted_force_it_pushes_with_that_force_and_carries_the_weight(
    make_inputs: Make,
) -> None:
    state, force, target = step(make_inputs(contact=ENGAGED, **CALM))
    np.testing.assert_allclose(force, X, atol=1e-12)
    np.testing.assert_allclose(target, np.zeros(3), atol=1e-12)
    assert state.press.integral == 0.0
    assert state.press.tank == pytest.approx(GAINS.tank)


def test_an_eased_contact_is_pressed_with_less_and_asks_for_less(make_inputs: Make) -> None:
    eased = ENGAGED._replace(normal_force=0.3, ease=0.3)
    state, force, _ = step(make_inputs(contact=eased, **{**CALM, "force": -0.3 * X}))
    np.testing.assert_allclose(force, 0.3 * X, atol=1e-12)
    assert state.press.integral == pytest.approx(0.0, abs=1e-12)


def test_it_tells_which_force_is_commanded_and_what_it_presses_with(make_inputs: Make) -> None:
    eased = ENGAGED._replace(normal_force=0.1, ease=0.3)

    def told(contact: Any, touch: float, tank: float = 0.5) -> list[float]:
        at = make_inputs(contact=contact, **{**CALM, "reference": {"tip_position": ARM, "touch": touch}})
        state = pressing(2.0, tank)
        signals = following.step(numeric(GAINS), state, at)[2]
        return [float(signals[name]) for name in list(signals)[1:5]]

    integral = 2.0 + 2.0 * (0.3 - 0.1) * DT
    assert told(eased, 1.0) == pytest.approx([1.0, 0.3, integral, PLAIN])
    assert told(eased._replace(ramp=0.5), 1.0)[0] == 0.5
    # Searching for the surface: the force is commanded still, but nothing presses; and nothing is commanded.
    searching = IN_THE_AIR._replace(reason=SEARCHING)
    assert told(searching, 1.0) == [1.0, 0.0, 0.0, SEARCHING]
    assert told(searching, 0.0)[0] == 0.0


def test_it_is_saturated_where_nothing_else_is_the_reason(make_inputs: Make) -> None:
    """By its integral, its energy, or rotors that fall short; not while it presses less by its own will."""

    def reason(said: float = PLAIN, integral: float = 0.0, tank: float = 0.5, short: float = 0.0) -> float:
        view = ENGAGED._replace(reason=said)
        at = make_inputs(contact=view, **CALM)._replace(residual=Wrench(short * X, np.zeros(3)))
        state = pressing(integral, tank)
        return float(following.step(numeric(GAINS), state, at)[2]["press_reason"])

    assert reason() == PLAIN
    for limited in ({"integral": 9.0}, {"tank": 0.1}, {"short": 0.2}):
        assert reason(**limited) == reason(WAITING, **limited) == SATURATED
        assert reason(EASED, **limited) == EASED


def test_everything_turns_with_the_task(make_inputs: Make) -> None:
    """A turned task gives the turned force: only the weight has an axis of the world."""
    R = rotation_from_rpy(0.3, -0.4, 1.1)
    rng = np.random.default_rng(1)
    position, velocity, force, tip, moving, bending = 0.1 * rng.normal(size=(6, 3))
    view = ENGAGED._replace(anchor=0.02, surface_velocity=0.01, speed=0.03, normal_force=0.7)
    for contact in (view, view._replace(engaged=0.0, axis_position=1.0, axis_velocity=0.02)):
        found = []
        for turn in (np.eye(3), R):
            at = make_inputs(
                contact=contact,
                commanded_arm=ArmTarget(1.09, 0.03),
                position=turn @ position,
                velocity=turn @ velocity,
                force=turn @ force,
                arm=turn @ ARM,
                reference={
                    "tip_position": turn @ (ARM + tip),
                    "tip_velocity": turn @ moving,
                    "tip_acceleration": turn @ bending,
                    "position": turn @ tip,
                    "contact_axis": turn @ X,
                    "sliding_axis": turn @ Y,
                },
            )
            found.append(step(at)[1:])
        for plain, turned in zip(*found, strict=True):
            np.testing.assert_allclose(turned, R @ plain, atol=1e-12)


# ---- along the sliding axes ----


def test_a_stiff_spring_and_damper_hold_each_sliding_axis(make_inputs: Make) -> None:
    off, moving = np.array([0.0, 0.03, -0.02]), np.array([0.0, 0.1, 0.05])
    bending, drift = np.array([0.0, 0.2, -0.3]), np.array([0.0, 0.04, -0.06])
    reference = {"tip_position": ARM, "tip_velocity": drift, "tip_acceleration": bending}
    at = make_inputs(contact=ENGAGED, force=-X, arm=ARM, position=off, velocity=moving, reference=reference)
    K, D = np.array([0.0, 8.0, 6.0]), 2.0 * np.array([0.0, 0.7 * 8.0**0.5, 0.9 * 6.0**0.5])
    _, force, _ = step(at)
    np.testing.assert_allclose(force[1:], (MASS * (bending - D * (moving - drift) - K * off))[1:], atol=1e-12)


def test_the_damper_counts_the_pens_swing_by_its_shares(make_inputs: Make) -> None:
    gains = replace(GAINS, swing=(0.5, 0.25), swing_cutoff=1e4)
    spin = np.array([0.1, -0.2, 0.3])
    at = make_inputs(contact=ENGAGED, omega=spin, **CALM)
    state, force, _ = step(at, gains)
    swing = np.cross(spin, ARM)
    np.testing.assert_allclose(state.swing, swing, atol=1e-12)
    D = 2.0 * np.array([0.7 * 8.0**0.5, 0.9 * 6.0**0.5])
    np.testing.assert_allclose(force[1:], -MASS * D * np.array([0.5, 0.25]) * swing[1:], atol=1e-12)
    # The path's own speed counts, where the contact law knows it, and half of the swing where it waits.
    for view, share in (
        ({"speed": 0.03, "own_speed": 0.03}, 0.25),
        ({"speed": 0.01, "own_speed": 0.2}, 0.375),
        ({"speed": 0.01, "own_speed": 0.02}, 0.5),
        ({"speed": 0.2, "own_speed": 0.2}, 0.0),
        ({"speed": 0.03, "own_speed": None}, 0.25),
        ({"speed": 0.0, "own_speed": 0.0}, 1.0),
        ({"speed": 0.0, "own_speed": 0.0, "engaged": 0.0}, 0.5),
        ({"speed": 0.0, "own_speed": 0.0, "gone": 1.0}, 0.5),
    ):
        moving = make_inputs(contact=ENGAGED._replace(**view), omega=spin, **CALM)
        _, less, _ = step(moving, replace(gains, swing_speed=0.04))
        np.testing.assert_allclose(less[1:], share * force[1:], atol=1e-12)
    slow, _, _ = step(at, replace(gains, swing_cutoff=1.0))
    np.testing.assert_allclose(slow.swing, (1.0 - np.exp(-2.0 * np.pi * DT)) * swing, atol=1e-12)


def test_at_the_end_of_a_stroke_the_swing_counts_by_shares_of_its_own(make_inputs: Make) -> None:
    gains = replace(GAINS, swing=(0.5, 0.25), leaving_swing=(0.2, 1.0), swing_cutoff=1e4)
    spin = np.array([0.1, -0.2, 0.3])
    damping = MASS * 2.0 * np.array([0.7 * 8.0**0.5, 0.9 * 6.0**0.5]) * np.cross(spin, ARM)[1:]
    for reason, shares in ((PLAIN, (0.5, 0.25)), (UNLOADING, (0.5, 1.0))):
        at = make_inputs(contact=ENGAGED._replace(reason=reason), omega=spin, **CALM)
        np.testing.assert_allclose(step(at, gains)[1][1:], -np.array(shares) * damping, atol=1e-12)


def test_a_landing_cancels_what_is_felt_though_the_path_rests(make_inputs: Make) -> None:
    gains = replace(GAINS, landing_cancel=(0.8, 0.4), cancel_cutoff=(1e4, 1e4))
    felt = np.array([-1.0, 0.4, -0.4])
    for landing, share in ((1.0, 1.0), (0.5, 0.5), (0.0, 0.0)):
        at = make_inputs(contact=ENGAGED._replace(landing=landing), **{**CALM, "force": felt})
        _, force, _ = step(at, gains)
        np.testing.assert_allclose(force[1:], -share * np.array([0.8, 0.4]) * felt[1:], atol=1e-12)


def test_of_an_expected_force_only_what_is_felt_beyond_it_is_cancelled(make_inputs: Make) -> None:
    gains = replace(GAINS, feed=1.0, cancel=(0.5, 0.5), cancel_cutoff=(1e4, 1e4))
    expected, felt = np.array([0.0, 0.3, -0.2]), np.array([-1.0, 0.4, -0.4])
    at = make_inputs(contact=ENGAGED._replace(speed=1.0, across=expected), **{**CALM, "force": felt})
    _, force, _ = step(at, gains)
    np.testing.assert_allclose(force[1:], -(expected + 0.5 * (felt - expected))[1:], atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_spring_pulls_no_harder_beyond_its_limit(make_inputs: Make, sign: float) -> None:
    at = make_inputs(contact=ENGAGED, **{**CALM, "position": sign * np.array([0.0, 5.0, 7.0])})
    _, force, _ = step(at)
    np.testing.assert_allclose(force[1:], -sign * MASS * np.array([0.8, GRAVITY / 2.0]), atol=1e-12)


def test_whichever_spring_carries_the_robot_gives_half_its_weight(make_inputs: Make) -> None:
    off, reference = np.array([0.0, 5.0, -7.0]), {"tip_position": ARM, "sliding_axis": Z}
    at = make_inputs(contact=ENGAGED, **{**CALM, "position": off, "reference": reference})
    _, force, _ = step(at)
    np.testing.assert_allclose(force[1:], MASS * np.array([-0.6, GRAVITY / 2.0]), atol=1e-12)


@pytest.mark.parametrize(("speed", "share"), [(0.0, 0.0), (0.03, 0.5), (0.06, 1.0), (0.5, 1.0)])
def test_friction_is_cancelled_only_as_the_path_moves(make_inputs: Make, speed: float, share: float) -> None:
    rubbed = make_inputs(
        contact=ENGAGED._replace(speed=speed), **{**CALM, "force": np.array([-1.0, -0.4, 0.3])}
    )
    state, once, _ = step(rubbed)
    slow = (1.0 - np.exp(-2.0 * np.pi * np.array([5.0, 2.0]) * DT)) * np.array([-0.4, 0.3])
    np.testing.assert_allclose(state.rubbing, slow, atol=1e-12)
    np.testing.assert_allclose(once[1:], -share * np.array([0.5, 0.8]) * slow, atol=1e-12)
    for _ in range(300):
        state, _, _ = step(rubbed, state=state)
    _, force, _ = step(rubbed, state=state)
    np.testing.assert_allclose(force[1:], -share * np.array([0.5, 0.8]) * np.array([-0.4, 0.3]), atol=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_more_is_cancelled_than_friction_can_give_but_what_is_the_robot_s_own(
    make_inputs: Make, sign: float
) -> None:
    gains = following.Gains(GAINS.stiffness, GAINS.damping_ratio, cancel_limit=0.7, cancel_cutoff=(1e4, 1e4))
    at = make_inputs(
        contact=ENGAGED._replace(speed=1.0), **{**CALM, "force": np.array([-1.0, 3.0 * sign, -4.0 * sign])}
    )
    _, force, _ = step(at, gains)
    # Upright, what no friction gives is a thrust that has changed.
    np.testing.assert_allclose(force[1:], [-0.7 * sign, 4.0 * sign], atol=1e-12)


def test_what_a_harder_press_rubs_with_is_not_taken_for_the_robot_s_own(make_inputs: Make) -> None:
    """Friction grows with the force: at 3 N up to three times the limit may be of the contact."""
    gains = following.Gains(GAINS.stiffness, GAINS.damping_ratio, cancel_limit=0.7, cancel=(0.0, 0.0))
    for up, own in ((2.0, 0.0), (3.1, 1.0)):
        at = make_inputs(contact=ENGAGED, wanted=3.0, **{**CALM, "force": np.array([-3.0, 0.0, -up])})
        _, force, _ = step(at, gains)
        assert force[2] == pytest.approx(own, abs=1e-12)


@pytest.mark.parametrize(("wanted", "factor"), [(1.0, 1.0), (2.0, 1.0), (3.0, 1.25), (5.0, 1.75)])
def test_the_sliding_springs_grow_with_a_hard_press(make_inputs: Make, wanted: float, factor: float) -> None:
    def pulls(stiffening: float) -> np.ndarray:
        gains = following.Gains(GAINS.stiffness, GAINS.damping_ratio, stiffening=stiffening)
        at = make_inputs(contact=ENGAGED, wanted=wanted, position=np.array([0.0, 0.03, 0.0]), **CALM)
        return step(at, gains)[1]

    assert pulls(0.5)[1] == pytest.approx(factor * pulls(0.0)[1])
    assert pulls(0.0)[1] < 0.0


# ---- where the centre of gravity is led ----


@pytest.mark.parametrize("pen", [0.0, 0.25, 1.0])
def test_the_centre_of_gravity_stands_behind_the_tips_reference(make_inputs: Make, pen: float) -> None:
    gains = following.Gains(GAINS.stiffness, GAINS.damping_ratio, pen=pen)
    tip, own = ARM + np.array([0.0, 0.05, -0.02]), np.array([0.3, -0.1, 0.2])
    at = make_inputs(
        contact=ENGAGED._replace(anchor=0.15), arm=ARM, reference={"tip_position": tip, "position": own}
    )
    target = following.cog_target(numeric(gains), at, ARM)
    np.testing.assert_allclose(target[1:], (pen * (tip - ARM) + (1.0 - pen) * own)[1:], atol=1e-12)
    assert target[0] == pytest.approx(0.15)
    led = at._replace(contact=IN_THE_AIR._replace(axis_position=1.2, anchor=0.15))
    assert following.cog_target(numeric(gains), led, ARM)[0] == pytest.approx(1.2 - ARM[0])


# ---- along the contact axis ----


def test_out_of_contact_the_tip_is_led_by_position(make_inputs: Make) -> None:
    led = IN_THE_AIR._replace(axis_position=1.2, axis_velocity=0.05)
    at = make_inputs(
        contact=led, **{**CALM, "position": np.array([0.03, 0.0, 0.0]), "velocity": np.array([0.1, 0.0, 0.0])}
    )
    state, force, _ = step(at, state=pressing(1.0, 0.1))
    damping = 2.0 * 0.8 * 5.0**0.5
    assert force[0] == pytest.approx(-MASS * (damping * (0.1 - 0.05) + 5.0 * (0.03 + 1.09 - 1.2)))
    assert state.press.integral == 0.0
    assert state.press.tank == GAINS.tank


def test_in_contact_a_soft_spring_holds_the_anchor(make_inputs: Make) -> None:
    at = make_inputs(contact=ENGAGED._replace(anchor=0.1), **{**CALM, "position": np.array([0.03, 0.0, 0.0])})
    _, force, _ = step(at)
    assert force[0] == pytest.approx(1.0 - MASS * GAINS.press_stiffness * (0.03 - 0.1))


def test_the_damper_counts_the_motion_against_surface_and_arm(make_inputs: Make) -> None:
    at = make_inputs(
        contact=ENGAGED._replace(surface_velocity=0.05),
        commanded_arm=ArmTarget(1.09, 0.02),
        **{**CALM, "velocity": np.array([0.07, 0.0, 0.0])},
    )
    state, force, _ = step(at, state=pressing(0.0, 0.2))
    relative = 0.07 - (0.05 - 0.02)
    assert force[0] == pytest.approx(1.0 - MASS * GAINS.press_damping * relative)
    assert state.press.tank == pytest.approx(0.2 + MASS * GAINS.press_damping * relative**2 * DT)


def test_where_the_surface_has_gone_nothing_is_pressed_and_the_damper_is_firmer(make_inputs: Make) -> None:
    moving = {**CALM, "force": np.zeros(3), "velocity": np.array([0.07, 0.0, 0.0])}
    at = make_inputs(contact=ENGAGED._replace(gone=1.0, normal_force=0.0), **moving)
    state, force, _ = step(at)
    assert force[0] == pytest.approx(-3.0 * MASS * GAINS.press_damping * 0.07)
    assert state.press.integral == 0.0


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_it_presses_as_if_it_had_another_mass(make_inputs: Make, ratio: float) -> None:
    """Put f into m x'' = f + f_hat: what is left moves ratio times the mass."""
    gains = following.Gains(GAINS.stiffness, GAINS.damping_ratio, press_mass_ratio=ratio, force=1.5)
    view = ENGAGED._replace(normal_force=1.2, ease=0.8)  # as hard as wanted, so that nothing integrates
    asked = make_inputs(contact=view, wanted=1.5, **{**CALM, "force": -0.7 * X})
    _, force, _ = step(asked, gains)
    assert ratio * (force[0] - 0.7) == pytest.approx(1.2 - 0.7)


@pytest.mark.parametrize("normal", [0.4, 1.9])
def test_a_missing_force_is_integrated_up_to_its_limit(make_inputs: Make, normal: float) -> None:
    at = make_inputs(contact=ENGAGED._replace(normal_force=normal), **CALM)
    state, force, _ = step(at)
    assert state.press.integral == pytest.approx(GAINS.force_integral * (1.0 - normal) * DT)
    assert force[0] == pytest.approx(1.0 + state.press.integral)
    nearly = pressing(np.sign(1.0 - normal) * (GAINS.force_integral_limit - 1e-4), 0.5)
    state, force, _ = step(at, state=nearly)
    assert state.press.integral == pytest.approx(np.sign(1.0 - normal) * GAINS.force_integral_limit)
    assert force[0] == pytest.approx(1.0 + state.press.integral)


@pytest.mark.parametrize(
    ("tank", "speed", "share"),
    [
        (0.5, 0.1, 1.0),
        (0.125, 0.1, 1.0),
        (0.05, 0.1, 0.4),
        (0.0, 0.1, 0.0),
        (0.0, -0.1, 1.0),
        (0.05, -0.1, 1.0),
    ],
)
def test_an_empty_tank_lets_the_integral_fade_where_it_spends(
    make_inputs: Make, tank: float, speed: float, share: float
) -> None:
    gains = following.Gains(GAINS.stiffness, GAINS.damping_ratio, press_mass_ratio=1.0, press_damping=0.01)
    at = make_inputs(contact=ENGAGED, **{**CALM, "velocity": speed * X})
    state, force, _ = step(at, gains, pressing(2.0, tank))
    damper = MASS * 0.01 * speed
    assert force[0] == pytest.approx(1.0 + share * 2.0 - damper)
    filled = tank + (damper - share * 2.0) * speed * DT
    assert state.press.tank == pytest.approx(min(max(filled, 0.0), GAINS.tank))


@given(
    st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-2.0, 4.0)), min_size=1, max_size=60),
    st.floats(0.0, 0.5),
)
def test_the_integral_gives_no_more_than_tank_and_damper_put_in(
    make_inputs: Make, motion: list[tuple[float, float]], tank: float
) -> None:
    """Work of the integral on the motion <= tank at first + what the damper dissipated + a tick's worth."""
    state = pressing(3.0, tank)
    spent = dissipated = 0.0
    for speed, normal in motion:
        view = ENGAGED._replace(normal_force=normal)
        at = make_inputs(
            MODEL,
            contact=view,
            **{**CALM, "velocity": speed * X},
        )
        state, force, _ = step(at, state=state)
        damper = MASS * GAINS.press_damping * speed
        spent += (float(force[0]) + damper - GAINS.force) * speed * DT
        dissipated += damper * speed * DT
    slack = GAINS.force_integral_limit * 0.3 * DT
    assert spent <= tank + dissipated + slack + 1e-9


def test_what_a_stroke_came_to_is_carried_to_the_next_and_comes_with_its_press(make_inputs: Make) -> None:
    view = ENGAGED._replace(normal_force=1.0, ramp=1.0)
    along = {name: make_inputs(contact=contact, **CALM) for name, contact in {
        "ends": view._replace(reason=UNLOADING, normal_force=0.4),
        "lifted": IN_THE_AIR,
        "lands": view._replace(ramp=0.5),
        "grows": view._replace(ramp=0.8),
        "slides": view,
    }.items()}  # fmt: skip
    state, found = pressing(-0.2, GAINS.tank), {}
    for name, at in along.items():
        state, _, signals = following.step(numeric(GAINS), state, at)
        found[name] = float(signals["contact_force_integral"])
        # While the press goes, what is felt says nothing of how hard to press.
        assert state.press == pytest.approx((0.0, GAINS.tank, -0.2))
    assert found == pytest.approx({"ends": -0.2, "lifted": 0.0, "lands": 0.0, "grows": -0.08, "slides": -0.2})


def test_what_is_carried_and_what_is_learnt_stay_within_one_limit(make_inputs: Make) -> None:
    at = make_inputs(contact=ENGAGED._replace(normal_force=-1e6), **CALM)
    state, _, _ = step(at, state=pressing(0.0, GAINS.tank, 0.4 * GAINS.force_integral_limit))
    assert state.press.integral == pytest.approx(0.6 * GAINS.force_integral_limit)
