"""The lab's messages out of a tick, flown now or recorded: each from what the tick holds, or none.

Frames and units are those of the lab's own messages: quaternions x y z w; linear velocity of an odometry in
the world, angular velocity in the body; a wrench with its force in the world and its torque about the centre
of gravity. A message that nobody here reads is made as fields by their path.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.analysis.exchange.lab_ticks import UNKNOWN, Frame, TickView
from skylimb.analysis.exchange.messages import WORLD, FourAxes, Imu, Joints, Pose, Quaternion, Vector
from skylimb.base.rotations import (
    quaternion_from_rotation,
    rot_z,
    rotation_from_quaternion,
    rotation_from_rpy,
    rpy_from_rotation,
    wrapped,
)
from skylimb.base.signal_table import PLACE_TERMS, TURN_TERMS

Fields = dict[str, Any]
"""Fields of a message by their path."""


def _of_body(make: Callable[[TickView, Body], Any]) -> Callable[[TickView], Any]:
    """A message that is made of the body; none where that is not known."""

    @functools.wraps(make)
    def made(tick: TickView) -> Any:
        return None if tick.body is None else make(tick, tick.body)

    return made


@_of_body
def mocap(tick: TickView, body: Body) -> Pose:
    """Pose of the lab's link."""
    return Pose(tick.stamp, vector(body.link), _quaternion(body.R_W_link))


@_of_body
def imu(tick: TickView, body: Body) -> Imu:
    """Attitude of the lab's link, and what its IMU says; without one the rates that the body has."""
    w, x, y, z = _quaternion(body.R_W_link if tick.attitude is None else tick.attitude)
    gyro, force = tick.felt or (body.rates_link, UNKNOWN)
    return Imu(tick.stamp, vector(gyro), vector(force), (x, y, z, w), tick.magnetic_field)


def joint_states(tick: TickView) -> Joints | None:
    """Joints and gimbals as measured."""
    names = (*tick.names.joints, *tick.names.gimbals)
    return None if tick.angles is None else Joints(tick.stamp, names, floats(tick.angles))


def joints_ctrl(tick: TickView) -> Joints | None:
    """Joints as commanded."""
    command = tick.command
    return None if command is None else Joints(tick.stamp, tick.names.joints, floats(command[1]))


def gimbals_ctrl(tick: TickView) -> Joints | None:
    """Gimbals as commanded."""
    command = tick.command
    return None if command is None else Joints(tick.stamp, tick.names.gimbals, floats(command[2]))


def four_axes(tick: TickView) -> FourAxes | None:
    """Thrusts as commanded; attitude targets are left to whoever made the thrusts."""
    if tick.command is None or not tick.motors:
        return None
    return FourAxes((0.0, 0.0, 0.0), floats(tick.command[0]))


@_of_body
def cog_odometry(tick: TickView, body: Body) -> Fields:
    """Centre of gravity, with the lab's axes: level like C, with the yaw of its link."""
    position, velocity, R_WC, rates = tick.cog or body[:4]
    turn = np.asarray(rot_z(body.yaw_in_C))
    return _odometry(tick, "cog", position, R_WC @ turn, velocity, turn.T @ rates)


@_of_body
def baselink_odometry(tick: TickView, body: Body) -> Fields:
    """The lab's link."""
    return _odometry(tick, "fc", body.link, body.R_W_link, body.link_velocity, body.rates_link)


@_of_body
def full_state(tick: TickView, body: Body) -> Fields:
    """Place and speed along each axis of centre of gravity and lab's link; the truth is not known."""
    position, velocity = (tick.cog or body)[:2]
    rows = (("cog", position, velocity), ("b", body.link, body.link_velocity))
    states = [
        {"id": f"{axis}_{name}", "state": [(float(place[i]), float(speed[i]), 0.0)] * 2 + [(0.0, 0.0, 0.0)]}
        for name, place, speed in rows
        for i, axis in enumerate("xyz")
    ]
    return {**header(tick), "states": states}


@_of_body
def transforms(tick: TickView, body: Body) -> Fields:
    """The robot's root in the world; in it the centre of gravity and the lab's link; links that move."""
    names, root = tick.names, tick.names.frame("root")
    place, R = body.root, body.R_W_root
    moving, known = list[Frame](), frozenset[str]()
    if tick.angles is not None:
        _, (place, R), moving = names.placed(tick.angles, (place, R))
        known = names.children
    R_cog = R.T @ body.R_WC @ np.asarray(rot_z(body.yaw_in_C))
    frames = [(WORLD, root, place, R), (root, names.frame("cog"), R.T @ (body.cog - place), R_cog)]
    if names.frame("fc") not in known:  # a frame has one parent
        frames.append((root, names.frame("fc"), R.T @ (body.link - place), R.T @ body.R_W_link))
    return {"transforms": [transform(tick, *one) for one in (*frames, *moving)]}


def mounts(tick: TickView) -> Fields | None:
    """What does not move in its parent."""
    if tick.angles is None:
        return None
    return {"transforms": [transform(tick, *one) for one in tick.names.fixed(tick.angles)]}


