"""The preset `drawing` beside `following`: what it does at corners, and where strokes begin and end."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from law_records import IN_THE_AIR
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import in_contact, in_phase
from skylimb.base.packing import numeric
from skylimb.base.rotations import rotation_from_rpy
from skylimb.control.attitude.laws import firm, impedance
from skylimb.control.contact.laws import drawing
from skylimb.control.contact.machine import FREE, RETREAT, SETTLE, SLIDE
from skylimb.control.controller import load_controller
from skylimb.control.estimation.friction import FrictionGains
from skylimb.control.missions.reference import zero_reference
from skylimb.control.press import LOADING, UNLOADING

DRAWING = {
    "trajectory.shape": "drawing",
    "trajectory.text": "LT",
    "trajectory.width": 0.25,
    "trajectory.speed": 0.05,
    "trajectory.acceleration": 0.05,
    "trajectory.feedforward": "full",
}


@pytest.fixture(scope="module")
def runs() -> dict[str, Run]:
    return dict(skylimb.compare("paper", ("following", "drawing"), set=DRAWING))


def test_it_draws_better(runs: dict[str, Run]) -> None:
    before, after = (runs[name].metrics for name in ("following", "drawing"))
    assert runs["drawing"].status == "OK"
    assert after["pen_line_rms"] < 0.75 * before["pen_line_rms"]
    assert after["line_frechet"] < 0.85 * before["line_frechet"]


def test_the_pen_comes_off_at_the_ends_of_strokes_alone(runs: dict[str, Run]) -> None:
    log = runs["drawing"].log
    slides = in_phase(log, "slide")
    off, soon = slides & ~in_contact(log), round(0.5 / float(log.time[1] - log.time[0]))
    # 20 ms as a press begins are no loss.
    assert (off[:-soon] & slides[soon:]).sum() <= 4
    assert runs["drawing"].metrics["contact_fraction"] > 0.98


def test_it_learns_the_friction(runs: dict[str, Run]) -> None:
    """The board's is 0.4, and 1 N is wanted."""
    assert runs["drawing"].log.friction_estimate.values[-1] == pytest.approx(0.4, abs=0.12)


def test_the_press_comes_and_goes_over_time(runs: dict[str, Run]) -> None:
    log = runs["drawing"].log
    state, target, pace = (log[name].values for name in ("contact_state", "contact_force_target", "pace"))
    dt = float(log.time[1] - log.time[0])
    (begin, *_) = np.flatnonzero((state[1:] == SETTLE) & (state[:-1] != SETTLE)) + 1
    np.testing.assert_allclose(target[begin + 1], 0.3, atol=0.05)
    np.testing.assert_allclose(target[begin + round(0.5 / dt)], 0.65, atol=0.05)
    np.testing.assert_allclose(target[begin + round(1.1 / dt)], 1.0, atol=0.05)
    (leave, *_) = np.flatnonzero((state[1:] == RETREAT) & (state[:-1] != RETREAT)) + 1
    # The path rests at the end of the stroke, and the press goes down to its share, told ahead of that.
    resting = slice(leave - round(0.9 / dt), leave - round(0.15 / dt))
    assert np.all(pace[resting] == 0.0)
    assert np.all(np.diff(target[resting]) <= 1e-9)
    assert target[leave] == pytest.approx(0.02 - 0.15, abs=0.03)
    # All of that is commanded, and told as such.
    reason = log.press_reason.values
    assert reason[begin + round(0.5 / dt)] == LOADING
    assert np.all(reason[resting] == UNLOADING)
    np.testing.assert_allclose(log.contact_force_reference.values[resting], target[resting] + 0.15, atol=1e-9)
    assert np.all(target[leave + round(0.15 / dt) : leave + round(1.0 / dt)] == 0.0)


def test_it_lifts_without_tails(runs: dict[str, Run]) -> None:
    scores = runs["drawing"].metrics
    assert scores["lift_touch_time"] < 0.04 * scores["lift_time"]
    assert scores["pen_line_max"] < 0.008


def test_the_way_back_never_leads_into_the_surface(runs: dict[str, Run]) -> None:
    """The nominal surface lies before the real one at the first stroke and behind it at the others."""
    log = runs["drawing"].log
    state, tip = log.contact_state.values, log.tip_position.values[:, 0]
    dt = float(log.time[1] - log.time[0])
    leaves = np.flatnonzero((state[1:] == RETREAT) & (state[:-1] != RETREAT)) + 1
    assert len(leaves) == 3
    for leave in leaves:
        assert tip[leave + round(1.0 / dt)] < tip[leave] - 0.015


