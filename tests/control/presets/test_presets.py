import re
from pathlib import Path
from typing import Any

import pytest

import skylimb
from skylimb.base.config import flatten, to_mapping
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.control.allocation.laws import vectored
from skylimb.control.cascade import Cascade
from skylimb.control.contact.laws import following as contact
from skylimb.control.controller import cascade_from_tables, load_controller
from skylimb.control.estimation.laws import predictive
from skylimb.control.laws.preset import preset_from_mapping, preset_mapping, preset_names
from skylimb.control.shape.laws import recentring
from skylimb.control.translation.laws import following
from skylimb.robots.model import Robot

KINDS = {"tilting", "pushing", "chain", "vectoring", "pairs", "pushing_pairs"}
"""Tables that are of no robot by name."""


def test_the_presets_hold_the_papers_gains(robot: Robot) -> None:
    hybrid = load_controller("hybrid", robot)
    assert isinstance(hybrid, Cascade)
    gains = hybrid.gains()
    assert list(gains.estimation.observer.force) == [3.0, 3.0, 3.0]
    assert list(gains.estimation.observer.torque) == [1.0, 1.0, 1.0]
    assert list(gains.translation.virtual_mass_ratio) == [1.0, 3.0, 1.0]
    assert list(gains.translation.normalized_stiffness) == [2.5, 2.5, 1.5]
    assert list(gains.translation.damping_ratio) == [0.6, 0.6, 0.7]
    assert list(gains.attitude.virtual_inertia_ratio) == [10.0, 10.0, 5.0]
    assert list(gains.attitude.normalized_stiffness) == [40.0, 40.0, 10.0]
    assert list(gains.attitude.damping_ratio) == [1.1, 1.1, 0.8]
    assert (gains.shape.mass, gains.shape.damping, gains.shape.stiffness) == (40.0, 55.0, 16.0)
    assert gains.shape.force_reference == 0.0
    assert not hybrid.preset.slots.allocation.gains.leak.compensate


@pytest.mark.parametrize(
    ("name", "translation", "shape"),
    [("pid", "pid", "fixed"), ("impedance", "impedance", "fixed"), ("admittance", "pid", "admittance"),
     ("hybrid", "impedance", "admittance")],
)  # fmt: skip
def test_the_four_controllers_are_two_slots(robot: Robot, name: str, translation: str, shape: str) -> None:
    controller = load_controller(name, robot)
    assert isinstance(controller, Cascade)
    assert (controller.preset.slots.translation.name, controller.preset.slots.shape.name) == (
        translation,
        shape,
    )


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("[translation]\nlaw = 'impedence'", UnknownNameError, "did you mean 'impedance'"),
        ("[translation]\nlaw = 'pid'\nproportinal = [1,1,1]", UnknownNameError, "proportional"),
        ("[shape]\nlaw = 'admittance'\nmass = -40.0\ndamping = 1.0\nstiffness = 1.0", ConfigError, "mass"),
        ("[shape]\nlaw = 'admittance'\nmass = 'heavy'\ndamping = 1.0\nstiffness = 1.0", ConfigError, "mass"),
        ("[shpae]\nlaw = 'fixed'", UnknownNameError, "did you mean 'shape'"),
        ("[shape]\nlaw = 'missing_file.py'", ConfigError, "missing_file.py"),
    ],
)
def test_a_wrong_preset_is_refused_by_name(
    tmp_path: Path, robot: Robot, text: str, error: type[Exception], message: str
) -> None:
    table = re.match(r"\[(\w+)\]", text)
    whole = (Path(skylimb.__file__).parent / "control" / "presets" / "hybrid.toml").read_text()
    if table and f"[{table[1]}]" in whole:
        whole = re.sub(rf"\[{table[1]}\].*?(?=\n\[|\Z)", text, whole, flags=re.S)
    else:
        whole += "\n" + text
    file = tmp_path / "mine.toml"
    file.write_text(whole)
    with pytest.raises(error, match=message):
        load_controller(str(file), robot)


