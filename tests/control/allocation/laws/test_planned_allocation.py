"""Vectoring angles planned in flight, as a law: no table, any posture."""

from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.control.allocation.laws import bounded, planned
from skylimb.control.laws.preset import PRESETS
from skylimb.control.planning import vectoring_files
from skylimb.control.planning.vectoring_step import RATE, STEP, first_vectoring, plan_vectoring


@pytest.fixture(scope="module")
def preset(tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("preset") / "pid_planned.toml"
    text = (PRESETS / "pid.toml").read_text()
    path.write_text(text.replace('law = "pseudoinverse"', 'law = "planned"'))
    return str(path)


@pytest.fixture(scope="module")
def flight(preset):
    """Through the large deformations of `free_flight`, and no table of vectoring angles is looked up."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(vectoring_files, "find_coefficients", lambda *given, **more: pytest.fail("a table"))
        return skylimb.run("free_flight", controller=preset)


def test_a_robot_without_a_table_flies_through_its_postures(flight):
    assert flight.status == "OK"
    log = flight.log
    away = np.linalg.norm(log["cog_position"].values - log["cog_position_reference"].values, axis=1)
    assert away.max() < 0.05
    # What is left is told with every plan.
    assert float(flight.log["vectoring_margin"].min()) > 1.0


def test_the_angles_are_those_of_a_rehearsal_on_the_ground(flight):
    """They follow the commanded joint angles alone."""
    robot = skylimb.load_robot("hydrus_xi_quad")
    q = flight.log["joint_angles_command"].values
    command = flight.log["vectoring_angles_command"].values
    every = round(200.0 / RATE)
    psi = first_vectoring(robot).angles
    for k in range(0, len(q) - every, every):
        psi = plan_vectoring(robot, q[k], psi).angles
        assert np.allclose(command[k + every - 1], psi, atol=1e-6)


def test_a_command_never_jumps(flight):
    command = flight.log["vectoring_angles_command"].values
    speed = np.abs(np.diff(command, axis=0)).max() * 200.0
    assert speed <= STEP * RATE + 1e-6
    assert speed > 0.1


def test_thrusts_are_those_of_bounded(flight):
    gains, given = planned.Gains(), bounded.Gains()
    assert gains.weights == given.weights
    assert "allocation_residual_force" in flight.log


def test_a_control_rate_below_that_of_the_plans_is_refused():
    planned.require(planned.Gains(), 1.0 / RATE)
    with pytest.raises(ConfigError, match=r"law 'planned' plans .* 10 Hz is too low"):
        planned.require(planned.Gains(), 0.1)


def test_the_files_of_a_run_bring_no_table(preset, tmp_path):
    """A robot of one's own, whose table would be among them."""
    from skylimb.flight.run_files import _robot_files

    folder = Path(tmp_path) / "mine"
    folder.mkdir()
    shipped = skylimb.load_robot("hydrus_xi_quad").description.folder
    for path in shipped.glob("*.*"):
        if path.is_file():
            (folder / path.name).write_bytes(path.read_bytes())
    robot = skylimb.load_robot(str(folder))
    names = {source.path.name for source in _robot_files(robot, "online")}
    assert "vectoring.toml" not in names
    assert "flight.toml" in names