def test_a_lift_keeps_its_clearance_and_goes_little_further(runs: dict[str, Run]) -> None:
    """Not as far as the board may stand out anywhere; and it is over before the mission's own time is."""
    for log in (run.log for run in runs.values()):
        state, gap, lift = log.contact_state.values, log.surface_gap.values, in_phase(log, "lift")
        begins = np.flatnonzero(lift[1:] & ~lift[:-1]) + 1
        for begin, end in zip(begins, [*begins[1:], len(lift)], strict=True):
            away = gap[begin:end][(state[begin:end] == FREE) & lift[begin:end]]
            assert 0.05 < away.max() < 0.09
    log, dt = runs["drawing"].log, float(runs["drawing"].log.time[1] - runs["drawing"].log.time[0])
    gone = log.mission_time.values[in_phase(log, "lift")]
    assert in_phase(log, "lift").sum() * dt < np.ptp(gone)


@pytest.mark.parametrize("behind", [-0.1, 0.1])
def test_a_lift_goes_back_by_the_hop_wherever_the_nominal_surface_is(
    make_inputs: Any, make_start: Any, behind: float
) -> None:
    gains = numeric(drawing.Gains())
    machine = numeric(drawing.initial_state(drawing.Gains(), make_start())).following.machine
    state = numeric(drawing.initial_state(drawing.Gains(), make_start()))
    place = 1.0
    for tick in range(600):
        moved = machine._replace(state=RETREAT, since=0.4 + 0.005 * tick)
        inner = state.following._replace(machine=moved, axis_position=place)
        inputs = make_inputs(reference={"tip_position": np.array([1.0 + behind, 0.0, 0.0])})
        place, velocity = drawing._back(gains, state._replace(following=inner), moved, 1.0, inputs)
        assert float(velocity) <= 0.0
    assert float(place) == pytest.approx(1.0 + min(behind, -drawing.Gains().hop), abs=1e-6)


def test_the_expected_torque_is_taken_off_by_its_share(make_inputs: Any, model: Any) -> None:
    view = IN_THE_AIR._replace(across=np.array([0.1, 0.4, -0.3]))
    arm, target = np.array([0.9, 0.1, -0.2]), np.eye(3)
    inputs = make_inputs(model=model, R=rotation_from_rpy(0.1, -0.2, 0.3), arm=arm, contact=view)
    gains = firm.Gains((10.0, 10.0, 1.0), (52.0, 150.0, 24.0), (1.1, 0.8, 0.5), contact_share=(0.0, 0.5, 1.0))
    plain = impedance.Gains((10.0, 10.0, 1.0), (52.0, 150.0, 24.0), (1.1, 0.8, 0.5))
    _, torque, _ = firm.step(numeric(gains), (), inputs, target)
    _, without, _ = impedance.step(numeric(plain), (), inputs, target)
    expected = inputs.estimate.body.R_WC.T @ np.cross(inputs.estimate.arm, inputs.contact.across)
    np.testing.assert_allclose(torque, without - np.array([0.0, 0.5, 1.0]) * expected, atol=1e-12)
    both = replace(gains, unexpected_share=(0.3, 0.2, 0.1))
    _, less, _ = firm.step(numeric(both), (), inputs, target)
    beyond = inputs.estimate.wrench.torque - expected
    assert np.abs(beyond).min() > 1e-3
    np.testing.assert_allclose(less, torque - np.array([0.3, 0.2, 0.1]) * beyond, atol=1e-12)
    _, none, _ = firm.step(numeric(replace(gains, contact_share=(0.0, 0.0, 0.0))), (), inputs, target)
    np.testing.assert_array_equal(none, without)


def test_the_body_is_held_firmer_where_the_path_rests_in_touch(make_inputs: Any, model: Any) -> None:
    target, R, omega = np.eye(3), rotation_from_rpy(0.1, -0.2, 0.3), np.array([0.2, -0.1, 0.3])
    soft = firm.Gains((1.0, 1.0, 1.0), (52.0, 150.0, 24.0), (1.1, 0.8, 0.4), slow_speed=0.08)
    slow = replace(soft, slow_stiffness=(1.0, 1.0, 2.0), slow_damping=(1.0, 1.5, 2.5))
    # At rest: the same as a law whose spring and damper are that much stronger.
    ratio = (1.1, 0.8 * 1.5, 0.4 * 2.5 / 2.0**0.5)
    hard = replace(soft, normalized_stiffness=(52.0, 150.0, 48.0), damping_ratio=ratio)

    def torque(gains: firm.Gains, speed: float, engaged: float = 1.0) -> np.ndarray:
        view = IN_THE_AIR._replace(engaged=engaged, own_speed=speed)
        inputs = make_inputs(model=model, R=R, omega=omega, contact=view)
        return firm.step(numeric(gains), (), inputs, target)[1]

    np.testing.assert_allclose(torque(slow, 0.0), torque(hard, 0.0), atol=1e-12)
    middle = 0.5 * (torque(hard, 0.0) + torque(soft, 0.0))
    np.testing.assert_allclose(torque(slow, 0.04), middle, atol=1e-12)
    np.testing.assert_allclose(torque(slow, 0.1), torque(soft, 0.1), atol=1e-12)
    np.testing.assert_allclose(torque(slow, 0.0, 0.0), torque(soft, 0.0, 0.0), atol=1e-12)


