"""Rotors that joints turn, as fixed ones: the same wrench, and thrust and angles that come back."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skylimb
from made_robots import chain
from skylimb.base.errors import DescriptionError
from skylimb.robots.loader import load_robot, read_description
from skylimb.robots.model import Robot
from skylimb.robots.turned_rotors import SIDE, turned_rotors

ROLL, PITCH = "1 0 0", "0 1 0"
MADE = {
    "three, a joint each": {"links": 3, "turns": (ROLL,)},
    "three, a gimbal each": {"links": 3, "turns": (ROLL, PITCH)},
    "two, a gimbal each": {"links": 2, "turns": (ROLL, PITCH)},
}


@pytest.fixture(scope="module", params=MADE)
def few(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    description = read_description(chain(tmp_path_factory.mktemp("few"), **MADE[request.param]))
    # Links that turn weigh nothing, so that the centre of gravity stays where it is.
    light = [
        replace(link, inertial=replace(link.inertial, mass=1e-9)) if link.name.startswith("turn") else link
        for link in description.links
    ]
    # And the axes of a gimbal meet.
    joints = [
        replace(one, xyz=np.zeros(3)) if one.name.endswith("_1") and one.name.startswith("gimbal") else one
        for one in description.joints
    ]
    start = np.linspace(-0.2, 0.3, len(description.vectoring_joints))
    return Robot(replace(description, links=tuple(light), joints=tuple(joints), vectoring_start=start))


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_pairs_give_the_wrench_of_thrusts_and_angles(few: Robot, seed: int) -> None:
    rng = np.random.default_rng(seed)
    turned = few.turned
    assert turned is not None
    q, thrusts = rng.uniform(-1.5, 1.5, few.n_joints), rng.uniform(0.5, 20.0, few.n_rotors)
    psi = turned.start + rng.uniform(-1.2, 1.2, few.n_vectoring)
    pairs = turned.pairs(thrusts, psi)
    wrench = few.pairs.wrench_function(q, np.zeros(0)).full() @ pairs
    np.testing.assert_allclose(wrench, few.wrench_function(q, psi).full() @ thrusts, atol=1e-6)
    back, angles = turned.command(pairs)
    np.testing.assert_allclose(back, thrusts, rtol=1e-12)
    np.testing.assert_allclose(angles, psi, atol=1e-12)


def test_the_robot_of_pairs_weighs_the_same_and_keeps_its_limits(few: Robot) -> None:
    pairs = few.pairs
    assert pairs.mass == pytest.approx(few.mass)
    assert pairs.n_rotors == few.n_rotors + few.n_vectoring
    assert pairs.n_vectoring == 0
    assert pairs.pairs is pairs
    least, most = pairs.thrust_limits()
    sides = slice(few.n_rotors, None)
    np.testing.assert_allclose(most[sides], SIDE * 30.0)
    np.testing.assert_allclose(least[sides], -most[sides])
    # Whatever is given to the sides, no rotor gives more than it can.
    assert few.turned is not None
    thrusts, _ = few.turned.command(most)
    np.testing.assert_allclose(thrusts, 30.0)


def test_it_hovers_with_the_thrusts_and_angles_of_its_pairs(few: Robot) -> None:
    assert few.turned is not None
    q = few.nominal_posture()
    of_pairs = few.pairs.at(q, np.zeros(0))
    thrusts, psi = few.turned.command(of_pairs.hover_thrusts)
    state = few.at(q, psi)
    np.testing.assert_allclose(state.hover_thrusts, thrusts, rtol=1e-9)
    np.testing.assert_allclose(state.R_root_C, of_pairs.R_root_C, atol=1e-12)
    wrench = state.allocation_C @ state.hover_thrusts
    np.testing.assert_allclose(wrench, [0.0, 0.0, few.weight, 0.0, 0.0, 0.0], atol=2e-3)


def test_beyond_a_joints_limit_the_thrust_is_what_lies_along_the_rotor(tmp_path: Path) -> None:
    robot = Robot(read_description(chain(tmp_path, links=3, turns=(ROLL,), turn_limit=0.3)))
    assert robot.turned is not None
    pairs = np.array([10.0, 10.0, 10.0, 10.0, 0.0, -1.0])
    thrusts, psi = robot.turned.command(pairs)
    np.testing.assert_allclose(psi, [0.3, 0.0, -math.atan(0.1)])
    along = np.array([math.cos(0.3), math.sin(0.3)])
    np.testing.assert_allclose(thrusts, [10.0 * float(along.sum()), 10.0, math.hypot(10.0, 1.0)])
    # Joints that turn by less than SIDE give less to the side.
    assert robot.pairs.thrust_limits()[1][3] == pytest.approx(30.0 * math.sin(0.3))


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ({"links": 4, "turns": (ROLL,)}, ""),
        ({"links": 3, "turns": ("0.6 0 0.8",)}, "joints that turn one rotor each, across its thrust"),
        ({"links": 3, "turns": ("0 0 1",)}, "do not give|give .*torque|cannot hover"),
    ],
)
def test_other_robots_are_no_robots_of_pairs(tmp_path: Path, kind: dict[str, object], said: str) -> None:
    path = chain(tmp_path, **kind)  # pyright: ignore[reportArgumentType]
    assert turned_rotors(read_description(path)) is None
    if said:
        with pytest.raises(DescriptionError, match=said):
            load_robot(path)
    else:
        robot = load_robot(path)
        assert robot.pairs is robot


@pytest.mark.parametrize("name", skylimb.list_robots())
def test_robots_that_ship_fly_as_they_are(name: str) -> None:
    robot = load_robot(name)
    assert robot.turned is None
    assert robot.pairs is robot
