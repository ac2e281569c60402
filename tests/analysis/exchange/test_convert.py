"""Logs in other formats: whole there and back, and a real robot's topics as a log."""

from __future__ import annotations

import dataclasses
import json
import shutil
import subprocess
import sys
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.containers import container_of
from skylimb.analysis.exchange.convert import convert, read_log, salvage, write_log
from skylimb.analysis.exchange.frames import lab_link
from skylimb.analysis.exchange.from_run import messages_of
from skylimb.analysis.exchange.lab_ticks import lab_name
from skylimb.analysis.exchange.lab_topics import ROW
from skylimb.analysis.exchange.layouts import first_second, foxglove_layout, plots, write_layouts
from skylimb.analysis.exchange.message_types import DEFINITIONS, IMU, message_types
from skylimb.analysis.exchange.run_topics import record_messages, row_table, run_of
from skylimb.analysis.exchange.stream import Message, Raw, decoded, encoder
from skylimb.analysis.exchange.to_run import Read, angles_in_order, run_from
from skylimb.analysis.recording import Run, write_sources
from skylimb.analysis.report.controller_replay import differences
from skylimb.analysis.scores.metrics import metrics
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError, OutputError, UnknownNameError

ROBOT = skylimb.load_robot("hydrus_xi_quad")


@pytest.fixture(scope="module")
def messages(flown: skylimb.Run) -> list[Message]:
    return list(messages_of(flown, ROBOT, message_types(), lab_link(ROBOT)))


def from_the_lab(messages: Iterable[Message]) -> Read:
    """What somebody reads who knows only the lab's topics."""
    known = (message for message in messages if not message.topic.startswith("/skylimb/"))
    return run_from(known, lambda: ROBOT, "real", lab_link)


def same(one: Run, other: Run) -> bool:
    assert list(one.log.data_vars) == list(other.log.data_vars)
    assert set(one.log.variables) == set(other.log.variables)
    for name in one.log.variables:
        was, now = one.log[name], other.log[name]
        assert was.dims == now.dims
        assert was.attrs.keys() == now.attrs.keys(), name
        if was.dtype.kind in "US":
            assert list(was.values) == list(now.values)
        else:
            assert (was.dtype, was.values.tobytes()) == (now.dtype, now.values.tobytes()), name
    assert {**one.log.attrs, "format_version": 1} == {**other.log.attrs, "format_version": 1}
    assert dict(one.metrics) == dict(other.metrics)
    assert dict(one.sources) == dict(other.sources)
    return (one.name, one.controller) == (other.name, other.controller)


@pytest.mark.parametrize("ending", [".bag", ".mcap"])
def test_a_run_comes_back_to_the_bit(flown: skylimb.Run, tmp_path: Path, ending: str) -> None:
    assert flown.sources
    notes = write_log(flown, tmp_path / f"a{ending}")
    assert notes == ("poses on the lab's topics are those of flight_controller",)
    read = read_log(tmp_path / f"a{ending}")
    assert read.notes == ()
    assert same(flown, read.run)
    if ending == ".mcap":  # which `test_the_commands` replays
        return
    # And through two other formats.
    convert(tmp_path / f"a{ending}", tmp_path / "b.nc")
    convert(tmp_path / "b.nc", tmp_path / "c.mcap")
    back = read_log(tmp_path / "c.mcap").run
    for name in flown.log.variables:
        assert flown.log[name].values.tobytes() == back.log[name].values.tobytes(), name
    replayed = skylimb.replay(tmp_path / f"a{ending}")
    assert all(one.same for one in differences(flown, replayed))
    assert replayed.notes == ()


def test_a_file_of_ros_2_is_read_by_its_own_bag_reader(flown: skylimb.Run, tmp_path: Path) -> None:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    path = tmp_path / "flight.mcap"
    write_log(flown, path, ros2=True)
    assert same(flown, read_log(path).run)
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        kinds = {one.topic: one.msgtype for one in reader.connections}
        states = [one for one in reader.connections if one.topic == "/hydrus_xi/joint_states"]
        _, _, data = next(iter(reader.messages(states)))
        message: Any = reader.deserialize(data, "sensor_msgs/msg/JointState")
        assert message.name[-1] == "gimbal_joint4"
    wanted = {"/tf": "tf2_msgs/msg/TFMessage", "/tf_static": "tf2_msgs/msg/TFMessage"}
    wanted["/hydrus_xi/rotor_thrusts"] = "skylimb_msgs/msg/RotorThrusts"
    wanted["/hydrus_xi/robot_description"] = "std_msgs/msg/String"
    assert wanted.items() <= kinds.items()
    with pytest.raises(ConfigError, match=r"messages of ROS 2 are written as \.mcap"):
        write_log(flown, tmp_path / "flight.bag", ros2=True)
    with pytest.raises(ConfigError, match="a bag holds messages of ROS 1 alone"):
        salvage(path, tmp_path / "other.bag")