def test_a_landing_is_over_once_the_path_goes_on_and_comes_once(make_inputs: Any, make_start: Any) -> None:
    gains = numeric(drawing.Gains())
    state = numeric(drawing.initial_state(drawing.Gains(), make_start()))
    slides = state.following._replace(machine=state.following.machine._replace(state=SLIDE))
    state, landings = state._replace(following=slides), []
    for speed in (0.0, 0.0, *(0.05,) * 400):
        moving = {"tip_velocity": np.array([0.0, speed, 0.0]), "touch": 1.0, "wait": 1.0}
        moving |= {"ahead": (zero_reference(3, 4)._replace(touch=1.0),)}
        state, view, _ = drawing.step(
            gains, state, make_inputs(force=np.array([-1.0, 0.0, 0.0]), contact_force=-1.0, reference=moving)
        )
        landings.append(float(view.landing))
    assert landings[:2] == [1.0, 1.0]
    assert landings[62] == pytest.approx(np.exp(-1.0), abs=0.02)
    assert landings[-1] < 0.01


def test_a_path_comes_to_rest_where_its_stroke_ends(make_inputs: Any, make_start: Any) -> None:
    """v^2 = 2 a s over the way that is left, less what the path goes before the rest begins."""
    gains = replace(drawing.Gains(), path_acceleration=0.1)
    state = drawing.initial_state(gains, make_start())
    speed, here = 0.1, np.array([1.0, 0.0, 0.0])
    slides = state.following._replace(machine=state.following.machine._replace(state=SLIDE), speed=speed)
    state = numeric(state._replace(following=slides, loaded=1.0))
    row = zero_reference(3, 4)._replace(tip_position=here, touch=1.0)
    for way in (0.02, 0.03):
        end = row._replace(tip_position=here + np.array([-0.1, 0.0, way]), touch=0.0)
        moving = {"tip_velocity": np.array([0.0, 0.0, speed]), "tip_position": here, "touch": 1.0}
        inputs = make_inputs(
            force=np.array([-1.0, 0.0, 0.0]),
            contact_force=-1.0,
            reference={**moving, "wait": 1.0, "ahead": (row, end)},
        )
        _, _, signals = drawing.step(numeric(gains), state, inputs)
        left = way - drawing.AHEAD * speed + drawing.ENDS
        assert float(signals["pace"]) == pytest.approx(np.sqrt(2.0 * 0.1 * left) / speed, rel=1e-4)


def test_a_path_waits_for_its_pen_no_slower_than_it_should(make_inputs: Any, make_start: Any) -> None:
    gains = replace(drawing.Gains(), wait_beyond=0.008, waiting_pace=0.4, path_acceleration=100.0)
    state = drawing.initial_state(gains, make_start())
    slides = state.following._replace(machine=state.following.machine._replace(state=SLIDE))
    paces = []
    for behind in (0.003, 0.006, 0.02):
        moving = {"tip_velocity": np.array([0.0, 0.05, 0.0]), "touch": 1.0, "wait": 1.0}
        moving |= {"tip_position": np.array([1.0, behind, 0.0])}
        moving |= {"ahead": (zero_reference(3, 4)._replace(touch=1.0),)}
        inputs = make_inputs(
            force=np.array([-1.0, 0.0, 0.0]),
            contact_force=-1.0,
            reference=moving,
        )
        _, _, signals = drawing.step(
            numeric(gains), numeric(state._replace(following=slides, loaded=1.0)), inputs
        )
        paces.append(float(signals["pace"]))
    assert paces == pytest.approx([1.0, 0.5, 0.4])


def test_a_pen_that_comes_off_while_its_press_goes_has_ended_its_stroke(
    make_inputs: Any, make_start: Any
) -> None:
    gains = numeric(drawing.Gains())
    state = numeric(drawing.initial_state(drawing.Gains(), make_start()))
    slides = state.following._replace(machine=state.following.machine._replace(state=SLIDE))
    state = state._replace(following=slides, loaded=1.0, landing=0.0)
    last = {"touch": 1.0, "wait": 1.0, "ahead": (zero_reference(3, 4)._replace(touch=0.0),)}
    paces, endings = [], []
    for pressed in (*(1.0,) * 40, *(0.0,) * 200):
        force = np.array([-pressed, 0.0, 0.0])
        inputs = make_inputs(force=force, contact_force=-pressed, reference=last)
        state, _, signals = drawing.step(gains, state, inputs)
        paces.append(float(signals["pace"]))
        endings.append(float(state.ending))
    assert paces[:40] == [0.0] * 40  # it rests while the press goes
    assert endings[39] == pytest.approx(40 * 0.005 / drawing.Gains().unload_time, rel=0.05)
    off = next(k for k in range(240) if endings[k] == 1.0)
    assert off < 150  # the machine takes its time until it believes that the pen is off
    assert paces[off:] == [1.0] * (240 - off)