@_of_body
def pose_errors(tick: TickView, body: Body) -> Fields | None:
    """Targets, errors and terms of position and attitude; of position the wanted acceleration in all, too.

    The yaw is that of the lab's link. Terms are what a law says that it adds up, empty where it says none.
    """
    if tick.target is None:
        return None
    place, speed, yaw = tick.target
    found = header(tick)
    for i, axis in enumerate("xyz"):
        found[f"{axis}.target_p"], found[f"{axis}.err_p"] = float(place[i]), float(place[i] - body.cog[i])
        found[f"{axis}.target_d"], found[f"{axis}.err_d"] = (
            float(speed[i]),
            float(speed[i] - body.velocity[i]),
        )
        if "force_command" in tick.signals:
            found[f"{axis}.total"] = (float(tick.signals["force_command"][i]) / tick.names.mass,)
        found |= _terms(tick, PLACE_TERMS, axis, i, np.eye(3))
    # Roll and pitch are those of the lab's axes: level like C, with the yaw of its link.
    turn, wanted = np.asarray(rot_z(body.yaw_in_C)), tick.signals.get("attitude_target", np.zeros(3))
    aimed = floats(rpy_from_rotation(np.asarray(rotation_from_rpy(*floats(wanted))) @ turn))
    tilted, rates = floats(rpy_from_rotation(body.R_WC @ turn)), floats(turn.T @ body.rates_cog)
    for i, axis in enumerate(("roll", "pitch")):
        found[f"{axis}.target_p"], found[f"{axis}.err_p"] = aimed[i], aimed[i] - tilted[i]
        found[f"{axis}.err_d"] = -rates[i]
    for i, axis in enumerate(("roll", "pitch", "yaw")):
        found |= _terms(tick, TURN_TERMS, axis, i, turn.T)
        if f"{axis}.p_term" in found:
            found[f"{axis}.total"] = (sum(found[f"{axis}.{term}_term"][0] for term in "pid"),)
    off = float(wrapped(yaw - body.yaw))
    return {**found, "yaw.target_p": yaw, "yaw.err_p": off, "yaw.err_d": -rates[2]}


def _terms(tick: TickView, names: tuple[str, ...], axis: str, i: int, R: np.ndarray) -> Fields:
    """One row of what a law adds up, seen in the axes of `R`."""
    if names[0] not in tick.signals:
        return {}
    values = (float(R[i] @ np.asarray(tick.signals[name])) for name in names)
    return {f"{axis}.{term}_term": (value,) for term, value in zip("pid", values, strict=True)}


def wrench(force: str, torque: str) -> Callable[[TickView], Fields | None]:
    """The wrench of two signals."""

    def make(tick: TickView) -> Fields | None:
        if force not in tick.signals:
            return None
        parts = {"wrench.force": vector(tick.signals[force]), "wrench.torque": vector(tick.signals[torque])}
        return {**header(tick), **parts}

    return make


def cog_reference(tick: TickView) -> Fields | None:
    """Where the mission wants the centre of gravity."""
    return {**header(tick), "point": vector(tick.signals["cog_position_reference"])}


def header(tick: TickView, frame: str = WORLD) -> Fields:
    """Fields of a header."""
    return {"header.stamp": tick.stamp, "header.frame_id": frame}


def transform(tick: TickView, parent: str, child: str, position: np.ndarray, R: np.ndarray) -> Fields:
    """Fields of a transform: place and axes of a child frame in its parent."""
    return {
        **header(tick, parent),
        "child_frame_id": child,
        "transform.translation": vector(position),
        "transform.rotation": _quaternion(R),
    }


def in_its_axes(make: Callable[[TickView], Any]) -> Callable[[TickView], Any]:
    """An odometry whose linear velocity is in the axes of its child frame, not in those of the world."""

    def made(tick: TickView) -> Any:
        found = make(tick)
        if found is None:
            return None
        R = np.asarray(rotation_from_quaternion(np.array(found["pose.pose.orientation"])))
        return {**found, "twist.twist.linear": vector(R.T @ found["twist.twist.linear"])}

    return made


def _odometry(
    tick: TickView, frame: str, position: np.ndarray, R: np.ndarray, velocity: np.ndarray, rates: np.ndarray
) -> Fields:
    return {
        **header(tick),
        "child_frame_id": tick.names.frame(frame),
        "pose.pose.position": vector(position),
        "pose.pose.orientation": _quaternion(R),
        "twist.twist.linear": vector(velocity),
        "twist.twist.angular": vector(rates),
    }


def vector(values: Any) -> Vector:
    """Three numbers."""
    x, y, z = floats(values)
    return x, y, z


def floats(values: Any) -> tuple[float, ...]:
    """Numbers of any shape, in a row."""
    return tuple(np.asarray(values, dtype=float).ravel().tolist())


def _quaternion(R: np.ndarray) -> Quaternion:
    w, x, y, z = quaternion_from_rotation(R).tolist()
    return w, x, y, z
