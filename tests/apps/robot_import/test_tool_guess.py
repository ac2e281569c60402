"""Which way a tool is taken to point, and the heading with it, from files of many kinds."""

import re
from pathlib import Path

import numpy as np
import pytest

import skylimb
from armed_robots import multirotor_with_arm
from skylimb.apps.robot_import.checking import check_robot_file

RIGID = {
    "ahead": ("0.6 0 -0.05", (1.0, 0.0, 0.0), "tool"),
    "to the left": ("0 0.6 0", (0.0, 1.0, 0.0), "tool"),
    "to the back": ("-0.6 0 0", (-1.0, 0.0, 0.0), "tool"),
    "between": ("0.45 0.4 0", (0.747409, 0.664364, 0.0), "tool"),
    "down": ("0 0 -0.4", (0.0, 0.0, -1.0), "root"),
    "up": ("0 0 0.6", (0.0, 0.0, 1.0), "root"),
}


def with_stick(path: Path, end: str) -> Path:
    text = multirotor_with_arm(path, joints=()).read_text()
    path.write_text(re.sub(r'(<child link="tool0"/><origin xyz=")[^"]*', rf"\g<1>{end}", text))
    return path


@pytest.mark.parametrize("way", RIGID)
def test_a_stick_on_the_body_points_away_from_it(tmp_path: Path, way: str) -> None:
    end, out, heading = RIGID[way]
    report = check_robot_file(with_stick(tmp_path / "made.urdf", end))
    tip = report.description.tip
    np.testing.assert_allclose(tip.R[:, 0], out, atol=1e-5)
    assert tip.heading == heading
    assert report.can_touch, report.reasons
    assert report.actuation is not None
    assert bool(report.actuation.ahead) == (heading == "tool")


@pytest.mark.usefixtures("no_picture")
@pytest.mark.parametrize("way", ["to the left", "to the back"])
def test_a_stick_to_any_side_draws_on_a_board(tmp_path: Path, way: str) -> None:
    """The robot turns that side to the board; it was refused for having no wall ahead."""
    path = with_stick(tmp_path / "made.urdf", RIGID[way][0])
    skylimb.import_robot(path, tmp_path / "robot")
    keys = {"robot": str(tmp_path / "robot"), "controller.translation.force": 0.5}
    run = skylimb.run("board_tilted_hexarotor", "following", set=keys)
    assert run.metrics["done"], run.metrics["missed"]
    assert run.metrics["pen_line_rms"] < 0.008


@pytest.mark.parametrize(
    ("tool", "forward"), [("0 0 0", None), ("0 1.5708 0", "z"), ("0 1.4 0.1", "z"), ("2.0 0 0", None)]
)
def test_the_axis_of_a_frame_that_points_out_is_found(tmp_path: Path, tool: str, forward: str | None) -> None:
    report = check_robot_file(multirotor_with_arm(tmp_path / "made.urdf", tool=tool))
    assert report.flight is not None
    assert report.flight.tip.forward == forward
    assert report.flight.tip.rpy is None
    assert report.description.tip.heading == "root"


def test_a_tip_that_a_mapping_says_gets_its_heading_too(tmp_path: Path) -> None:
    path = multirotor_with_arm(tmp_path / "made.urdf", tool="0 1.5708 0")
    mapping = tmp_path / "mapping.toml"
    mapping.write_text('[tip]\nlink = "tool0"\nposition = [0.0, 0.0, 0.1]\nradius = 0.01\n')
    report = check_robot_file(path, mapping=mapping)
    assert report.description.tip.heading == "root"
    np.testing.assert_allclose(report.description.tip.R[:, 0], [0.0, 0.0, 1.0], atol=1e-12)
    assert report.actuation is not None
    assert report.actuation.ahead


def test_what_is_said_of_a_tool_is_kept(tmp_path: Path) -> None:
    path = multirotor_with_arm(tmp_path / "made.urdf")
    mapping = tmp_path / "mapping.toml"
    said = (
        '[tip]\nlink = "tool0"\nposition = [0.0, 0.0, 0.1]\nradius = 0.01\nforward = "z"\nheading = "tool"\n'
    )
    mapping.write_text(said)
    report = check_robot_file(path, mapping=mapping)
    assert report.flight is not None
    assert (report.flight.tip.forward, report.flight.tip.heading) == ("z", "tool")
