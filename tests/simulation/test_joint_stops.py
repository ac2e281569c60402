"""Joint stops: their keys, and that a run says which joint leans on one."""

import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.simulation.joint_stops import leaning

BENT = {"posture.waypoints": [[1.0, 1.57, -0.5]], "posture.hold": 0.5, "posture.speed": 0.5}


def test_shares_of_leaning() -> None:
    angles = np.array([[0.0, 1.0], [0.5, 1.0], [1.2, 0.0], [-1.0, 0.0]])
    found = leaning(angles, np.array([-1.0, -2.0]), np.array([1.0, 2.0]), ("first", "second"))
    assert found == {"first": 0.5}
    assert leaning(np.zeros((0, 2)), np.zeros(2), np.ones(2), ("first", "second")) == {}


def test_a_run_says_that_a_joint_leans() -> None:
    run = skylimb.run("free_flight", "pid", set=BENT)
    assert len(run.notes) == 1
    assert run.notes[0].startswith("joint2 leaned on the stop at its limit for ")


def test_a_stiff_stop_keeps_a_joint_at_its_limit() -> None:
    soft, stiff = (
        skylimb.run("free_flight", "pid", set={**BENT, "plant.joint_stop_stiffness": stiffness})
        .log.joint_angles.sel(joint="joint2")
        .values.max()
        for stiffness in (50.0, 1500.0)
    )
    assert stiff - 1.57 < 0.1 * (soft - 1.57)


def test_the_flight_that_ships_leans_on_none() -> None:
    assert skylimb.run("free_flight", "pid").notes == ()


def test_what_the_time_step_cannot_carry_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"plant\.joint_stop_stiffness = 500000 is too much .* 'joint1'"):
        skylimb.run("free_flight", "pid", set={"plant.joint_stop_stiffness": 5e5})
    given = {"plant.joint_stop_stiffness": 500.0, "plant.joint_stop_damping": 1e3}
    with pytest.raises(ConfigError, match=r"plant\.joint_stop_damping = 1000 is too much"):
        skylimb.run("free_flight", "pid", set=given)
