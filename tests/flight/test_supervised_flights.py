"""Supervised flights: without a fault nothing changes, and without poses the robot goes on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import CIRCLE, HOLD
from skylimb.control.estimation.lateness import SLOW
from skylimb.control.estimation.records import Measurement
from skylimb.control.laws.preset import preset_names
from skylimb.control.loop.loop import Loop
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.suited_gains import MOST
from skylimb.control.supervisor.table import TABLE
from skylimb.flight.drivers.free import FreeDriver
from skylimb.flight.drivers.world import world
from skylimb.flight.flying import simulated_vehicle
from skylimb.flight.loading import plan_flights
from skylimb.flight.realtime.compiled_controller import CompiledController
from skylimb.flight.realtime.guard import GuardedController
from skylimb.flight.takeoff import take_off

SETTLED = {**HOLD, "trajectory.duration": 2.0}


@pytest.mark.parametrize(
    ("controller", "losses"), [("following", True), ("drawing", True), ("hybrid", False)]
)
def test_without_a_fault_not_a_bit_changes(controller: str, losses: bool) -> None:
    plain = skylimb.run("paper", controller, set={**HOLD, "supervisor.on": False})
    watched = skylimb.run(
        "paper", controller, set={**HOLD, "supervisor.on": True, "supervisor.losses": losses}
    )
    assert watched.status == plain.status
    for name in plain.log.data_vars:
        np.testing.assert_array_equal(watched.log[name], plain.log[name], err_msg=str(name))
    assert not watched.log.supervisor_bits.any()
    assert not watched.log.supervisor_mode.any()


def test_who_presses_beside_people_is_supervised_unless_its_experiment_says_otherwise() -> None:
    names = preset_names()
    for said, expected in ((None, ("drawing", "following", "mpc")), (False, ()), (True, tuple(names))):
        told = {} if said is None else {"supervisor.on": said}
        plans = plan_flights("paper", names, set={**HOLD, **told})
        on = tuple(name for name, one in zip(names, plans, strict=True) if one.experiment.supervisor.on)
        assert on == expected
        assert all(one.event_context.supervised is bool(one.experiment.supervisor.on) for one in plans)
    assert not any(one.experiment.supervisor.losses for one in plans)


class Blinded:
    """A vehicle whose motion capture is gone for a while: its pose stays, and so does its stamp."""

    def __init__(self, vehicle: Any, guard: GuardedController, begin: int, end: int) -> None:
        self._vehicle, self._guard, self._gone, self._tick = vehicle, guard, range(begin, end), 0
        self.layout, self.record = vehicle.layout, vehicle.record
        self.apply, self.fault = vehicle.apply, vehicle.fault
        self._last: Measurement | None = None
        self._at = 0.0

    def measure(self) -> Measurement:
        seen, pose = self._vehicle.measure(), Measurement._fields[:4]
        if self._tick in self._gone and self._last is not None:
            seen = seen._replace(**{name: getattr(self._last, name) for name in pose})
        else:
            self._last, self._at = seen, float(self._tick)
        self._guard.taken(self._at)
        self._tick += 1
        return seen


class Guarded:
    """A flight under the guard that may be blinded."""

    def __init__(self, begin: int = 0, end: int = 0, limits: Limits | None = None) -> None:
        (takeoff,) = take_off("paper", ("following",), set=SETTLED)
        inner: Any = takeoff.controller
        self.guard = GuardedController(
            CompiledController(inner, takeoff.period), takeoff.robot, limits=limits
        )
        simulated, rows = world(takeoff), takeoff.rows
        vehicle = Blinded(simulated_vehicle(takeoff, simulated), self.guard, begin, end)
        driver = FreeDriver(self.guard, vehicle, takeoff.robot, takeoff.mission, len(rows))
        self.flight = Loop(driver, takeoff.mission, takeoff.experiment.terminations, takeoff.count).fly()
        self.position = self.flight.signal("configuration")[:, :3]


@pytest.fixture(scope="module")
def seen() -> Guarded:
    flown = Guarded()
    assert not flown.guard.counts
    return flown


@pytest.mark.parametrize(("ticks", "bound"), [(20, 0.01), (80, 0.06)])
def test_a_pressing_robot_that_sees_nothing_goes_on_by_its_model(
    seen: Guarded, ticks: int, bound: float
) -> None:
    """Held commands lost 2 of 4 such flights in 0.4 s."""
    begin = 500  # it presses
    assert seen.flight.signal("contact_force")[begin, 0] != 0.0
    blind = Guarded(begin, begin + ticks)
    assert blind.flight.cause == ""
    assert blind.guard.mode == "NORMAL"
    both = min(len(blind.position), len(seen.position))  # the mission's pace may differ
    away = np.linalg.norm(blind.position[:both] - seen.position[:both], axis=1)
    assert away[:begin].max() == 0.0
    assert 0.0 < away.max() < bound


def test_one_measurements_noise_leads_no_blind_flight_astray() -> None:
    """Hovering with 0.1 m/s of noise it drifted by 39 mm in 0.5 s, 4 N of noise in what it felt."""
    noisy = {**HOLD, "supervisor.on": True, "sensors.velocity_noise": 0.1}
    lost = {"kind": "sensor", "time": 0.6, "capture": "lost", "duration": 0.5}
    seen, blind = (skylimb.run("paper", "hybrid", set={**noisy, "events": events}) for events in ([], [lost]))
    assert (blind.log.supervisor_mode == 1.0).any()
    away = np.linalg.norm(blind.log.cog_position - seen.log.cog_position, axis=1)[: round(1.1 / 0.005)]
    assert 0.0 < away.max() < 0.025


def test_a_tick_that_comes_too_late_keeps_the_paths_pace() -> None:
    """Its pace fell to 0 for a tick, and took a second to come back: the pen was 18 mm off."""
    late = {"kind": "tick", "time": 3.0, "duration": 0.005}
    known = {**CIRCLE, "trajectory.period": 4.0, "supervisor.on": True}
    on_time, held = (skylimb.run("paper", "following", set={**known, "events": e}) for e in ([], [late]))
    assert (held.log.supervisor_mode == 1.0).sum() >= 1
    assert float(np.abs(held.log.tip_position - on_time.log.tip_position).max()) < 0.003


LOOKED_AT = {**CIRCLE, "trajectory.period": 4.0, "supervisor.on": True, "supervisor.losses": True}
CATALOGUED = {
    "phases.hover": 0.5,
    "phases.tare": 2.0,
    "phases.settle": 1.0,
    "phases.hover_end": 0.2,
    "approach.speed": 0.1,
    "approach.standoff": 0.02,
    "approach.depth": 0.05,
    "trajectory.radius": 0.1,
    "trajectory.period": 8.0,
    "supervisor.on": True,
    "supervisor.losses": True,
}
"""As the catalogue of faults is flown."""


def test_a_pose_that_comes_back_looks_like_no_lost_rotor() -> None:
    """The velocity jumps as frames come back; that read as a rotor's loss, and the flight was broken off."""
    lost = {"kind": "sensor", "time": 9.045197, "capture": "lost", "duration": 0.5}
    asked = {**CATALOGUED, "surface.slope": -0.349, "events": [lost], "stop_at": 9.8}
    flown = skylimb.run("paper", "following", seed=3726977014, set=asked)
    modes = flown.log.supervisor_mode.values
    assert (modes == 1.0).sum() > 80
    assert modes.max() == 1.0


