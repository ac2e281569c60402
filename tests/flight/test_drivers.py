"""All drivers fly the same flight, and a user's own controller flies in the same loop."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.control.controller import Controller
from skylimb.control.needs import needs_of
from skylimb.flight.flying import fly, fly_here
from skylimb.flight.takeoff import take_off

OWN_CONTROLLER = '''
"""A PD controller for the centre of gravity in plain NumPy; the attitude is kept by another."""
import numpy as np
from skylimb import Command


class Hover:
    name = "own"

    def __init__(self, robot):
        self.robot = robot

    def gains(self):
        return {"stiffness": 3.0, "damping": 3.5}

    def initial_state(self):
        return None

    def step(self, gains, state, measurement, reference, dt):
        q, psi = reference.joint_angles, reference.vectoring_angles
        s = self.robot.at(measurement.joint_angles, measurement.vectoring_angles)
        w, x, y, z = measurement.quaternion
        R_WB = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ])
        position = measurement.position + R_WB @ s.cog_root
        velocity = measurement.velocity + R_WB @ np.cross(measurement.angular_velocity, s.cog_root)
        wanted = gains["stiffness"] * (reference.position - position) - gains["damping"] * velocity
        force = s.mass * (wanted + [0.0, 0.0, 9.80665])
        R = R_WB @ s.R_root_C
        yaw = reference.heading - s.tip_heading
        heading = np.array([np.cos(yaw), np.sin(yaw), 0.0])
        up = force / np.linalg.norm(force)
        side = np.cross(up, heading)
        side /= np.linalg.norm(side)
        target = np.column_stack([np.cross(side, up), side, up])
        error = 0.5 * (target.T @ R - R.T @ target)
        turn = np.array([error[2, 1], error[0, 2], error[1, 0]])
        omega = s.R_root_C.T @ measurement.angular_velocity
        torque = -s.inertia_C @ (40.0 * turn + 13.0 * omega)
        Q = s.allocation_C
        thrusts = np.linalg.solve(Q[2:], [R[:, 2] @ force, 0, 0, 0]) + np.linalg.pinv(Q[3:]) @ torque
        return state, Command(np.clip(thrusts, 1.0, 30.0), q, psi), {"my_force": force}


def controller(robot):
    return Hover(robot)
'''


class Untraceable:
    """A cascade that hides that it can be traced, so that the free driver flies it with numbers."""

    def __init__(self, inner: Controller) -> None:
        self.name, self.step = inner.name, inner.step
        self.gains, self.initial_state, self.needs = inner.gains, inner.initial_state, needs_of(inner)


WEAK: dict[str, Any] = {
    "stop_at": 2.2,
    "plant.thrust_scale": 0.95,
    "plant.wall_pull": 0.1,
    "events": [{"kind": "rotor", "time": 0.3, "duration": 0.5, "rotor": "rotor2", "effectiveness": 0.97}],
}
"""Rotors that are weaker than they are told, beside a wall."""


@pytest.mark.parametrize(
    ("name", "until"),
    [("pid", {}), ("pid", WEAK), ("hybrid", {"stop_at": 2.2}), ("following", {"stop_at": 2.6})],
)
def test_all_drivers_agree(name: str, until: dict[str, Any]) -> None:
    """To the end once; the other flights until they have touched for 0.4 s, as numbers take long."""
    (takeoff,) = take_off("paper", (name,), set={**HOLD, **until})
    hidden = dataclasses.replace(takeoff, controller=Untraceable(takeoff.controller))
    assert takeoff.traceable
    assert not hidden.traceable
    compiled, fastest, slow = fly_here(takeoff), fly(takeoff), fly_here(hidden)
    assert slow.ticks == compiled.ticks == fastest.ticks
    assert slow.ticks >= min(len(takeoff.mission.times), until.get("stop_at", np.inf) / takeoff.period)
    assert compiled.signal("contact_duty").max() > 0.0
    np.testing.assert_array_equal(fastest.signals[: fastest.ticks], compiled.signals[: compiled.ticks])
    for signal in (
        "configuration",
        "thrusts",
        "motor_torques",
        "thrusts_command",
        "contact_force",
        "external_force_estimate",
        "reach_command",
    ):
        np.testing.assert_allclose(slow.signal(signal), compiled.signal(signal), atol=1e-9, err_msg=signal)


def test_a_users_numpy_controller_flies_from_its_file(tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    file.write_text(OWN_CONTROLLER)
    run = skylimb.run("paper", controller=str(file), set=HOLD)
    assert run.status == "OK", run.cause
    assert run.controller == "own"
    assert run.log["my_force"].dims == ("time", "axis")
    assert run.metrics["error_v_median"] < 0.05


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1", "controller"),
        ("def controller(robot):\n    return 1/0", "ZeroDivisionError"),
        ("import nonsense_module", "nonsense_module"),
    ],
)
def test_a_file_that_is_no_controller_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "bad.py"
    file.write_text(text)
    with pytest.raises(skylimb.SkylimbError, match=message):
        skylimb.run("paper", controller=str(file), set=HOLD)


def test_a_command_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "short.py"
    file.write_text(OWN_CONTROLLER.replace("Command(np.clip(thrusts, 1.0, 30.0)", "Command(thrusts[:3]"))
    with pytest.raises(skylimb.SkylimbError, match=r"thrusts: got shape \(3,\), .*\(4,\)"):
        skylimb.run("paper", controller=str(file), set=HOLD)


def test_an_error_in_a_controller_says_where(tmp_path: Path) -> None:
    file = tmp_path / "slip.py"
    file.write_text(
        OWN_CONTROLLER.replace("q, psi = reference.joint_angles", "q, psi = reference.joint_angels")
    )
    with pytest.raises(
        skylimb.SkylimbError,
        match=r"fails in .*slip\.py, line \d+, `q, psi = .*AttributeError",
    ):
        skylimb.run("paper", controller=str(file), set=HOLD)


def test_a_controller_that_lets_go_fails_with_its_last_states(tmp_path: Path) -> None:
    file = tmp_path / "limp.py"
    file.write_text(OWN_CONTROLLER.replace("np.clip(thrusts, 1.0, 30.0)", "np.zeros(4)"))
    run = skylimb.run("paper", controller=str(file), set=HOLD)
    assert run.status == "FAILED"
    assert run.cause
    assert run.metrics["error_u_median"] is None
    assert run.log.sizes["time"] > 10
    assert np.isfinite(run.log["cog_position"].values[-1]).all()


def test_a_controller_that_returns_nan_fails(tmp_path: Path) -> None:
    """At once it is refused before take-off; from its hundredth tick on it ends the flight."""
    file, no_numbers = tmp_path / "nan.py", "np.full(4, np.nan)"
    file.write_text(OWN_CONTROLLER.replace("np.clip(thrusts, 1.0, 30.0)", no_numbers))
    with pytest.raises(skylimb.SkylimbError, match=r"got \[nan, nan, nan, nan\], expected finite numbers"):
        skylimb.run("paper", controller=str(file), set=HOLD)
    counted = OWN_CONTROLLER.replace("return None", "return 0.0").replace(
        "return state,", "return state + 1.0,"
    )
    late = f"{no_numbers} if state > 99.5 else np.clip(thrusts, 1.0, 30.0)"
    file.write_text(counted.replace("np.clip(thrusts, 1.0, 30.0)", late))
    run = skylimb.run("paper", controller=str(file), set=HOLD)
    assert run.status == "FAILED"
    assert run.cause == "diverged: thrusts_command not finite at t = 0.500 s"