def test_rows_are_written_as_they_come(flown: skylimb.Run, tmp_path: Path) -> None:
    """A container takes one message after another, and none is kept: what it holds last is written."""
    alive: list[int] = []

    def stream() -> Iterator[Message]:
        for index, message in enumerate(messages_of(flown, ROBOT, message_types(), "link1")):
            alive.append(index)
            yield message

    container_of("a.bag").write(tmp_path / "a.bag", map(encoder(), stream()))
    with container_of("a.bag").read(tmp_path / "a.bag") as read:
        assert next(read).topic == "/skylimb/record"
        assert 1 + sum(1 for _ in read) == len(alive)


def test_the_labs_topics_have_its_frames_and_units(flown: skylimb.Run, messages: list[Message]) -> None:
    by: dict[str, list[Message]] = {}
    for message in messages:
        by.setdefault(message.topic, []).append(message)
    log, ticks = flown.log, flown.log.sizes["time"]
    assert len(by["/skylimb/row"]) == len(by["/hydrus_xi/four_axes/command"]) == ticks
    assert len(by["/hydrus_xi/mocap/pose"]) == -(-ticks // 2)  # new frames at 100 Hz
    assert len(by["/hydrus_xi/joint_states"]) == -(-ticks // 4)
    first = by["/hydrus_xi/imu"][0].value
    # The flight controller sits on link 2, which joint 1 turns: same z axis, other x and y.
    pose = by["/hydrus_xi/mocap/pose"][0].value
    assert pose.header.frame_id == "world"
    q = log.joint_angles_measured.values[0]
    link2 = log.root_quaternion_measured.values[0]
    yaw = 2.0 * np.arctan2(link2[3], link2[0]) + q[0]
    turned = 2.0 * np.arctan2(pose.pose.orientation.z, pose.pose.orientation.w)
    assert np.sin(yaw - turned) == pytest.approx(0.0, abs=2e-2)
    np.testing.assert_allclose(
        first.quaternion, [getattr(pose.pose.orientation, axis) for axis in "xyzw"], atol=1e-6
    )
    assert first.gyro[2] == pytest.approx(log.root_angular_velocity_measured.values[0, 2], rel=1e-5)
    assert np.isnan(first.acc).all()
    wrench = by["/hydrus_xi/estimated_external_wrench"][-1].value
    k = round((wrench.header.stamp.sec - 1 + wrench.header.stamp.nanosec * 1e-9) / 0.005)
    assert wrench.wrench.force.x == log.external_force_estimate.values[k, 0]
    command = by["/hydrus_xi/four_axes/command"][7].value
    np.testing.assert_array_equal(command.base_thrust, log.thrusts_command.values[7].astype(np.float32))
    assert by["/hydrus_xi/gimbals_ctrl"][0].value.name == ["gimbal1", "gimbal2", "gimbal3", "gimbal4"]


def test_the_cog_odometry_has_the_yaw_of_the_labs_link(flown: skylimb.Run, messages: list[Message]) -> None:
    by: dict[str, list[Message]] = {}
    for message in messages:
        by.setdefault(message.topic.removeprefix("/hydrus_xi/"), []).append(message)

    def heading(turn: Any) -> float:
        return float(np.arctan2(2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y**2 + turn.z**2)))

    odometry = by["uav/cog/odom"][0].value
    assert odometry.child_frame_id == "hydrus_xi/cog"
    link = heading(by["mocap/pose"][0].value.pose.orientation)
    assert heading(odometry.pose.pose.orientation) == pytest.approx(link, abs=0.01)
    # Joint 1 turns the flight controller's link in C: its yaw is another than C's.
    assert abs(flown.log.attitude_estimate.values[0, 2] - link) > 0.3
    # Read again it is C's attitude, and its rates are those of C's axes.
    log = from_the_lab(messages).run.log
    count = min(log.sizes["time"], flown.log.sizes["time"])
    fresh = slice(0, count, 4)  # where odometry and joints are of the same tick
    for name in ("attitude_estimate", "angular_velocity_estimate"):
        np.testing.assert_allclose(log[name][fresh], flown.log[name][fresh], atol=1e-9, err_msg=name)


def test_the_labs_own_messages_have_the_labs_digests() -> None:
    types = message_types()
    digests = {kind: types.generate_msgdef(kind, ros_version=1)[1][:8] for kind in DEFINITIONS}
    assert list(digests.values()) == ["ae078a6c", "058c4b50"]


def test_a_bag_of_the_lab_becomes_a_log(flown: skylimb.Run, messages: list[Message]) -> None:
    read = from_the_lab(messages)
    log, was = read.run.log, flown.log
    assert log.sizes["time"] >= was.sizes["time"] - 1
    count = min(log.sizes["time"], was.sizes["time"])
    np.testing.assert_allclose(log.time.values[:count], was.time.values[:count], atol=1e-9)
    np.testing.assert_array_equal(log.joint_angles_command[:count], was.joint_angles_command[:count])
    np.testing.assert_allclose(log.thrusts_command[:count], was.thrusts_command[:count], atol=1e-5)
    # The pose goes by the flight controller's place, over joints that are 20 ms old at most.
    np.testing.assert_allclose(
        log.root_position_measured[:count], was.root_position_measured[:count], atol=5e-3
    )
    fresh = slice(0, count, 4)
    np.testing.assert_allclose(
        log.root_position_measured[fresh], was.root_position_measured[fresh], atol=1e-9
    )
    said = "\n".join(read.notes)
    for words in (
        "topics without a place in a log: /hydrus_xi/skylimb/cog_reference",
        "joint_angles_measured at 50 Hz: at each tick the last one",
        "thrusts_command is base_thrust: what a flight controller adds on board is in no topic",
    ):
        assert words in said
    replayed = skylimb.replay(read.run, "hybrid")
    assert np.isfinite(replayed.log.external_force_estimate).all()


def test_an_imu_goes_into_a_bag_and_comes_back(flown: skylimb.Run) -> None:
    """The board's rates and specific force, in 32 bits; without an IMU its rates alone."""
    count = flown.log.sizes["time"]
    rng, dims = np.random.default_rng(2), flown.log.root_velocity_measured.dims
    said = {name: rng.normal(size=(count, 3)) for name in ("angular_velocity", "specific_force")}
    felt = {f"imu_{name}_measured": (dims, values) for name, values in said.items()}
    run = dataclasses.replace(flown, log=flown.log.assign(felt))
    log = from_the_lab(messages_of(run, ROBOT, message_types(), lab_link(ROBOT))).run.log
    for name, (_, values) in felt.items():
        np.testing.assert_allclose(log[name].values[: count - 1], values[: count - 1], atol=1e-5)
    blind = from_the_lab(messages_of(flown, ROBOT, message_types(), lab_link(ROBOT))).run.log
    assert np.isnan(blind.imu_specific_force_measured).all()
    other = run_from(
        (m for m in messages_of(run, ROBOT, message_types(), "link3") if not m.topic.startswith("/skylimb/")),
        lambda: ROBOT, "real", lambda _: "link3",
    )  # fmt: skip
    assert any("imu: it sits on link3" in note for note in other.notes)


def test_clocks_that_differ_are_brought_together(messages: list[Message]) -> None:
    """The recorder's clock is 1000 s late, and its messages come with a delay."""
    rng = np.random.default_rng(1)

    def late(message: Message) -> Message:
        return message._replace(time=message.time + 1000 * 10**9 + int(rng.uniform(0, 4e6)))

    read = from_the_lab(sorted(map(late, messages), key=lambda message: message.time))
    assert "pose: stamps are -1000.002 s off the recorder's clock; that is taken off" in read.notes
    usual = from_the_lab(messages).run.log
    count = min(usual.sizes["time"], read.run.log.sizes["time"]) - 2
    np.testing.assert_allclose(
        read.run.log.joint_angles_measured[:count], usual.joint_angles_measured[:count], atol=2e-2
    )


@pytest.mark.parametrize(
    ("topic", "spoil", "words"),
    [
        ("mocap/pose", None, "has no topic .../mocap/pose"),
        ("joint_states", None, "the pose of flight_controller is taken"),
        ("four_axes/command", lambda value: dataclasses.replace(value, base_thrust=np.ones(3, np.float32)),
         "thrusts_command: 3 values, hydrus_xi_quad has 4; left out"),
    ],
)  # fmt: skip
def test_a_topic_that_is_missing_or_odd_is_told(
    messages: list[Message], topic: str, spoil: Any, words: str
) -> None:
    odd = [
        message._replace(value=spoil(message.value)) if spoil and message.topic.endswith(topic) else message
        for message in messages
        if spoil or not message.topic.endswith((topic, "joints_ctrl"))
    ]
    try:
        said = "\n".join(from_the_lab(odd).notes)
    except OutputError as error:
        said = str(error)
    assert words in said


@pytest.mark.parametrize("name", ["dragon", "hydrus_xi_quad"])
def test_angles_are_found_by_their_names_whatever_the_order(name: str) -> None:
    robot = skylimb.load_robot(name)
    names = [*robot.description.shape_joints, *robot.description.vectoring_joints]
    angles = dict(zip(names, 0.01 * np.arange(1.0, len(names) + 1), strict=True))
    shuffled = sorted(names, reverse=True)
    one = (0.0, 0.0, {lab_name(each): angles[each] for each in shuffled})
    said: list[str] = []
    found = angles_in_order({"measured": [one]}, robot, said)
    assert found["joint_angles_measured"][0][2].tolist() == [
        angles[n] for n in robot.description.shape_joints
    ]
    assert found["vectoring_angles_measured"][0][2].tolist() == [
        angles[n] for n in robot.description.vectoring_joints
    ]
    assert not said
    assert not angles_in_order({"measured": [(0.0, 0.0, {"wheel": 0.1})]}, robot, said)
    assert said[0].startswith(f"angles measured: of wheel; {name} has joint1")


def test_poses_that_are_no_numbers_are_none(messages: list[Message]) -> None:
    spoiled, messages = 0, list(messages)
    for index, message in enumerate(messages):
        if message.topic.endswith("mocap/pose") and 10 <= spoiled < 14:
            turn = message.value.pose.orientation
            odd = dataclasses.replace(turn, w=0.0, x=0.0, y=0.0, z=0.0)
            pose = dataclasses.replace(message.value.pose, orientation=odd)
            messages[index] = message._replace(value=dataclasses.replace(message.value, pose=pose))
        spoiled += message.topic.endswith("mocap/pose")
    run = from_the_lab(messages).run
    assert np.isnan(run.log.root_quaternion_measured.values[20:28]).all()
    assert "root_quaternion_measured: 8 of" in " ".join(skylimb.replay(run, "hybrid").notes)


def test_rows_that_are_not_those_of_the_record_are_refused(flown: skylimb.Run) -> None:
    table = row_table(flown.log)
    record = dataclasses.replace(flown, log=flown.log.isel(time=slice(0, 1))).content()
    assert same(dataclasses.replace(flown, sources={}), run_of(record, table, {}, "x"))
    for wrong in (table[:, :-1], np.hstack([table, table[:, :1]])):
        with pytest.raises(OutputError, match="'x': a row has"):
            run_of(record, wrong, {}, "x")


def test_files_that_are_none_of_these_are_refused(flown: skylimb.Run, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"'.bagg' is not one of .nc, .bag, .mcap; did you mean '.bag'"):
        write_log(flown, tmp_path / "a.bagg")
    with pytest.raises(UnknownNameError, match="did you mean 'link1'"):
        write_log(flown, tmp_path / "a.bag", link="link_1")
    with pytest.raises(OutputError, match=r"none.bag' does not exist"):
        read_log(tmp_path / "none.bag")
    write_log(flown, tmp_path / "a.bag")
    write_log(flown, tmp_path / "a.mcap")
    with pytest.raises(OutputError, match="exists already"):
        write_log(flown, tmp_path / "a.bag")
    for name, kind in (("a.bag", "ROS 1 bag"), ("a.mcap", "MCAP file")):
        whole = (tmp_path / name).read_bytes()
        for cut in (0, 10, len(whole) // 8):
            broken = tmp_path / f"{cut}-{name}"
            broken.write_bytes(whole[:cut])
            with pytest.raises(OutputError, match=f"is not a readable {kind}|no message of"):
                read_log(broken)
    assert not (tmp_path / "a.bagg").exists()


@pytest.mark.parametrize("ending", [".bag", ".mcap"])
def test_what_was_cut_off_is_read_up_to_its_last_whole_chunk(
    messages: list[Message], tmp_path: Path, ending: str
) -> None:
    path = tmp_path / f"a{ending}"
    many = [message._replace(time=message.time + k * 10**10) for k in range(4) for message in messages]
    container_of(path).write(path, map(encoder(), many))
    whole = path.read_bytes()
    path.write_bytes(whole[: int(0.8 * len(whole))])
    with container_of(path).read(path) as read, pytest.warns(UserWarning, match=r"was cut off: what was rec"):
        found = list(decoded(read))
    assert len(messages) < len(found) < len(many)
    for one, other in zip(found, many, strict=False):
        assert (one.topic, one.type, one.time) == (other.topic, other.type, other.time)
        if one.topic == ROW.name:
            assert one.value.data.tobytes() == other.value.data.tobytes()
    damaged = bytearray(whole)
    damaged[len(whole) // 3] ^= 16
    path.write_bytes(damaged)
    with pytest.raises(OutputError, match="is not a readable"), container_of(path).read(path) as read:
        list(read)


@pytest.mark.parametrize("lost", ["end", "middle"])
def test_a_run_that_lacks_ticks_is_not_judged(flown: skylimb.Run, tmp_path: Path, lost: str) -> None:
    ticks = flown.log.sizes["time"]
    keep = range(ticks // 2) if lost == "end" else [*range(ticks // 3), *range(ticks // 2, ticks)]
    flown = dataclasses.replace(flown, metrics={"status": "OK", "done": True})
    every = list(messages_of(flown, ROBOT, message_types(), lab_link(ROBOT)))
    rows = [message for message in every if message.topic == ROW.name]
    gone = {id(message) for k, message in enumerate(rows) if k not in keep}
    path = tmp_path / "a.mcap"
    container_of(path).write(path, map(encoder(), (message for message in every if id(message) not in gone)))
    run = read_log(path).run
    assert run.log.sizes["time"] == len(keep)
    assert (run.status, run.done, dict(run.metrics)) == ("STOPPED", None, {})
    assert run.cause == f"lacks ticks, as its log was cut off or has gaps: {len(keep)} of {ticks} are there"
    scores = metrics(run.log)
    assert scores["status"] == "STOPPED"
    assert scores["done"] is None
    # It stays so through another file.
    write_log(run, tmp_path / "b.mcap")
    assert same(run, read_log(tmp_path / "b.mcap").run)


def test_a_lost_flight_that_lacks_ticks_stays_lost(flown: skylimb.Run) -> None:
    lost = flown.log.assign_attrs(status="FAILED", cause="it fell")
    (_, fields), *_ = record_messages(dataclasses.replace(flown, log=lost))
    run = run_of(fields["data"], row_table(flown.log)[:50], {}, "x")
    assert (run.status, run.cause) == ("FAILED", "it fell")


ROS_PYTHON = "/usr/bin/python3"
READ = "import sys, rosbag; print(sum(1 for _ in rosbag.Bag(sys.argv[1]).read_messages()))"


def test_ros_itself_reads_every_message_of_a_bag(messages: list[Message], tmp_path: Path) -> None:
    here = Path(ROS_PYTHON).is_file() and shutil.which("rosbag")
    if not here:
        pytest.skip("no rosbag here: apt-get install python3-rosbag")
    path = tmp_path / "log.bag"
    container_of(path).write(path, map(encoder(), messages))
    read = subprocess.run([ROS_PYTHON, "-c", READ, path], capture_output=True, text=True, check=False, env={})
    assert read.stdout.strip() == str(len(messages)), read.stderr


def juggled(topic: str, value: Any) -> dict[str, float]:
    """The series that PlotJuggler's ROS parser makes of a message, by its published source.

    Fields by slashes, entries of a list as [i] (rosx_introspection, FieldsVector::toStr), and of a joint
    state TOPIC/JOINT/position (ParserROS::parseJointStateMsg).
    """
    if type(value).__name__.endswith("JointState"):
        angles = zip(value.name, value.position, strict=True)
        return {f"{topic}/{name}/position": float(angle) for name, angle in angles}
    found: dict[str, float] = {}

    def walk(name: str, part: Any) -> None:
        if isinstance(part, int | float | np.number):
            found[name] = float(part)
        elif isinstance(part, list | np.ndarray):
            for i, entry in enumerate(part):
                walk(f"{name}[{i}]", entry)
        elif dataclasses.is_dataclass(part):
            for field in dataclasses.fields(part):
                if not field.name.startswith("__"):
                    walk(f"{name}/{field.name}", getattr(part, field.name))

    walk(topic, value)
    return found


@pytest.mark.parametrize("ending", [".bag", ".mcap"])
def test_layouts_plot_what_is_in_the_file(flown: skylimb.Run, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a{ending}"
    write_log(flown, path, namespace="mine")
    layouts = [file.read_text(encoding="utf-8") for file in write_layouts(path, "mine")]
    with container_of(path).read(path) as read:
        values = {
            message.topic: message.value for message in decoded(read) if message.topic.startswith("/mine/")
        }
    series = {name: x for topic, value in values.items() for name, x in juggled(topic, value).items()}
    root = ElementTree.fromstring(layouts[1])
    curves = [curve.attrib["name"] for curve in root.iter("curve")]
    assert len(curves) == 6 + 6 + 6 + 3 + 4 + 7
    for name in curves:
        assert np.isfinite(series[name]), name
    assert "/mine/joint_states/gimbal1/position" in curves
    assert "/mine/four_axes/command/base_thrust[3]" in curves
    # What PlotJuggler's loader follows: root, tabbed_widget, Tab, Container, DockSplitter, DockArea, plot.
    assert root.find("tabbed_widget[@name='Main Window'][@parent='main_window']/currentTabIndex") is not None
    for splitter in root.iter("DockSplitter"):
        assert splitter.attrib["orientation"] in "|-"
        assert int(splitter.attrib["count"]) == len(splitter) == splitter.attrib["sizes"].count(";") + 1
        assert {child.tag for child in splitter} <= {"DockSplitter", "DockArea"}
    assert all(area.find("plot[@mode='TimeSeries']") is not None for area in root.iter("DockArea"))

    layout = json.loads(layouts[0])
    for panel in layout["configById"].values():
        assert panel.keys() == {"foxglovePanelTitle", "paths", "xAxisVal", "showLegend", "isSynced"}
        for drawn in panel["paths"]:
            assert drawn.keys() == {"value", "enabled", "timestampMethod", "color"}
            topic = max((name for name in values if drawn["value"].startswith(f"{name}.")), key=len)
            value: Any = values[topic]
            fields = drawn["value"].removeprefix(f"{topic}.").replace("[", ".").replace("]", "")
            for part in fields.split("."):
                value = value[int(part)] if part.isdigit() else getattr(value, part)
            assert np.isfinite(value)

    def leaves(node: Any) -> list[str]:
        if isinstance(node, str):
            return [node]
        assert node.keys() == {"direction", "first", "second", "splitPercentage"}
        return [*leaves(node["first"]), *leaves(node["second"])]

    assert leaves(layout["layout"]) == list(layout["configById"])


def test_layouts_leave_out_what_a_log_lacks(messages: list[Message]) -> None:
    real = [one for one in messages if "/skylimb/" not in one.topic and "wrench" not in one.topic]
    chosen = plots(first_second(real))
    assert [len(curves) for curves in chosen.values()] == [3, 3, 4, 7]
    assert json.loads(foxglove_layout(dict(list(chosen.items())[:3])))["layout"]["second"] == "Plot!skylimb2"
    with pytest.raises(ConfigError, match=r"--layouts is for .bag and .mcap"):
        write_layouts("a.nc")


def test_the_commands(flown: skylimb.Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flown.save(tmp_path / "log.nc")
    convert(tmp_path, tmp_path / "bare.bag")
    assert main(["replay", str(tmp_path / "bare.bag"), "--out", str(tmp_path / "no")]) == 2
    assert "comes without files that it was flown with: sources/preview-" in capsys.readouterr().err
    write_sources(flown.sources, tmp_path)
    assert main(["convert", str(tmp_path), str(tmp_path / "a.mcap"), "--layouts"]) == 0
    said = capsys.readouterr().out
    assert "note: poses on the lab's topics are those of flight_controller" in said
    assert (tmp_path / "a.foxglove.json").is_file()
    assert (tmp_path / "a.plotjuggler.xml").is_file()
    assert main(["replay", str(tmp_path / "a.mcap"), "--out", str(tmp_path / "again")]) == 0
    assert "the recorded ones to the bit" in capsys.readouterr().out


def test_without_the_extra_a_line_says_what_to_install(
    flown: skylimb.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    flown.save(tmp_path / "a.nc")
    for package, target in (("rosbags", "a.bag"), ("mcap", "a.mcap")):
        with monkeypatch.context() as without:
            for name in [name for name in sys.modules if name.partition(".")[0] == package]:
                without.delitem(sys.modules, name)
            without.setitem(sys.modules, package, None)
            assert main(["convert", str(tmp_path / "a.nc"), str(tmp_path / target)]) == 2
        assert f"'{package}' is not installed: pip install 'skylimb[logs]'" in capsys.readouterr().err
        assert not (tmp_path / target).exists()


def test_a_message_that_changed_is_read_by_the_definition_in_the_file(tmp_path: Path) -> None:
    """The lab's imu of 2024 had other fields: a file brings its own definition."""
    from mcap.writer import Writer

    text = "time stamp\nfloat32[3] acc_data\nfloat32[3] gyro\n"
    types = message_types({IMU: text})
    value = types.types[IMU](
        stamp=types.types["builtin_interfaces/msg/Time"](sec=3, nanosec=0),
        acc_data=np.zeros(3, np.float32),
        gyro=np.array([1.0, 2.0, 3.0], np.float32),
    )
    with (tmp_path / "old.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros1", library="test")
        schema = writer.register_schema("spinal/Imu", "ros1msg", text.encode())
        channel = writer.register_channel("/x/imu", "ros1", schema)
        writer.add_message(channel, 5, bytes(types.serialize_ros1(value, IMU)), 5)
        writer.finish()
    with container_of("a.mcap").read(tmp_path / "old.mcap") as read:
        (message,) = decoded(read)
    assert (message.topic, message.type, message.time) == ("/x/imu", IMU, 5)
    assert list(message.value.gyro) == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(("ending", "target"), [(".bag", ".bag"), (".mcap", ".mcap"), (".mcap", ".bag")])
def test_what_is_salvaged_is_whole_again_to_the_byte(
    messages: list[Message], tmp_path: Path, ending: str, target: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path, anew = tmp_path / f"cut{ending}", tmp_path / f"whole{target}"
    many = [message._replace(time=message.time + k * 10**10) for k in range(4) for message in messages]
    # Somebody else's topic, of another definition than ours.
    text = "time stamp\nfloat32[3] acc_data\n"
    foreign = Raw("/lab/odd", IMU, text, 7, bytes(20))
    container_of(path).write(path, (foreign, *map(encoder(), many)))
    content = path.read_bytes()
    path.write_bytes(content[: int(0.8 * len(content))])
    assert main(["salvage", str(path), str(anew)]) in (None, 0)
    said = capsys.readouterr()
    assert "was cut off: what was recorded up to" in said.err
    with pytest.warns(UserWarning, match="was cut off"), container_of(path).read(path) as read:
        left = list(read)
    with warnings.catch_warnings(), container_of(anew).read(anew) as read:
        warnings.simplefilter("error")
        found = list(read)
    assert len(found) == len(left) > len(messages)
    assert said.out.startswith(f"{len(left)} messages")
    same = ("topic", "type", "time", "content")
    for one, other in zip(found, left, strict=True):
        assert [getattr(one, name) for name in same] == [getattr(other, name) for name in same]
    (odd,) = decoded(found[:1])
    assert (odd.topic, odd.value.acc_data.tolist()) == ("/lab/odd", [0.0, 0.0, 0.0])
    assert main(["salvage", str(path), str(anew)]) == 2  # it is there