def test_a_pen_that_drifted_ahead_unseen_keeps_its_press() -> None:
    """It was eased as if friction held it, and left the surface for four fifths of the two seconds after."""
    lost = {"kind": "sensor", "time": 7.0, "latest": 10.0, "capture": "lost", "duration": 0.5}
    asked = {**CATALOGUED, "surface.slope": -0.349, "events": [lost]}
    log = skylimb.run("paper", "following", seed=2919533707, set=asked).log
    back = int(np.flatnonzero(log.supervisor_mode.values == 1.0)[-1]) + 1
    assert (log.contact.values[back : back + 400] > 0.0).all()


@pytest.mark.parametrize("stuck", ["velocity", "rates"])
def test_a_twist_that_sticks_looks_like_no_lost_rotor(stuck: str) -> None:
    # What stands in for it follows the poses, and so their noise: of that the loss of a rotor was read.
    fault = {"kind": "sensor", "time": 7.0, "latest": 10.0, "stuck": stuck}
    asked = {**CATALOGUED, "surface.slope": 0.349, "events": [fault]}
    log = skylimb.run("paper", "following", seed=2788046415, set=asked).log
    assert set(log.supervisor_mode.values) == {0.0, 2.0}


def test_frames_that_come_later_are_noticed_and_flown_with() -> None:
    """Without it every such flight is lost, as is one with 60 ms of latency where 20 are believed."""
    late = {"kind": "sensor", "time": 2.5, "late": 0.05}
    in_time, later, slow = (
        skylimb.run("paper", "following", set={**LOOKED_AT, **more})
        for more in ({}, {"events": [late]}, {"sensors.latency": 0.055})
    )
    assert not in_time.log.lateness_estimate.any()
    assert not in_time.log.rotor_slowness_estimate.any()
    assert (in_time.status, later.status, slow.status) == ("OK", "OK", "OK")
    assert float(later.log.lateness_estimate[-1]) == 0.05
    assert float(np.abs(later.log.tilt - in_time.log.tilt[0]).max()) < 0.06
    seen = float(slow.log.time[int(np.argmax(slow.log.contact.values > 0.0))])
    assert float(slow.log.lateness_estimate.sel(time=seen)) == 0.05
    # A replay has the gains of each tick; it knows the predictions that stood in at the onset no more.
    replayed = skylimb.replay(later).log
    apart = np.abs(replayed.thrusts_command.values - later.log.thrusts_command.values)
    assert apart[:500].max() == 0.0
    assert apart[800:].max() < 0.01


