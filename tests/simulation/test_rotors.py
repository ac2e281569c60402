"""Rotors with a speed and an inertia: their torques against Pinocchio, and what they refuse."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import casadi as ca
import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.errors import ConfigError
from skylimb.flight.takeoff import take_off
from skylimb.robots import load_robot
from skylimb.simulation.rotors import RotorNumbers, RotorTick, momentum_forces, rotor_numbers, rotor_tick

pin: Any = import_module("pinocchio")
PERIOD = 0.005


@pytest.mark.parametrize("name", ["hydrus_xi_quad", "dragon", "tilted_hexarotor"])
def test_torques_of_the_rotors_are_pinocchios(name: str) -> None:
    """Pinocchio's inverse dynamics with joints for the rotors, less the same with rotors that stand still."""
    robot = load_robot(name)
    d, rng = robot.description, np.random.default_rng(4)
    model = pin.buildModelFromUrdf(str(d.folder / d.sources[1].path.name), pin.JointModelFreeFlyer())
    still = model.nv
    inertias = rng.uniform(1e-4, 4e-4, robot.n_rotors)
    for rotor, inertia in zip(d.rotors, inertias, strict=True):
        frame = model.frames[model.getFrameId(rotor.link, pin.FrameType.BODY)]
        placement = frame.placement * pin.SE3(rotor.R, rotor.xyz)
        joint = model.addJoint(frame.parentJoint, pin.JointModelRZ(), placement, f"turn {rotor.name}")
        body = pin.Inertia(0.0, np.zeros(3), np.diag([0.0, 0.0, inertia]))
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    data, names = model.createData(), [*d.shape_joints, *d.vectoring_joints]
    for _ in range(5):
        x, v = pin.neutral(model), np.zeros(model.nv)
        angles, rates = rng.uniform(-1.0, 1.0, len(names)), rng.normal(size=3 + len(names))
        v[3:6] = rates[:3]
        for angle, rate, joint_name in zip(angles, rates[3:], names, strict=True):
            joint = model.joints[model.getJointId(joint_name)]
            x[joint.idx_q : joint.idx_q + joint.nq] = (
                [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            )
            v[joint.idx_v] = rate
        speeds, accelerations = rng.uniform(100.0, 900.0, robot.n_rotors), rng.normal(size=robot.n_rotors)
        turning, a = v.copy(), np.zeros(model.nv)
        spins = [rotor.spin for rotor in d.rotors]
        turning[still:], a[still:] = spins * speeds, spins * accelerations
        needed = pin.rnea(model, data, x, turning, a) - pin.rnea(model, data, x, v, np.zeros(model.nv))
        none = ca.DM(robot.n_rotors, 1)
        numbers = RotorNumbers(none, none, inertias, none, none, none)
        tick = RotorTick(ca.DM(1), ca.DM(speeds), ca.DM(accelerations), ca.DM(speeds), ca.DM(1))
        found = np.array(ca.evalf(momentum_forces(robot, numbers, tick, angles, ca.SX(rates)))).ravel()
        places = [3, 4, 5, *(model.joints[model.getJointId(one)].idx_v for one in names)]
        np.testing.assert_allclose(found, -needed[places], atol=1e-10)
        np.testing.assert_allclose(needed[:3], 0.0, atol=1e-10)


def tick_of(thrusts: Any, commanded: Any, **changes: Any) -> dict[str, np.ndarray]:
    numbers = rotor_numbers(load_robot("hydrus_xi_quad").description, PERIOD)._replace(**changes)
    found = rotor_tick(numbers, np.asarray(thrusts, float), np.asarray(commanded, float), PERIOD)
    return {name: np.array(ca.DM(value)).ravel() for name, value in found._asdict().items()}


def test_a_steady_rotor_needs_the_torque_of_its_drag() -> None:
    found = tick_of([10.0] * 4, [10.0] * 4)
    np.testing.assert_allclose(found["motor_torques"], 0.182, rtol=1e-12)
    np.testing.assert_allclose(found["accelerations"], 0.0, atol=1e-9)
    np.testing.assert_allclose(found["controls"], 10.0, rtol=1e-12)
    np.testing.assert_allclose(found["speeds"], np.sqrt(10.0 / 4.04e-5), rtol=1e-12)


def test_no_motor_gives_more_than_its_torque() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        found = tick_of(rng.uniform(1.0, 30.0, 4), rng.uniform(1.0, 30.0, 4))
        assert np.all(np.abs(found["motor_torques"]) < 0.8 * 1.001)


def test_without_inertia_the_speed_only_lags() -> None:
    found = tick_of([4.0] * 4, [9.0] * 4, inertia=np.zeros(4))
    wanted, now = np.sqrt(9.0 / 4.04e-5), np.sqrt(4.0 / 4.04e-5)
    after = now + found["accelerations"] * PERIOD
    np.testing.assert_allclose(after, wanted + (now - wanted) * np.exp(-PERIOD / 0.05), rtol=1e-12)


def test_a_command_below_nothing_is_a_rotor_that_stops() -> None:
    found = tick_of([0.01] * 4, [-5.0] * 4)
    assert np.isfinite([*found.values()]).all()
    assert np.all(found["accelerations"] <= 0.0)


SPEED = {"plant.rotors": "speed"}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"plant.rotors": "thrust", "plant.rotor_inertia": 2e-4},
            "plant.rotor_inertia = 0.0002 kg m.2 has no effect .* it needs",
        ),
        ({**SPEED, "plant.rotor_inertia": 0.3}, "plant.rotor_inertia = 0.3 kg m.2 is outside of -1 .. 0.1"),
        (
            {"plant.rotor_inertia": -2e-4},
            "plant.rotor_inertia = -0.0002 is below 0; -1 keeps what the robot's",
        ),
        ({"plant.rotor_lag": -0.05}, "plant.rotor_lag = -0.05 is below 0; -1 keeps what the robot's"),
        ({"plant.rotors": "spead"}, "plant.rotors = 'spead' is not one of 'described', 'speed', 'thrust'"),
    ],
)
def test_nonsense_is_refused_by_name(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        skylimb.run("paper", "hybrid", set=given)


def test_a_robot_that_says_nothing_of_its_rotors_is_refused(tmp_path: Any) -> None:
    folder = load_robot("hydrus_xi_quad").description.folder
    for path in folder.glob("*.*"):
        text = path.read_text(encoding="utf-8")
        (tmp_path / path.name).write_text(text.replace("inertia = 2.0e-4\n", ""), encoding="utf-8")
    given = {**HOLD, **SPEED, "robot": str(tmp_path / "flight.toml")}
    with pytest.raises(ConfigError, match=r"needs rotors\.inertia, which rotor1 of robot hydrus_xi_quad"):
        skylimb.run("paper", "hybrid", set=given)
    for rotors in ("speed", "described"):
        run = skylimb.run(
            "paper", "hybrid", set={**given, "plant.rotors": rotors, "plant.rotor_inertia": 1e-4}
        )
        assert run.status == "OK"
        assert {"rotor_speeds", "motor_torques"} <= set(run.log.data_vars)
    # As it is described such a robot has the paper's rotors.
    run = skylimb.run("paper", "hybrid", set={**given, "plant.rotors": "described"})
    assert "rotor_speeds" not in run.log


def test_flights_with_other_inertias_share_a_function() -> None:
    one, other = (
        take_off("paper", ("hybrid",), set={**HOLD, **SPEED, "plant.rotor_inertia": inertia})[0].tick
        for inertia in (1e-4, 3e-4)
    )
    assert one.function is other.function
    assert np.any(one.rotors != other.rotors)
