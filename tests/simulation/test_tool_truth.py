"""The truth of a tool at the tip, against where the engine has its shapes."""

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from skylimb.flight.takeoff import take_off
from skylimb.simulation.robot_bodies import TIP_GEOM
from skylimb.simulation.tool import PEG_GEOM
from skylimb.simulation.tool_truth import tool_signals


def posed(plant, count=4):
    """Some poses of the whole robot, and data of the engine at each."""
    rng, rows, found = np.random.default_rng(3), [], []
    for _ in range(count):
        data = mujoco.MjData(plant.model)
        data.qpos[:3] = rng.normal(size=3)
        data.qpos[3:7] = rng.normal(size=4)
        data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
        data.qpos[7:] = rng.uniform(-1.0, 1.0, plant.model.nq - 7)
        mujoco.mj_forward(plant.model, data)
        rows.append(data.qpos.copy())
        found.append(data)
    flight: Any = SimpleNamespace(signal=lambda _: np.array(rows))
    return flight, found


def test_a_foots_angle_is_that_of_its_corners_plane_and_the_surface():
    (takeoff,) = take_off("face_to_face", ("task_frame",), 0, {})
    plant = takeoff.plant
    flight, poses = posed(plant)
    tips = np.array([data.geom(TIP_GEOM).xpos for data in poses])
    found = tool_signals(plant, flight, tips)
    assert set(found) == {"foot_angle"}
    for data, angle in zip(poses, found["foot_angle"], strict=True):
        a, b, c = (data.geom(f"{TIP_GEOM}_{i}").xpos for i in range(3))
        across = np.cross(b - a, c - a)
        cosine = abs(np.dot(across, plant.surface.R_WS[:, 0])) / np.linalg.norm(across)
        assert abs(np.cos(angle)) == pytest.approx(cosine, abs=1e-9)


def test_a_pegs_depth_is_that_of_the_deepest_point_of_its_round_end():
    (takeoff,) = take_off("peg", ("task_frame",), 0, {})
    plant = takeoff.plant
    flight, poses = posed(plant)
    radius, half, _ = plant.model.geom(PEG_GEOM).size
    body = plant.model.geom(PEG_GEOM).bodyid[0]
    ends, tips = [], []
    for data in poses:
        capsule = data.geom(PEG_GEOM)
        along = capsule.xmat.reshape(3, 3)[:, 2]
        along = along * np.sign(along @ (capsule.xpos - data.xpos[body]))  # away from the link
        ends.append(capsule.xpos + half * along)
        tips.append(ends[-1] - (plant.robot.description.tip.radius - radius) * along)
    depth = tool_signals(plant, flight, np.array(tips))["peg_depth"]
    deepest = (np.array(ends) - plant.surface.position) @ plant.surface.R_WS[:, 0] + radius
    np.testing.assert_allclose(depth, deepest, atol=1e-9)