def test_rotors_that_are_slow_are_told_from_frames_that_are_late() -> None:
    """They were taken for frames that come far too late, and the flight was broken off in hover."""
    turned = {"sensors.attitude_misalignment": [0.01, -0.01, 0.01], "surface.slope": -0.349, "seed": 3}
    slow = {"plant.rotor_lag": 0.12, "sensors.latency": 0.03}
    asked = {"supervisor.on": True, "supervisor.losses": True, "stop_at": 8.0}
    run = skylimb.run("paper", "drawing", set={**turned, **slow, **asked})
    assert float(run.log.supervisor_mode.max()) < 2.0
    assert float(run.log.rotor_slowness_estimate[-1]) in SLOW[1:]
    assert float(run.log.tilt.max()) < 0.1


def test_frames_that_come_far_too_late_are_flown_back_with() -> None:
    late = {"kind": "sensor", "time": 2.5, "late": 0.1}
    run = skylimb.run("paper", "following", set={**LOOKED_AT, "events": [late]})
    modes = run.log.supervisor_mode.values
    assert (modes[-1], modes.max()) == (2.0, 2.0)
    assert float(run.log.lateness_estimate.max()) > MOST
    assert float(run.log.tilt.max()) < 0.26


@pytest.mark.parametrize(("late", "mode", "status"), [(0.05, 1.0, "OK"), (0.1, 2.0, "FAILED")])
@pytest.mark.parametrize("controller", ["following", "drawing"])
def test_frames_whose_stamps_say_that_they_come_late_are_believed_where_nobody_looks_closer(
    late: float, mode: float, status: str, controller: str
) -> None:
    """Both were lost 1.6 to 3 s later: .1 s is flown back with, and .05 s flown on."""
    fault = {"kind": "sensor", "time": 2.5, "late": late}
    run = skylimb.run("paper", controller, set={**LOOKED_AT, "supervisor.losses": False, "events": [fault]})
    assert float(run.log.supervisor_mode.max()) == mode
    assert float(run.log.lateness_estimate[-1]) == late
    assert run.status == status
    assert float(run.log.tilt.max()) < 0.26
    assert float(run.log.time[-1]) > 6.0