def test_a_users_own_law_fills_a_slot(tmp_path: Path, robot: Robot) -> None:
    """One file, one line in the preset."""
    (tmp_path / "halfway.py").write_text(
        "from dataclasses import dataclass\n"
        "from skylimb.control.records import ArmTarget\n"
        "@dataclass(frozen=True)\nclass Gains:\n    share: float = 0.5\n"
        "def initial_state(gains, start):\n    return ()\n"
        "def step(gains, state, inputs, reach_limits):\n"
        "    return state, ArmTarget(inputs.reference.reach + gains.share * 0.02), {}\n"
    )
    whole = (Path(skylimb.__file__).parent / "control" / "presets" / "impedance.toml").read_text()
    file = tmp_path / "mine.toml"
    file.write_text(whole.replace('law = "fixed"', 'law = "halfway.py"\nshare = -1.0'))
    run = skylimb.run("push", controller=str(file))
    assert float(run.log["reach_command"][-1] - run.log["reach_reference"][-1]) == pytest.approx(-0.02)


def test_gains_can_be_set_from_outside(robot: Robot) -> None:
    changed = load_controller("hybrid", robot, {"shape.stiffness": 30.0, "allocation.leak.compensate": True})
    assert isinstance(changed, Cascade)
    assert changed.gains().shape.stiffness == 30.0
    assert changed.preset.slots.allocation.gains.leak.compensate


def of_its_own(tmp_path: Path, text: str) -> str:
    """`following` with other tables of robots."""
    whole = (Path(skylimb.__file__).parent / "control" / "presets" / "following.toml").read_text()
    file = tmp_path / "mine.toml"
    file.write_text(re.sub(r"\[robots\..*", "", whole, flags=re.S) + text)
    return str(file)


def test_a_preset_says_what_is_different_for_a_robot(tmp_path: Path, robot: Robot) -> None:
    file = of_its_own(
        tmp_path,
        f"[robots.{robot.name}]\nallocation.law = 'bounded'\nallocation.rate = 500.0\n"
        "translation.force = 2.0\n[robots.another]\ntranslation.force = 3.0\n",
    )
    plain, own = load_controller("following", robot), load_controller(file, robot)
    assert isinstance(plain, Cascade)
    assert isinstance(own, Cascade)
    assert own.gains().translation.force == 2.0
    allocation = own.preset.slots.allocation
    assert (allocation.name, allocation.gains.rate) == ("bounded", 500.0)
    assert allocation.gains.leak.cutoff == plain.gains().allocation.leak.cutoff  # both laws have it
    assert "robots" not in own.tables()
    # What the user sets counts last, and another law forgets the keys of the first.
    chosen = {"translation.force": 1.5, "allocation.law": "pseudoinverse"}
    last = load_controller(file, robot, chosen)
    assert isinstance(last, Cascade)
    assert last.gains().translation.force == 1.5
    assert last.preset.slots.allocation.name == "pseudoinverse"


