"""What a robot cannot hold is refused before take-off: a posture, a touch, or the force of a task."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import skylimb
from made_robots import multirotor
from short_flights import HOLD
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.base.errors import AllocationError, ConfigError
from skylimb.control.planning.posture_limits import nearest_posture
from skylimb.control.planning.vectoring_step import first_vectoring, settled_vectoring
from skylimb.flight.feasible import _refused_hover
from skylimb.flight.takeoff import take_off
from skylimb.robots.equilibrium import can_hold
from skylimb.robots.equilibrium_results import NotHeld, Within
from skylimb.robots.loader import read_description
from skylimb.robots.model import Robot
from skylimb.robots.touch import can_touch

FORCE = "controller.translation.force"
FLY = {"approach.doubtful": "fly"}
STRAIGHT = [[0.0, 0.0, 0.0]]


def refused(**given) -> str:
    with pytest.raises(ConfigError) as raised:
        take_off("free_flight", ("pid",), 0, given)
    return str(raised.value)


def test_a_way_through_a_weak_posture_is_refused_with_limit_place_and_nearest():
    said = refused(**{"posture.margin": 2.5, "posture.waypoints": STRAIGHT})
    assert re.match(r"'hydrus_xi_quad' cannot hover at q = \[.*\] rad: the (least|greatest) thrust of", said)
    assert re.search(r"leaves a margin of [0-2]\.\d+ N m, of 2\.5 N m \(posture\.margin\), \d", said)
    assert re.search(r"\d\.\d s after posture\.waypoints begin; the nearest posture", said)
    nearest = np.array(re.findall(r"-?\d\.\d+", said.rpartition("leaves it is")[2]), dtype=float)
    # It leaves enough, with angles of its own.
    robot = skylimb.load_robot("hydrus_xi_quad")
    found = [
        can_hold(robot, nearest, settled_vectoring(robot, nearest, psi).angles, None, Within(margin=2.3))
        for psi in np.random.default_rng(0).uniform(-3, 3, (6, 4))
    ]
    assert any(found)


def test_where_only_the_vectoring_angles_are_weak_it_says_so():
    robot = skylimb.load_robot("hydrus_xi_quad")
    q, weak = robot.nominal_posture(), first_vectoring(robot).angles + 0.4 * np.array([1.0, -1.0, 1.0, -1.0])
    found = can_hold(robot, q, weak, None, Within(margin=3.0))
    assert isinstance(found, NotHeld)
    said = _refused_hover(robot, (q, weak), found, 1.0)
    assert "other vectoring angles leave it there, so come to it another way" in said
    assert "nearest posture" not in said


def test_a_margin_that_is_left_lets_it_fly():
    (takeoff,) = take_off("free_flight", ("pid",), 0, {"posture.margin": 1.0, "posture.waypoints": []})
    assert takeoff.experiment.posture.margin == 1.0


def test_more_than_any_posture_leaves_says_so():
    assert "no posture near it leaves more" in refused(**{"posture.margin": 30.0, "posture.waypoints": []})


def test_the_nearest_posture_of_a_good_one_is_itself():
    robot = skylimb.load_robot("hydrus_xi_quad")
    q = robot.nominal_posture()
    psi = settled_vectoring(robot, q, robot.description.vectoring_start).angles
    assert nearest_posture(robot, q, psi, 1.0) == pytest.approx(q, abs=1e-4)


def heavy_in_front(folder: Path, load: float) -> Path:
    """A hexarotor with a mass before it: the more, the more uneven its thrusts."""
    path = multirotor(folder, cant=0.5, mass=0.7, thrust_max=12.0)
    urdf = path.with_name("robot.urdf")
    front = f'<link name="load"><inertial><mass value="{load}"/>'
    front += '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    front += '<joint name="hold" type="fixed"><parent link="base"/><child link="load"/>'
    front += '<origin xyz="0.45 0 0"/></joint></robot>'
    urdf.write_text(urdf.read_text().replace("</robot>", front))
    return path


def test_what_the_check_passes_takes_off_and_what_it_refuses_is_refused_in_the_same_words(tmp_path: Path):
    """Least-norm thrusts of six rotors leave their limits before all thrusts do; others are taken then."""
    passed, heavier = heavy_in_front(tmp_path / "passed", 0.6), heavy_in_front(tmp_path / "heavier", 1.6)
    assert Robot(read_description(passed)).at([], []).hover_thrusts.min() < 0.0
    robot = skylimb.load_robot(str(passed))
    state, (low, high) = robot.at([], []), robot.thrust_limits()
    assert np.all(state.hover_thrusts > low)
    assert np.all(state.hover_thrusts < high)
    wrench = state.allocation_C @ state.hover_thrusts
    np.testing.assert_allclose(wrench, [0, 0, robot.weight, 0, 0, 0], atol=1e-6 * robot.weight)
    report = check_robot_file(passed)
    assert report.can_hover
    assert not any("least-norm" in doubt.value for doubt in report.doubts)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        given = {"robot": str(passed.parent), "posture.waypoints": [], "stop_at": 6.0}
        run = skylimb.run("free_flight", controller="pid", set=given)
    assert run.status == "STOPPED"
    report = check_robot_file(heavier)
    assert not report.can_hover
    with pytest.raises(AllocationError, match="'made' cannot hover: the greatest thrust of") as caught:
        skylimb.load_robot(str(heavier))
    assert "cannot hover" in report.reasons[0].value
    assert report.reasons[0].value.split(": ")[1].split(";")[0] in str(caught.value)


def test_a_tip_behind_its_rotors_can_hover_and_cannot_touch(tmp_path: Path):
    path = multirotor(tmp_path)
    path.write_text(path.read_text().replace("position = [0.6, 0.0, 0.0]", "position = [0.05, 0.0, 0.0]"))
    robot = skylimb.load_robot(str(path))
    touch = can_touch(robot, np.zeros(0), np.zeros(0))
    assert not touch
    report = check_robot_file(path)
    assert report.can_hover
    assert not report.can_touch
    with pytest.raises(ConfigError, match=r"'made' cannot touch .* is 0\.\d+ m before the tip"):
        take_off("paper", ("hybrid",), set={"robot": str(tmp_path)})
    assert take_off("free_flight", ("pid",), set={"robot": str(tmp_path), "posture.waypoints": []})


def test_the_direction_in_which_a_tip_is_foremost_is_the_best_of_all():
    for name in ("hydrus_xi_quad", "hydrus_xi_quad_mast", "dragon", "tilted_hexarotor"):
        robot = skylimb.load_robot(name)
        given = robot, robot.nominal_posture(), robot.description.vectoring_start
        best = can_touch(*given)
        ways = np.random.default_rng(0).normal(size=(300, 3))
        rooms = [can_touch(*given, way / np.linalg.norm(way)).room for way in ways]
        assert best.room >= max(rooms)
        assert best.room < max(rooms) + 0.05


def test_a_force_beyond_the_thrusts_is_refused_with_what_can_be_held() -> None:
    with pytest.raises(ConfigError) as caught:
        skylimb.begin("ceiling", "following", set={FORCE: 20.0})
    words = str(caught.value)
    assert words.startswith("controller 'following' commands a force of 20 N; in its nominal posture ")
    assert re.search(r"hydrus_xi_quad_mast can hold about 19\.\d+ N along the contact axis", words)
    assert words.endswith("is in the way")


def test_a_force_beyond_the_tilt_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"the tilt \(0\.1 rad\) is in the way"):
        skylimb.begin("paper", "following", set={FORCE: 20.0, "terminations.tilt": 0.1})


def test_a_force_that_a_gain_change_raises_is_looked_at() -> None:
    change = {"kind": "gain", "time": 12.0, "key": "translation.force", "value": 20.0}
    with pytest.raises(ConfigError, match="commands a force of 20 N"):
        skylimb.begin("ceiling", "following", set={"events": [change]})
    assert take_off("ceiling", ["following"], set={"events": [change | {"value": 15.0}], **FLY})


@pytest.mark.filterwarnings("ignore:a force of")
@pytest.mark.parametrize(("experiment", "force"), [("paper", 12.0), ("ceiling", 15.0), ("push", 20.0)])
def test_a_force_that_can_be_held_or_is_never_pressed_takes_off(experiment: str, force: float) -> None:
    assert take_off(experiment, ["following"], set={FORCE: force, **FLY})


BELIEVED = "approach.believed_friction"


def test_what_is_believed_may_not_be_ruled_out():
    with pytest.raises(ConfigError, match=r"believed_friction = \[0\.9, 0\.1\] rules out what is believed"):
        skylimb.load_experiment("paper", set={BELIEVED: [0.9, 0.1]})


@pytest.mark.parametrize(("friction", "held", "most"), [(0.4, "10.5", "6.3"), (0.8, "5.5", "3.3")])
def test_a_force_that_leaves_too_little_over_is_refused_with_what_takes_off(
    friction: float, held: str, most: str
) -> None:
    believed = {BELIEVED: [friction, 0.9]}
    with pytest.raises(ConfigError) as caught:
        take_off("paper", ["drawing"], set={FORCE: 7.0, **believed})
    words = str(caught.value)
    assert words.startswith(f"a force of 7 N is too much: with a friction of {friction} as believed")
    assert f"can hold about {held} N at rest" in words
    assert f"; {most} N and less take off" in words
    assert 'approach.doubtful = "fly" flies 7 N' in words
    assert "\n" not in words
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        take_off("paper", ["drawing"], set={FORCE: float(most) - 0.1, **believed})


def test_who_wants_to_flies_it_and_is_warned() -> None:
    with pytest.warns(UserWarning, match=r"7 N is too much: .* can hold about 10\.\d N"):
        assert take_off("paper", ["following"], set={FORCE: 7.0, **FLY})


def test_what_is_not_ruled_out_warns_and_half_of_it_does_not() -> None:
    doubtful = r"2\.5 N is doubtful: with a friction of 0\.8 on a surface that leans by 19\.5 degrees"
    with pytest.warns(UserWarning, match=doubtful):
        take_off("paper", ["following"], set={FORCE: 2.5})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        take_off("paper", ["following"], set={FORCE: 2.0})
        take_off(
            "paper", ["following"], set={FORCE: 5.0, BELIEVED: [0.2, 0.4], "approach.believed_lean": 0.0}
        )


@pytest.mark.parametrize("truth", [(0.0, 0.2), (0.349, 0.8), (-0.349, 0.0)])
def test_the_truth_of_the_surface_decides_nothing(truth: tuple[float, float]) -> None:
    """Nobody has it before a flight: 5 N is doubtful on a flat and smooth board as well."""
    surface = dict(zip(("surface.slope", "surface.friction"), truth, strict=True))
    with pytest.warns(UserWarning, match="a force of 5 N is doubtful"):
        take_off("paper", ["following"], set={FORCE: 5.0, **surface})


@pytest.mark.parametrize(
    ("inertia", "message"),
    [(1e-3, r"zero at \+47\.\d rad/s, for which following's attitude, 11\.3 rad/s fast, is doubtful"),
     (3e-3, r"zero at \+15\.\d rad/s, .* is too fast; .* approach\.doubtful")],
)  # fmt: skip
def test_an_attitude_too_fast_for_its_rotors_is_said(inertia: float, message: str) -> None:
    given = {**HOLD, "plant.rotors": "speed", "plant.rotor_inertia": inertia}
    if "too fast" in message:
        with pytest.raises(ConfigError, match=message):
            take_off("paper", ("following",), set=given)
        given["approach.doubtful"] = "fly"
        message = "is too fast"
    with pytest.warns(UserWarning, match=message):
        take_off("paper", ("following",), set=given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        take_off("paper", ("hybrid", "following"), set={**HOLD, "plant.rotors": "speed"})


def test_a_path_with_a_force_is_held_against_its_greatest():
    pressed = {"trajectory.force": [1.0, 15.0]}
    with pytest.raises(ConfigError, match="a force of 15 N is too much"):
        take_off("paper", ("following",), 0, pressed)
    with pytest.warns(UserWarning, match=r"'hybrid' commands no force.*trajectory.force = \[1.0, 15.0\] N"):
        take_off("paper", ("hybrid",), 0, pressed)