@pytest.mark.parametrize(("fine", "chase", "along"), [(1.0, 8.0, 1.0), (0.0, 8.0, 0.0), (1.0, 0.0, 0.0)])
def test_on_a_small_stroke_friction_is_expected_on_the_pens_way_to_its_place(
    fine: float, chase: float, along: float, make_inputs: Any, make_start: Any
) -> None:
    """The path rests, and the pen is 20 mm short of its place: friction holds it back."""
    gains = drawing.Gains(friction=FrictionGains(first=0.4, chase=chase))
    state = drawing.initial_state(gains, make_start())
    slides = state.following._replace(machine=state.following.machine._replace(state=SLIDE))
    inputs = make_inputs(force=np.array([-1.0, 0.0, 0.0]), contact_force=-1.0)
    tip = inputs.estimate.body.position + inputs.estimate.arm
    place = tip + np.array([0.0, 0.02, 0.0])
    inputs = make_inputs(
        force=np.array([-1.0, 0.0, 0.0]),
        contact_force=-1.0,
        reference={"touch": 1.0, "tip_position": place, "fine": fine},
    )
    _, view, _ = drawing.step(
        numeric(gains), numeric(state._replace(following=slides, loaded=1.0, engaged=1.0)), inputs
    )
    share = float(view.ease)
    assert share > 0.5
    np.testing.assert_allclose(view.across, [0.0, -0.4 * share * along, 0.0], atol=0.02)


@pytest.mark.parametrize("slope", [0.349, 0.0])
def test_a_small_force_is_kept_to_the_end(slope: float) -> None:
    """0.5 N: a last touch that came and went once kept the mission from its end."""
    small = {"controller.translation.force": 0.5, "surface.slope": slope}
    scores = skylimb.run("paper", "drawing", seed=0, set=small).metrics
    assert scores["contact_force_normal_mean"] == pytest.approx(0.5, abs=0.025)
    assert scores["contact_fraction"] > 0.97


def test_it_is_following_but_for_what_it_says(robot: Any) -> None:
    mine, other = (load_controller(name, robot).tables() for name in ("drawing", "following"))  # type: ignore[attr-defined]
    for table in (mine["estimation"], other["estimation"]):
        table["smoothing"] = {key: table["smoothing"][key] for key in ("on", "angular_velocity")}
        table["angle_rates"], table["observer"]["force"] = {}, ()
    assert mine["estimation"] == other["estimation"]
    assert mine["allocation"] == other["allocation"]
    assert mine["shape"] == other["shape"]
    changed = {key for key in other["translation"] if mine["translation"][key] != other["translation"][key]}
    assert changed == {
        *("stiffness", "damping_ratio", "cancel", "cancel_speed", "feed"),
        *("swing", "swing_cutoff", "swing_speed", "leaving_swing"),
        *("landing_cancel", "press_damping", "stiffening"),
    }


def test_a_small_circle_is_drawn_within_a_millimetre() -> None:
    """Of 15 mm; the pen was 1.3 mm off where friction was expected along its path alone."""
    circle = Path(__file__).parents[3] / "benchmarks/drawings/circle.svg"
    changes = {
        "trajectory.shape": "drawing",
        "trajectory.file": str(circle),
        "trajectory.width": 0.015,
        "trajectory.speed": 0.05,
        "trajectory.acceleration": 0.05,
        "trajectory.feedforward": "full",
    }
    scores = skylimb.run("paper", "drawing", seed=41, set=changes).metrics
    assert scores["pen_line_rms"] < 0.001
    assert scores["done"]


def test_short_strokes_are_pressed_as_commanded(tmp_path: Path) -> None:
    """Each dash of 3 s began its force integral anew, and was pressed with 1.13 N of 1."""
    dashes = tmp_path / "dashes.svg"
    path = '<path d="M 5 5 h 240" stroke="black" fill="none" stroke-dasharray="30 40"/>'
    dashes.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 300 10">{path}</svg>')
    changes = {name: value for name, value in DRAWING.items() if name != "trajectory.text"}
    changes |= {"trajectory.file": str(dashes), "trajectory.width": 0.24}
    scores = skylimb.run("paper", "drawing", seed=1, set=changes).metrics
    assert abs(scores["force_error_percent"]) < 9.0
    assert scores["done"]