def test_a_preset_says_what_is_different_with_an_imu(robot: Robot) -> None:
    """Only where the IMU says the motion; what a robot or the user says of the same key counts otherwise."""
    tables, path = preset_mapping("following")
    tables["imu"] = {"translation": {"force": 1.2, "stiffness": [4.0, 8.0, 8.0]}}

    def gains(**given: Any) -> Any:
        changes = {key.replace("__", "."): value for key, value in given.items()}
        return cascade_from_tables(tables, path, robot, changes).gains()

    assert gains().translation.force == 1.0
    assert gains(estimation__smoothing__imu=False).translation.force == 1.0
    assert gains(estimation__smoothing__imu=True).translation.force == 1.2
    both = gains(estimation__smoothing__imu=True, translation__force=1.5)
    assert (both.translation.force, list(both.translation.stiffness)) == (1.5, [4.0, 8.0, 8.0])
    with pytest.raises(ConfigError, match=r"controller following: imu = 3 should be a table, \[imu\]"):
        cascade_from_tables({**tables, "imu": 3}, path, robot)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[robots.{0}]\ntranslation.forse = 2.0\n", "did you mean 'translation.force'"),
        ("[robots]\n{0} = 3\n", re.escape("robots.hydrus_xi_quad = 3 should be a table, [robots.NAME]")),
    ],
)
def test_a_wrong_table_of_a_robot_is_refused(tmp_path: Path, robot: Robot, text: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        load_controller(of_its_own(tmp_path, text.format(robot.name)), robot)


@pytest.mark.parametrize("name", preset_names())
def test_every_robot_that_a_preset_names_ships_and_can_be_flown_by_it(name: str) -> None:
    for other in preset_mapping(name)[0].get("robots", {}).keys() - KINDS:
        assert isinstance(load_controller(name, skylimb.load_robot(other)), Cascade)


def test_unknown_controller_names_the_nearest(robot: Robot) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'hybrid'"):
        load_controller("hybird", robot)


@pytest.mark.parametrize(
    ("key", "right"),
    [
        ("leak.compensate", "allocation.leak.compensate"),
        ("observer.force", "estimation.observer.force"),
        ("tare", "estimation.tare"),
        ("calibration.feed", "estimation.calibration.feed"),
        ("delay.latency", "estimation.delay.latency"),
        ("delay.rotor_lag", "allocation.rotor_lag.time_constant"),
        ("delay.compensate", 'estimation.law = "predictive"'),
        ("vectoring.move", 'allocation.law = "vectored"'),
        ("vectoring.cutoff", "allocation.vectoring.cutoff"),
        ("force_filter.cutof", "estimation.force_filter"),
    ],
)
def test_a_key_without_its_slot_is_refused_with_the_whole_one(robot: Robot, key: str, right: str) -> None:
    with pytest.raises(UnknownNameError, match=f"'controller.{key}' of controller hybrid.*") as refused:
        load_controller("hybrid", robot, {key: True})
    assert str(refused.value).endswith(f"did you mean 'controller.{right}'?")


@pytest.mark.parametrize("name", ["pid", "impedance", "admittance", "hybrid"])
def test_any_of_the_papers_four_can_have_what_they_lack(robot: Robot, name: str) -> None:
    changed = load_controller(
        name,
        robot,
        {
            "allocation.leak.compensate": True,
            "allocation.rotor_lag.compensate": True,
            "estimation.delay.latency": 0.03,
            "estimation.law": "predictive",
        },
    )
    assert isinstance(changed, Cascade)
    gains = changed.gains()
    assert changed.preset.slots.estimation.name == "predictive"
    assert gains.estimation.delay.latency == 0.03
    assert list(gains.estimation.observer.force) == [3.0, 3.0, 3.0]
    assert gains.allocation.leak.compensate
    assert gains.allocation.rotor_lag.lead == 2.0


def test_another_law_keeps_the_gains_that_it_has_in_common(robot: Robot) -> None:
    changed = load_controller("following", robot, {"allocation.law": "pseudoinverse"})
    assert isinstance(changed, Cascade)
    allocation = changed.preset.slots.allocation
    assert allocation.name == "pseudoinverse"
    assert (allocation.gains.leak.compensate, allocation.gains.leak.cutoff) == (True, 3.0)
    assert (allocation.gains.hold_lift, allocation.gains.vectoring.purpose) == (False, "contact")
    assert changed.needs.vectoring == "contact"
    with pytest.raises(UnknownNameError, match=r"allocation\.vectoring\.lead"):
        load_controller(
            "following", robot, {"allocation.law": "pseudoinverse", "allocation.vectoring.lead": 2.0}
        )


def test_tables_are_read_back(robot: Robot) -> None:
    for name in preset_names():
        made = cascade_from_tables(*preset_mapping(name), robot)
        again = preset_from_mapping(made.tables(), Path("x.toml"))
        assert again == made.preset


_SPRING = '''
from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from skylimb.base.keys import Key, configuration


@dataclass
class Plain:
    number: float = 1.0


@configuration
class Gains:
    """A spring."""

    stiffness: Annotated[float, Key("1/s^2", "stiffness of the spring", above=0.0, high=100.0)] = 3.0


def initial_state(gains, start):
    return ()


def step(gains, state, inputs):
    return state, inputs.body.model.mass * gains.stiffness, {}
'''


def test_keys_of_a_users_own_law_are_checked_and_named_in_full(tmp_path: Path, robot: Robot) -> None:
    (tmp_path / "spring.py").write_text(_SPRING)
    (tmp_path / "bouncy").mkdir()
    (tmp_path / "bouncy" / "spring.py").write_text(_SPRING.replace("3.0", "5.0"))
    tables = preset_mapping("hybrid")[0]
    for folder, stiffness in ((tmp_path, 3.0), (tmp_path / "bouncy", 5.0)):
        preset = preset_from_mapping({**tables, "translation": {"law": "spring.py"}}, folder / "mine.toml")
        assert preset.slots.translation.gains.stiffness == stiffness
    table = {"law": "spring.py", "stiffness": 300.0}
    with pytest.raises(ConfigError, match=r"translation\.stiffness = 300 1/s\^2 must be above 0"):
        preset_from_mapping({**tables, "translation": table}, tmp_path / "mine.toml")


SMOOTHING = {
    "smoothing.on": False, "smoothing.position": 20.0, "smoothing.velocity": 40.0,
    "smoothing.attitude": 40.0, "smoothing.angular_velocity": 40.0,
    "smoothing.imu": False, "smoothing.bias": 0.3,
}  # fmt: skip


def flattened(tables: dict[str, Any], slot: str) -> dict[str, Any]:
    return {key: value for key, value in flatten(tables[slot]).items() if key != "law"}


def test_the_presets_are_what_has_been_flown(robot: Robot) -> None:
    """Every number, those that no file states among them: a default that changes changes flights."""
    following = cascade_from_tables(*preset_mapping("following"), robot).tables()
    assert flattened(following, "estimation") == {
        "angle_rates.bandwidth": 50.0, "observer.force": [5.0] * 3, "observer.torque": [3.0] * 3,
        "force_filter.cutoff": 2.0, "tare": True, "delay.latency": 0.02, "calibration.feed": True,
        "calibration.attitude": True, "calibration.cog": True, "calibration.thrust": True,
        "calibration.rate": 1.0,
        **SMOOTHING, "smoothing.on": True, "smoothing.velocity": 25.0,
    }  # fmt: skip
    assert flattened(following, "contact") == {
        "approach_speed": 0.025, "approach_ramp": 1.0, "return_speed": 0.05, "retreat_speed": 0.1,
        "axis_speed": 0.025,
        "least_pace": 0.25, "path_acceleration": 0.05, "wait_beyond": 0.08, "waiting_pace": 0.1,
        "waiting_speed": 100.0, "body_share": 0.5,
        "ease_beyond": [0.015, 0.04], "ease_grows": 3.2, "least_ease": 0.2, "ease_ahead": 1.0, "growth": 1.0,
        "machine.touch_force": 0.5,
        "machine.touch_time": 0.015, "machine.lost_force": 0.25, "machine.lost_time": 0.2,
        "machine.settle_time": 1.0, "machine.rest_time": 0.5, "machine.search": 0.25,
        "machine.search_again": 0.1, "surface.drift": 0.1, "surface.height_noise": 0.003,
        "surface.cross_noise": 3.0,
    }  # fmt: skip
    assert flattened(following, "shape") == {
        "rate": 0.3, "arm_share": 0.0, "rate_limit": 0.08, "offset": 0.0
    }  # fmt: skip
    assert flattened(following, "translation") == {
        "stiffness": [5.0, 10.0, 5.0], "damping_ratio": [0.8, 0.7, 0.8], "stiffening": 0.6,
        "press_stiffness": 0.3,
        "press_damping": 4.0, "press_mass_ratio": 0.7, "force": 1.0, "force_integral": 0.5,
        "force_integral_limit": 3.0, "tank": 0.5, "cancel": [0.5, 0.7], "cancel_cutoff": [5.0, 5.0],
        "cancel_limit": 1.0, "cancel_speed": 0.06, "error_limit": 0.1, "pen": 1.0, "hanging": 1.0,
        "feed": 0.0, "swing": [0.0, 0.0], "swing_cutoff": 1.0, "swing_speed": 10.0,
        "landing_cancel": [0.0, 0.0], "leaving_swing": [0.0, 0.0],
    }  # fmt: skip
    assert flattened(following, "allocation") == {
        "hold_lift": True, "weights.roll_pitch": 10.0, "weights.lift": 3.0, "weights.sideways": 1.0,
        "weights.yaw": 0.3, "leak.compensate": True, "leak.cutoff": 3.0, "rotor_lag.compensate": True,
        "rotor_lag.time_constant": 0.05, "rotor_lag.lead": 2.0, "rotor_lag.bandwidth": 120.0,
        "rotor_lag.reaction": True, "vectoring.purpose": "contact",
        "vectoring.limit": 0.5, "vectoring.damping": 0.5, "vectoring.cutoff": 2.0, "vectoring.lead": 2.0,
    }  # fmt: skip
    hybrid = cascade_from_tables(*preset_mapping("hybrid"), robot).tables()
    assert flattened(hybrid, "estimation") == {
        "angle_rates.bandwidth": 30.0, "observer.force": [3.0] * 3, "observer.torque": [1.0] * 3,
        "force_filter.cutoff": 2.0, "tare": True, **SMOOTHING,
    }  # fmt: skip
    assert flattened(hybrid, "allocation") == {
        "hold_lift": False, "leak.compensate": False, "leak.cutoff": 0.5, "leak.steady": False,
        "rotor_lag.compensate": False, "rotor_lag.time_constant": 0.05, "rotor_lag.lead": 2.0,
        "rotor_lag.bandwidth": 1e6, "rotor_lag.reaction": False, "vectoring.purpose": "torque",
    }  # fmt: skip
    assert flattened(hybrid, "contact") == {}


def test_what_a_law_does_where_no_preset_says_otherwise() -> None:
    assert to_mapping(contact.Gains()) == {
        "approach_speed": 0.05, "approach_ramp": 1.0, "return_speed": 0.05, "retreat_speed": 0.1,
        "axis_speed": 0.04,
        "least_pace": 0.25, "path_acceleration": 0.1, "wait_beyond": 0.08, "waiting_pace": 0.1,
        "waiting_speed": 100.0, "body_share": 0.5,
        "ease_beyond": [0.015, 0.04], "ease_grows": 2.0, "least_ease": 1.0, "ease_ahead": 1.0, "growth": 1e3,
        "machine": to_mapping(contact.MachineGains()),
        "surface": {"drift": 0.5, "height_noise": 0.003, "cross_noise": 3.0},
    }  # fmt: skip
    springs = {"stiffness": [5.0] * 3, "damping_ratio": [1.0] * 3}
    assert to_mapping(following.Gains((5.0, 5.0, 5.0), (1.0, 1.0, 1.0))) == {
        **springs, "stiffening": 0.0, "press_stiffness": 0.3, "press_damping": 3.3,
        "press_mass_ratio": 0.6, "force": 1.0, "force_integral": 0.5, "force_integral_limit": 3.0,
        "tank": 0.5, "cancel": [1.0, 1.0], "cancel_cutoff": [5.0, 5.0], "cancel_limit": 1.0,
        "cancel_speed": 0.06, "error_limit": 0.1, "pen": 1.0, "hanging": 0.0, "feed": 0.0,
        "swing": [0.0, 0.0], "swing_cutoff": 1.0, "swing_speed": 10.0,
        "landing_cancel": [0.0, 0.0], "leaving_swing": [0.0, 0.0],
    }  # fmt: skip
    assert to_mapping(recentring.Gains()) == {
        "rate": 0.3,
        "arm_share": 0.5,
        "rate_limit": 0.08,
        "offset": 0.0,
    }
    assert to_mapping(vectored.Gains()) == {
        "hold_lift": True,
        "weights": {"roll_pitch": 10.0, "lift": 3.0, "sideways": 1.0, "yaw": 0.3},
        "leak": {"compensate": False, "cutoff": 0.5},
        "rotor_lag": {
            "compensate": False, "time_constant": 0.05, "lead": 2.0, "bandwidth": 1e6, "reaction": False
        },
        "vectoring": {"purpose": "torque", "limit": 0.5, "damping": 0.5, "cutoff": 1.0, "lead": 1.0},
    }  # fmt: skip
    assert predictive.Gains().calibration == predictive.Calibration(False, False, False, False, 1.0)
