"""Flights whose controller works on the plant's IMU."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.errors import ConfigError
from skylimb.control.needs import needs_of
from skylimb.control.supervisor.table import TABLE
from skylimb.flight.flying import fly, fly_here
from skylimb.flight.takeoff import take_off

ON = {
    "controller.estimation.smoothing.on": True,
    "controller.estimation.smoothing.imu": True,
    **{f"controller.estimation.smoothing.{name}": 10.0 for name in ("position", "velocity", "attitude")},
    "controller.estimation.smoothing.angular_velocity": 200.0,
}
IMU = {"sensors.imu.on": True, **ON}


class Untraceable:
    """Hides that a controller can be traced, so that the free driver flies it with numbers."""

    def __init__(self, inner: Any) -> None:
        self.name, self.step, self.gains = inner.name, inner.step, inner.gains
        self.initial_state, self.needs = inner.initial_state, needs_of(inner)


def test_all_drivers_fly_the_same() -> None:
    (takeoff,) = take_off("paper", ("following",), set={**HOLD, **IMU, "stop_at": 1.5})
    compiled, fastest = fly_here(takeoff), fly(takeoff)
    slow = fly_here(dataclasses.replace(takeoff, controller=Untraceable(takeoff.controller)))
    np.testing.assert_array_equal(fastest.signals[: fastest.ticks], compiled.signals[: compiled.ticks])
    for name in ("configuration", "thrusts_command", "gyro_bias_estimate"):
        np.testing.assert_allclose(slow.signal(name), compiled.signal(name), atol=1e-9, err_msg=name)


LAW = """from dataclasses import dataclass
@dataclass(frozen=True)
class Gains: ...
def initial_state(gains, start): return ()
def step(gains, state, inputs):
    body, reference, felt = inputs.estimate.body, inputs.reference, inputs.measurement.imu
    pull = 4.0 * (reference.position - body.position) - 3.0 * body.velocity
    return state, body.model.mass * (pull + body.model.gravity), {"felt": felt.specific_force}
"""

OWN = """import numpy as np, skylimb
from skylimb.control.needs import Needs
class Own:
    name, needs = "own", Needs(imu=True)
    def gains(self): return None
    def initial_state(self): return ()
    def step(self, gains, state, measurement, reference, dt):
        command = skylimb.Command(np.full(4, 10.0), reference.joint_angles, reference.vectoring_angles)
        return state, command, {"felt": measurement.imu.specific_force}
def controller(robot): return Own()
"""


def test_a_law_and_a_controller_of_ones_own_see_it(tmp_path: Path) -> None:
    (tmp_path / "law.py").write_text(LAW)
    (tmp_path / "own.py").write_text(OWN)
    law = {"controller.translation.law": str(tmp_path / "law.py")}
    short = {**HOLD, "stop_at": 0.2}
    for controller, sets in (("pid", {**IMU, **law}), (str(tmp_path / "own.py"), {"sensors.imu.on": True})):
        run = skylimb.run("paper", controller, set={**short, **sets})
        assert run.status == "STOPPED", run.cause
        assert np.isfinite(run.log.felt).all()
        assert 5.0 < abs(float(run.log.felt[-1, 2])) < 15.0


def test_the_state_is_known_better() -> None:
    """The paper's controller, whose state has the capture's noise and is 10 to 15 ms old without the IMU."""
    plain, felt = (skylimb.run("paper", "pid", set={**HOLD, **sets}) for sets in ({}, IMU))
    assert felt.status == "OK"
    for name, share in (("cog_position", 0.7), ("cog_velocity", 0.75), ("attitude", 0.7)):
        off, less = (
            float(np.sqrt(np.mean((run.log[f"{name}_estimate"].values - run.log[name].values) ** 2)))
            for run in (plain, felt)
        )
        assert less < share * off, name


def test_the_replay_of_a_flight_gives_its_bits() -> None:
    run = skylimb.run("paper", "following", set={**HOLD, **IMU, "stop_at": 1.5})
    again = skylimb.replay(run)
    for name in ("thrusts_command", "angular_velocity_estimate", "accelerometer_bias_estimate"):
        np.testing.assert_array_equal(again.log[name].values, run.log[name].values, err_msg=name)


@pytest.mark.parametrize("gap", [0.3, 2.0])
def test_without_poses_it_goes_on_by_the_imu(gap: float) -> None:
    """In contact, with the supervisor as it ships: the way that it is off, and that it is not stopped."""
    lost = {"kind": "sensor", "time": 2.0, "capture": "lost", "duration": gap}
    settings = {**HOLD, **IMU, "trajectory.duration": 4.0, "supervisor.on": True, "events": [lost]}
    log = skylimb.run("paper", "following", set={**settings, "stop_at": 2.0 + gap}).log
    away = np.linalg.norm(log.cog_position_estimate.values - log.cog_position.values, axis=1)
    blind = log.time.values > 2.05
    assert log.capture_age.values[-1] == pytest.approx(gap + 0.01, abs=0.02)
    assert away[blind].max() < {0.3: 0.02, 2.0: 0.30}[gap]
    assert log.supervisor_mode.values.max() == {0.3: 1.0, 2.0: 2.0}[gap]  # goes on; flies back


def test_a_controller_that_needs_an_imu_is_refused_without_one() -> None:
    with pytest.raises(ConfigError, match=r"works on what an IMU measures: set sensors\.imu\.on = true"):
        skylimb.run("paper", "following", set={**HOLD, **ON})


@pytest.mark.parametrize(
    ("rate", "latency", "longest"), [(200, 0.075, "0.075"), (1000, 0.03, "0.015"), (1000, 0.015, "0.015")]
)
@pytest.mark.parametrize("estimation", [ON, {"controller.estimation.law": "kalman"}])
def test_frames_that_are_always_too_old_are_refused(
    estimation: dict[str, Any], rate: float, latency: float, longest: str
) -> None:
    """Nothing would ever correct where the IMU or the model goes: such flights were lost."""
    settings = {"sensors.imu.on": True, **estimation, "controller_rate": rate}
    told = rf"^sensors\.latency = {latency:g} s: controller 'following' .* for {longest} s at {rate} Hz"
    with pytest.raises(ConfigError, match=told):
        take_off("paper", ["following"], set={**settings, "sensors.latency": latency})


@pytest.mark.parametrize("controller", ["following", "drawing"])
def test_an_imu_that_is_lost_ends_in_a_level_descent(controller: str) -> None:
    """Its controller goes by it, and falls to the floor within .6 s where nobody watches."""
    lost = {"kind": "sensor", "time": 1.0, "imu": "lost"}
    settings = {**HOLD, **IMU, "trajectory.duration": 4.0, "events": [lost], "stop_at": 3.0}
    assert "floor" in skylimb.run("paper", controller, set={**settings, "supervisor.on": False}).cause
    run = skylimb.run("paper", controller, set={**settings, "supervisor.on": True})
    assert run.stopped, run.cause
    modes, quaternion = run.log.supervisor_mode.values, run.log.root_quaternion.values
    descends = float(list(TABLE.modes).index("DESCEND"))
    assert not modes[:219].any()
    assert (modes[222:] == descends).all()
    assert np.arccos(1.0 - 2.0 * (quaternion[:, 1] ** 2 + quaternion[:, 2] ** 2)).max() < 0.2
    assert run.log.cog_velocity.values[:, 2].min() > -0.5