@pytest.mark.parametrize(
    "fault",
    [{"stamp": 0.3}, {"stamp": -0.3, "duration": 0.5}, {"stamp": 2.0}, {"capture": "lost", "duration": 0.3}],
)
def test_a_clock_that_is_set_and_frames_that_are_lost_say_of_none_that_it_is_late(fault: Any) -> None:
    event = {"kind": "sensor", "time": 2.5, **fault}
    run = skylimb.run("paper", "following", set={**SETTLED, "supervisor.on": True, "events": [event]})
    assert not run.log.lateness_estimate.any()
    assert float(run.log.supervisor_mode.max()) < 2.0


def test_a_robot_that_sees_nothing_any_more_sinks_level_and_then_stops() -> None:
    begin = 450
    blind = Guarded(begin, 10**6)
    thrusts = blind.flight.signal("thrusts_command")
    low, high = skylimb.load_robot("hydrus_xi_quad").thrust_limits()
    assert np.isfinite(thrusts).all()
    assert ((thrusts >= low) & (thrusts <= high)).all()
    retreating = blind.flight.signal("retreating") > 0.0
    # The last frame came a tick before, and was said again since.
    assert int(np.argmax(retreating)) == begin + 119
    # Until the rotors stop it is level.
    quaternion = blind.flight.signal("configuration")[: begin + 190, 3:7]
    tilt = np.arccos(1.0 - 2.0 * (quaternion[:, 1] ** 2 + quaternion[:, 2] ** 2))
    assert tilt.max() < 0.25
    stopped = thrusts[begin + 200 :]
    assert len(stopped) > 0
    np.testing.assert_array_equal(stopped, np.tile(low, (len(stopped), 1)))


def test_a_rotor_at_half_is_named_made_up_for_and_the_flight_broken_off() -> None:
    lost = {"kind": "rotor", "time": 4.0, "rotor": "rotor3", "effectiveness": 0.5}
    changes = {**HOLD, "phases.tare": 2.0, "stop_at": 5.3, "events": [lost]}
    plain = skylimb.run("paper", "following", set={**changes, "supervisor.on": False}).log
    log = skylimb.run(
        "paper", "following", set={**changes, "supervisor.on": True, "supervisor.losses": True}
    ).log
    sunk, sinks = (one.root_position.values[800, 2] - one.root_position.values[:, 2] for one in (log, plain))
    assert sunk.max() < 0.3
    assert sunk[-1] < 0.1 < sinks[-1]
    modes = log.supervisor_mode.values
    assert not modes[:800].any()
    assert 0 < int(np.argmax(modes > 0.0)) - 800 < 40
    assert set(modes[850:]) == {2.0}
    np.testing.assert_allclose(log.rotor_shares_estimate.values[-1], [1.0, 1.0, 0.5, 1.0], atol=0.1)


@pytest.mark.parametrize("scale", [0.92, 1.08])
def test_a_thrust_that_is_off_at_take_off_sinks_nobody(scale: float) -> None:
    """A cap of 2 N on the vertical spring let `following` sink to the floor at 8 %."""
    changes = {**HOLD, "plant.thrust_scale": scale, "supervisor.on": True}
    run = skylimb.run("paper", "following", set=changes)
    assert run.status == "OK", run.cause
    off = run.log.cog_position.values[:, 2] - run.log.cog_position_reference.values[:, 2]
    assert abs(off).max() < 0.12


