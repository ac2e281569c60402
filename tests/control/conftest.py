"""What a law is given in a test: any part of it by name, the rest at rest."""

import subprocess
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import skylimb
from law_records import IN_THE_AIR
from skylimb.control.cascade import Cascade
from skylimb.control.estimation.records import BodyState, Estimate, Measurement, Start, Wrench
from skylimb.control.missions.reference import zero_reference
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.records import ArmTarget, LawInput
from skylimb.flight.export import export_c
from skylimb.robots.description import GRAVITY
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState
from strict_c import StrictC

G = np.array([0.0, 0.0, GRAVITY])

DT = 0.005
NOBODY: Any = None


@pytest.fixture(scope="session")
def robot() -> Robot:
    return skylimb.load_robot("hydrus_xi_quad")


@pytest.fixture(scope="session")
def joint_angles() -> np.ndarray:
    return np.array([np.pi / 3, np.pi / 3, -np.pi / 6])


@pytest.fixture(scope="session")
def vectoring_angles(robot: Robot) -> np.ndarray:
    return np.asarray(vectoring_table(robot).angles(np.pi / 6))


@pytest.fixture(scope="session")
def model(robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray) -> RobotState:
    return robot.at(joint_angles, vectoring_angles)


def _start(reach: float = 1.09, robot: Any = None, hover_thrusts: Any = None) -> Start:
    return Start(robot, reach, np.zeros(4) if hover_thrusts is None else hover_thrusts)


def _inputs(model: Any = None, **given: Any) -> LawInput:
    """Whatever is not given is zero, level, or the world's axes."""
    z3 = np.zeros(3)
    lever = given.get("R", np.eye(3)).T @ given.get("arm", np.array([1.0, 0, 0]))
    model = SimpleNamespace(mass=4.0, gravity=G, tip_C=lever) if model is None else model
    body = BodyState(
        given.get("position", z3),
        given.get("velocity", z3),
        given.get("R", np.eye(3)),
        given.get("omega", z3),
        model,
    )
    wrench = Wrench(given.get("force", z3), given.get("torque", z3))
    bias = Wrench(given.get("bias_force", z3), given.get("bias_torque", z3))
    estimate = Estimate(
        body, wrench, wrench, given.get("contact_force", 0.0), given.get("arm", np.array([1.0, 0, 0])), bias
    )
    asked = {
        "contact_axis": np.eye(3)[0],
        "sliding_axis": np.eye(3)[1],
        "reach": 1.09,
        "align": 1.0,
        "adapt": 1.0,
    }
    reference = zero_reference(3, 4)._replace(**{**asked, **given.get("reference", {})})
    z4 = np.zeros(4)
    measurement = Measurement(z3, z4, z3, z3, given.get("q", z3), given.get("psi", z4))
    return LawInput(
        given.get("robot", NOBODY),
        measurement,
        reference,
        given.get("dt", DT),
        estimate,
        given.get("contact", IN_THE_AIR),
        given.get("commanded_arm", ArmTarget(1.09, 0.0)),
        force=given.get("wanted", 1.0),
    )


@pytest.fixture(scope="session")
def make_inputs() -> Callable[..., LawInput]:
    return _inputs


@pytest.fixture(scope="session")
def make_start() -> Callable[..., Start]:
    return _start


@pytest.fixture
def run_as_c(tmp_path: Path, strict_c: StrictC) -> Callable[[Any], None]:
    """Writes a controller as C, compiles the example that comes with it and runs it on its test vector."""

    def run(controller: Any) -> None:
        assert isinstance(controller, Cascade)
        files = export_c(controller, tmp_path / "export")
        sources = [path for path in files if path.suffix == ".c" and path.name != "host.c"]
        strict_c.link(sources, tmp_path / "example")
        done = subprocess.run([tmp_path / "example"], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout

    return run
