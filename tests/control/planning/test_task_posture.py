"""A posture is judged in the frame of the surface that it presses on."""

import numpy as np
import pytest

from skylimb.base.rotations import rot_z
from skylimb.control.planning.task import Task, TaskPosture, judged_posture
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.robots.model import Robot

PUSH, NORMAL = np.array([-1.0, 0.4, 0.1]), np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize("heading", [0.5, -0.5])
def test_who_turns_with_the_surface_is_judged_the_same(robot: Robot, heading: float) -> None:
    posture = nominal_posture(robot)
    turn = rot_z(heading)
    here = judged_posture(robot, Task(PUSH[None], NORMAL[None]), *posture)
    there = judged_posture(robot, Task((turn @ PUSH)[None], (turn @ NORMAL)[None]), *posture, heading)
    beside = judged_posture(robot, Task(PUSH[None], NORMAL[None]), *posture, heading)
    assert isinstance(here, TaskPosture)
    assert isinstance(there, TaskPosture)
    assert isinstance(beside, TaskPosture)
    np.testing.assert_allclose(there.thrusts, here.thrusts, atol=1e-4)
    np.testing.assert_allclose(there.margins, here.margins, atol=1e-4)
    assert abs(beside.thrusts - here.thrusts).max() > 1e-2