@pytest.mark.parametrize(("rotor", "end", "ticks"), [("rotor3", 3.0, 20), ("rotor1", 4.0, 30)])
def test_without_a_rotor_it_descends_level_or_its_rotors_stop(rotor: str, end: float, ticks: int) -> None:
    """Rotor 1 and rotor 4 look much alike, so it takes longer to tell which."""
    lost = {"kind": "rotor", "time": 4.0, "rotor": rotor, "effectiveness": 0.0}
    changes = {**HOLD, "phases.tare": 2.0, "stop_at": 6.0, "events": [lost], "supervisor.on": True}
    log = skylimb.run("paper", "following", set={**changes, "supervisor.losses": True}).log
    modes = log.supervisor_mode.values
    assert not modes[:800].any()
    assert 0 < int(np.argmax(modes == end)) - 800 < ticks
    assert modes[-1] == end
    if end == 3.0:
        assert log.tilt.values.max() < 0.3
        assert np.linalg.norm(log.cog_velocity.values, axis=1).max() < 0.8
        assert len(modes) == 1200


def test_a_robot_without_its_second_rotor_is_kept_slow() -> None:
    """Rotor 3 is at its limit then, and no thrust turns the robot back: it came to 1.8 m/s."""
    lost = {"kind": "rotor", "time": 8.0, "rotor": "rotor2", "effectiveness": 0.0}
    asked = {**CATALOGUED, "surface.slope": -0.349, "events": [lost], "stop_at": 9.5}
    log = skylimb.run("paper", "following", set=asked).log
    assert log.supervisor_mode.values[-1] == 3.0
    assert np.linalg.norm(log.cog_velocity.values, axis=1).max() < 1.3
    assert log.tilt.values.max() < 0.35


@pytest.mark.parametrize(
    ("servo", "speed"), [("gimbal_joint2", 2.0), ("gimbal_joint4", -2.0), ("gimbal_joint3", -2.0)]
)
def test_a_servo_that_turns_round_and_round_is_made_up_for_by_the_others(servo: str, speed: float) -> None:
    """With the others' angles as they were it leant by up to .36 rad, and beside rotor 4 spun at 3 rad/s."""
    runs = {"kind": "joint", "time": 3.0, "joint": servo, "speed": speed}
    changes = {**HOLD, "phases.tare": 2.0, "phases.settle": 8.0, "events": [runs], "stop_at": 7.0}
    log = skylimb.run(
        "paper", "following", set={**changes, "supervisor.on": True, "supervisor.losses": True}
    ).log
    modes, turned = log.supervisor_mode.values, log.vectoring_angles.values
    assert 0 < int(np.argmax(modes > 0.0)) - 600 < 50
    assert set(modes[650:]) == {3.0}
    # The hovering frame turns with the angles: what must stay level is the robot.
    quaternion = log.root_quaternion.values
    tilt = np.arccos(1.0 - 2.0 * (quaternion[:, 1] ** 2 + quaternion[:, 2] ** 2))
    assert tilt.max() < 0.262
    # It has turned farther than any sound angle is, and its angle is believed.
    assert np.abs(turned[-1] - turned[600]).max() > 7.0
    numb = list(TABLE.bits).index("numb")
    assert not (log.supervisor_bits.values.astype(int) >> numb & 1).any()


def test_a_joint_that_a_servo_drives_elsewhere_is_made_up_for_by_the_rotors() -> None:
    """With the vectoring angles as they were the robot tipped over, past 1 rad, as the arm stretched."""
    runs = {"kind": "joint", "time": 7.3, "joint": "joint2", "speed": 0.5}
    log = skylimb.run(
        "paper", "drawing", set={"events": [runs], "supervisor.on": True, "supervisor.losses": True}
    ).log
    assert float(log.supervisor_mode.values[-1]) == 3.0
    quaternion = log.root_quaternion.values
    tilt = np.arccos(1.0 - 2.0 * (quaternion[:, 1] ** 2 + quaternion[:, 2] ** 2))
    assert tilt.max() < 0.2
    assert log.root_position.values[-1, 2] < 0.2  # it has come down
