"""A replay shows a surface that was moved in flight where it was, and the lines on it."""

import mujoco
import numpy as np
import pytest
import xarray as xr

import skylimb
from skylimb.analysis.viewer.moved import is_moved, moves_of, taken_back, where
from skylimb.analysis.viewer.payload import viewer_payload
from unpacking import unpacked

CHANGES = [
    {"kind": "surface", "time": 1.0, "position": [1.55, 0.02, 1.2], "slope": -0.2, "pitch": 0.1},
    {"kind": "surface", "time": 2.0, "present": False},
]


@pytest.fixture(scope="module")
def run():
    set = {"events": CHANGES, "phases.hover": 0.4, "phases.tare": 0.3, "trajectory.period": 1.0}
    return skylimb.run("paper", "pid", set={**set, "trajectory.radius": 0.02})


def point_on(pose, local):
    turned = np.zeros(3)
    mujoco.mju_rotVecQuat(turned, np.asarray(local, dtype=float), pose[3:])
    return pose[:3] + turned


def test_the_board_is_shown_where_it_was(run):
    (flight,) = viewer_payload({"pid": run})["flights"]
    model = mujoco.MjModel.from_xml_string(run.log.attrs["scene"])
    assert flight["bodies"] == model.nbody + 1
    board = [shape for shape in flight["shapes"] if shape["body"] == model.nbody]
    assert [shape["kind"] for shape in board] == ["box"]
    assert board[0]["position"] == pytest.approx([0.01, 0.0, 0.0], abs=1e-5)
    assert board[0]["quaternion"] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-5)
    moments = unpacked(flight["moments"])[:, 0]
    poses = unpacked(flight["poses"]).reshape(len(moments), -1, 7)[:, -1]
    assert poses[moments < 0.99] == pytest.approx(np.tile(poses[0], ((moments < 0.99).sum(), 1)), abs=1e-3)
    moved = poses[(moments > 1.25) & (moments < 1.99)]
    assert moved[:, :3] == pytest.approx(np.tile([1.55, 0.02, 1.2], (len(moved), 1)), abs=0.05)
    assert (poses[moments > 2.01][:, 2] < -900.0).all()


def test_a_line_on_a_moved_board_keeps_its_place_on_it(run):
    poses, moves = where(run.log), moves_of(run.log)
    local = [0.0, 0.1, -0.2]
    for tick in (0, 210, 230, 300):
        there = point_on(poses[tick], local)
        (back,) = taken_back(np.array([[there, there]]), moves[tick : tick + 1])
        assert back[0] == pytest.approx(point_on(poses[0], local), abs=1e-9)
    assert moves[0] == pytest.approx([0, 0, 0, 1, 0, 0, 0])


def test_a_log_without_changes_is_shown_as_it_was(run):
    without = run.log.drop_vars(["surface_position", "surface_quaternion", "surface_present"])
    assert not is_moved(without)
    assert is_moved(run.log)
    assert not is_moved(xr.Dataset())
