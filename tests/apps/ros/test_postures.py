"""Ten postures over the lab's topics: our controller, the board's inner loop, sensors and servos between."""

from __future__ import annotations

import numpy as np
import pytest

from skylimb.analysis.exchange.messages import Joints, Pose
from skylimb.apps.ros.messages import Arrived
from skylimb.base.rotations import quaternion_from_rotation, rot_z, wrapped
from skylimb.control.planning.posture import posture_family
from wired import in_hover

FAR, TURN = 0.09, np.deg2rad(3.0)
"""Off the place, m an axis, and off the yaw, once it stands in a posture: what the lab's own stack keeps."""

SAG = 0.06
"""That servos hang by under the rotors, rad."""


@pytest.mark.slow
def test_ten_postures_in_hover() -> None:
    wire = in_hover()
    robot = wire.pilot.pilot.flyer.robot
    family, names = posture_family(robot), robot.description.shape_joints
    tick = wire.pilot.last
    assert tick is not None
    assert tick.body is not None
    place, yaw = tick.body.cog - [0.4, 0.0, 0.0], tick.body.yaw  # the arm reaches the board from here
    x, y, z = place.tolist()
    w, *turn = quaternion_from_rotation(np.asarray(rot_z(yaw))).tolist()
    wire.ask(Arrived("target_pose", Pose(0.0, (x, y, z), (w, *turn)), "/client", 0.0))
    wire.fly(6.0)
    for theta in np.linspace(family.theta_max, family.theta_min, 10):
        angles = np.asarray(family.joint_angles(theta), dtype=float)
        wire.ask(Arrived("joints_ctrl", Joints(0.0, names, tuple(angles.tolist())), "/client", 0.0))
        wire.fly(4.0)
        for _ in range(200):
            wire.tick()
            tick = wire.pilot.last
            assert tick is not None
            assert tick.body is not None
            assert np.abs(tick.body.cog - place).max() < FAR, f"{theta:.2f}: {tick.body.cog - place}"
            assert abs(float(wrapped(tick.body.yaw - yaw))) < TURN
        np.testing.assert_allclose(wire.robot.plant.truth().joint_angles, angles, atol=SAG)
    assert "refused" not in " ".join(wire.said)
