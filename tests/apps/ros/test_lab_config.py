"""The lab's own YAML files: what they say is taken over, and what cannot be is refused with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

import skylimb
from skylimb.analysis.exchange.messages import UavInfo
from skylimb.apps.ros.lab_config import read_lab_config
from skylimb.base.errors import ConfigError

LAB = Path(__file__).parent / "lab"
MOTORS, SERVOS = LAB / "motor_info.yaml", LAB / "servo.yaml"
ROBOT = skylimb.load_robot("hydrus_xi_quad")


def test_motors_servos_and_kind_of_the_robot() -> None:
    config = read_lab_config([MOTORS, SERVOS], ROBOT)
    motors = config.motors
    assert motors is not None
    assert (motors.min_pwm, motors.max_pwm, motors.force_landing_thrust) == (0.58, 0.92, 7.0)
    assert [(one.voltage, one.max_thrust) for one in motors.motors] == [(25.2, 33.0), (22.2, 29.0)]
    assert motors.motors[1].polynomial == (2.6589065489, -5.343739409, 0.088138314, 0.0, 0.0)
    assert config.uav(ROBOT) == UavInfo(4, 17)
    assert read_lab_config([], ROBOT).motors is None


def test_counts_are_those_of_the_labs_servo_bridge() -> None:
    servos = read_lab_config([SERVOS], ROBOT).servos
    assert servos is not None
    found = servos.counts({"joint2": 0.5, "gimbal1": 0.5, "gimbal3": -100.0, "wheel": 1.0})
    assert found == {2: round(0.5 / 0.00076699) + 2047, 1: -326, 5: 16383}
    back = servos.angles([*found.items(), (77, 5)])
    assert [*back] == ["joint2", "gimbal1", "gimbal3"]
    assert back["joint2"] == pytest.approx(0.5, abs=0.0004)
    assert back["gimbal1"] == pytest.approx(0.5, abs=0.0008)


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        (MOTORS, "max_pwm: 0.92", "max_pwm: 0.5", "motor_info.max_pwm = 0.5 is not above min_pwm = 0.58"),
        (MOTORS, "    max_thrust: 29\n", "", "the key 'motor_info.ref2.max_thrust' is missing"),
        (MOTORS, "vel_ref_num: 2", "vel_ref_num: 3", "the key 'motor_info.ref3.voltage' is missing"),
        (MOTORS, "0.088138314", ".nan", "ref2.polynominal = nan (entry 3 of 5) is outside of"),
        (MOTORS, "motor_info:", "motors:", "has none of motor_info, servo_controller, uav_model"),
        (MOTORS, "motor_info:", "motor_info: [", "is no YAML"),
        (SERVOS, "    controller1: {id: 1, name: gimbal1}\n", "", "no servo for gimbal1"),
        (SERVOS, "name: joint1", "name: joint9", "no servo for joint1"),
        (SERVOS, "id: 3", "id: 1", "two servos have the same id"),
        (SERVOS, "angle_sgn: -1", "angle_sgn: 0", "angle_sgn = 0 is not one of 1, -1"),
        (SERVOS, "angle_scale: 0.001534", "angle_scale: 0", "angle_scale = 0 rad is outside"),
        (SERVOS, "uav_model: 17", "uav_model: 300", "uav_model = 300 is outside of 0 .. 255"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(
    tmp_path: Path, file: Path, old: str, new: str, words: str
) -> None:
    text = file.read_text(encoding="utf-8")
    assert old in text
    spoilt = tmp_path / "spoilt.yaml"
    spoilt.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        read_lab_config([spoilt], ROBOT)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_key_in_two_files_is_refused() -> None:
    with pytest.raises(ConfigError, match="both have motor_info"):
        read_lab_config([MOTORS, MOTORS], ROBOT)
