"""The supervisor: what is believed, which mode follows, what flies, and the limits that come last.

    measurement -> before: gates, prediction, table -> controller -> after: reserve, limits -> command

It may hand the controller another measurement and another reference, and command in its place. Both halves
are pure, on numbers and on symbols: the same lines fly in simulation, on a robot and as exported C.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import Layout
from skylimb.control.estimation.gates import BEYOND, angle_fault, pose_fault, relocked, same_pose
from skylimb.control.estimation.prediction import (
    Prediction,
    differenced,
    initial_prediction,
    moved,
    seen,
    shown,
)
from skylimb.control.estimation.records import BodyState, Imu, Measurement, Wrench, zero_measurement
from skylimb.control.estimation.rotor_loss import NOTHING_LOST, Loss, initial_loss, look
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.records import Command
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.reserve import reserve_thrusts
from skylimb.control.supervisor.retreat import retreat
from skylimb.control.supervisor.table import shipped_table
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, clip, dot, stack, where, within

TABLE = shipped_table()
UNSEEN = 1e6
"""Age of a frame that is not seen, s."""

MOST = 1e12
"""No number that is remembered is larger, but for those of a memory that somebody wrote into."""

LEAST_SHARE = 0.3
"""Of its thrust, that a rotor is believed to have while the controller flies."""

RETREAT, DESCEND, CUT = map(TABLE.mode, ("RETREAT", "DESCEND", "CUT"))


class Told(NamedTuple):
    """What the world around says at a tick; whoever flies writes it into the state.

    Attributes:
        pose: 1 where the pose is newer than the one before, as its stamp says.
        joints: 1 where the joint angles are.
        late: 1 where this tick came too late to ask the controller.
        land: 1 where the flight is to be broken off.
        stop: 1 where the motors are to stop.
    """

    pose: Any = 1.0
    joints: Any = 1.0
    late: Any = 0.0
    land: Any = 0.0
    stop: Any = 0.0


class Clocks(NamedTuple):
    """What time has passed.

    Attributes:
        mode: in this mode, s.
        broken: since the flight was broken off, s.
        unseen: since a pose was believed, s.
        unfelt: since joint angles were believed, s.
        same: since the measured pose changed, s.
        strange: for which poses that jump have agreed with one another, s.
        without: ticks since the controller commanded.
    """

    mode: Any = 0.0
    broken: Any = 0.0
    unseen: Any = 0.0
    unfelt: Any = 0.0
    same: Any = 0.0
    strange: Any = 0.0
    without: Any = 0.0


class Watch(NamedTuple):
    """What the supervisor remembers.

    Attributes:
        told: of the tick to come.
        mode: number of the mode.
        started: 1 once a pose was believed.
        clocks: since when.
        before: measurement of the last tick, as it came.
        prediction: for the next one.
        loss: which rotor has lost thrust.
        command: that was given last.
        asked: last reference of the mission, at which the flight was broken off.
    """

    told: Told
    mode: Any
    started: Any
    clocks: Clocks
    before: Measurement
    prediction: Prediction
    loss: Loss
    command: Command
    asked: Reference


class Sight(NamedTuple):
    """What `before` hands over: to the controller its measurement and reference, to `after` the rest.

    Attributes:
        measurement: that is believed.
        reference: that is to be flown.
        asks: 1 where the controller is asked.
        body: state of {C} by that measurement.
        faults: of pose and of angles, numbers as in `gates.FAULTS`.
        bits: of the table, by its order.
    """

    measurement: Measurement
    reference: Reference
    asks: Any
    body: BodyState
    faults: Array
    bits: Array


def initial_watch(robot: Robot, imu: bool = False) -> Watch:
    """Before the first tick: nothing is known, and the least is commanded.

    Args:
        robot: the model.
        imu: whether the controller works on what an IMU measures; else nobody gets it.
    """
    low, psi = robot.thrust_limits()[0], np.clip(np.zeros(robot.n_vectoring), *robot.vectoring_limits())
    q = np.clip(robot.nominal_posture(), *robot.joint_limits())
    none = zero_measurement(robot.n_joints, robot.n_vectoring, imu)
    asked = zero_reference(robot.n_joints, robot.n_vectoring)
    prediction = initial_prediction(robot, low)
    return Watch(
        Told(),
        0.0,
        0.0,
        Clocks(),
        none,
        prediction,
        initial_loss(robot.n_rotors),
        Command(low, q, psi),
        asked,
    )


def before(
    robot: Robot, limits: Limits, watch: Watch, measured: Measurement, reference: Reference, dt: float
) -> tuple[Watch, Sight]:
    """Look, and decide what the controller is given."""
    # Whatever happened to the memory, the tick begins with numbers.
    first = initial_watch(robot, watch.before.imu is not None)
    memory = Layout(first)
    watch = memory.unpack(_numbers(memory.pack(watch), memory.pack(first), MOST))
    # 1. What is believed: the measurement, or in its place the model's.
    prediction, clocks, told = watch.prediction, watch.clocks, watch.told
    angles = stack(measured.joint_angles, measured.vectoring_angles)
    wrong = angle_fault(limits, angles)
    felt = within(wrong, 0.0, 0.5) * told.joints
    unfelt = where(felt > 0.5, 0.0, clocks.unfelt + dt)
    angles = where(felt > 0.5, angles, prediction.angles)
    prediction, speeds = differenced(prediction, angles, dt)
    q, psi = angles[: robot.n_joints], angles[robot.n_joints :]
    predicted = shown(prediction, robot.at(q, psi), robot.n_joints, speeds)
    fault = pose_fault(limits, measured, predicted, clocks.unseen, watch.started)
    fault, strange = relocked(limits, fault, clocks.strange, measured, watch.before, predicted, dt)
    same = where(same_pose(measured, watch.before) > 0.5, clocks.same + dt, 0.0)
    new = within(fault, 0.0, 0.5) * within(same, 0.0, limits.frozen_after) * told.pose
    unseen = where(new > 0.5, 0.0, clocks.unseen + dt)
    stale = _over(unseen, limits.stale_after)
    # An old pose is good until it is stale, as frames come more slowly than ticks.
    good = within(fault, 0.0, 0.5) * (1.0 - stale)
    started = where(watch.started + new > 0.5, 1.0, 0.0)
    pose = Measurement._fields[:4]
    chosen = {name: where(good > 0.5, getattr(measured, name), getattr(predicted, name)) for name in pose}
    # Where the pose is the model's, no frame is seen: who has an IMU goes on by that.
    age = where(good * within(measured.capture_age, 0.0, UNSEEN) > 0.5, measured.capture_age, UNSEEN)
    imu, speaks = _heard(measured.imu, watch.before.imu)
    measured = measured._replace(imu=imu)
    believed = measured._replace(joint_angles=q, vectoring_angles=psi, capture_age=age, **chosen)
    prediction, body = seen(robot, prediction, believed, speeds, dt)
    loss, lost = watch.loss, NOTHING_LOST
    if limits.losses:
        loss, lost = look(loss, prediction.observer, body, prediction.thrusts, good, dt)
    # 2. Which mode follows. By its IMU a robot finds back and down for a while.
    blind = _over(unseen, limits.retreat_after) * started
    found = {
        # What is no number counts as said.
        "stop": _over(told.stop, 0.5),
        "land": where(speaks * blind + _over(told.land, 0.5) > 0.5, 1.0, 0.0),
        "lost": _over(unseen - speaks * limits.imu_for, limits.cut_after) * started,
        "blind": _over(unseen - speaks * limits.imu_for, limits.retreat_after) * started,
        "stale": stale,
        "dead": _over(lost.lost, limits.dead),
        "lossy": _over(lost.lost, limits.lossy),
        "pushed": lost.pushed,
        "numb": _over(unfelt, limits.retreat_after),
        "silent": _over(clocks.without, float(limits.overruns)),
        "late": where(_over(told.late, 0.5) + _over(clocks.without, 0.0) > 0.5, 1.0, 0.0),
        "spent": _over(clocks.mode, limits.descend_for) * within(watch.mode, DESCEND, DESCEND),
    }
    bits = stack(*(found[name] for name in TABLE.bits))
    mode = TABLE.decided(watch.mode, found)
    was_broken = watch.mode > RETREAT - 0.5
    broken = where(was_broken, clocks.broken + dt, 0.0)
    clocks = Clocks(
        where(mode == watch.mode, clocks.mode + dt, 0.0),
        broken,
        unseen,
        unfelt,
        same,
        strange,
        clocks.without,
    )
    # 3. What is to be flown: the mission, or from where it was broken off the way back.
    layout, aimed = Layout(reference), reference._replace(ahead=())
    aims = within(layout.pack(reference), -BEYOND, BEYOND)
    asked = _chosen(where(was_broken, 1.0, 0.0) + (1.0 - aims) > 0.5, watch.asked, aimed)
    back = retreat(asked, broken, limits.floor)
    back = back._replace(ahead=(back,) * len(reference.ahead))
    broken_off = within(mode, RETREAT - 0.5, CUT)
    flown = _chosen(broken_off > 0.5, back, reference)
    # A flight that was never given a reference has none to be broken off at.
    aims = within(dot(flown.contact_axis, flown.contact_axis), 0.5, 2.0) * where(broken_off > 0.5, 1.0, aims)
    asks = started * within(mode, 0.0, DESCEND - 0.5) * within(told.late, 0.0, 0.5) * aims
    watch = watch._replace(
        mode=mode,
        started=started,
        clocks=clocks,
        before=measured,
        prediction=prediction,
        loss=loss,
        asked=asked,
    )
    return watch, Sight(believed, flown, asks, body, stack(fault, wrong), bits)


def after(
    robot: Robot, limits: Limits, watch: Watch, sight: Sight, wanted: Command, sound: Any, dt: float
) -> tuple[Watch, Command, Any]:
    """Take the controller's command, or another one in its place; within limits in any case.

    Args:
        robot: the model.
        limits: of the supervisor.
        watch: of `before`.
        sight: of `before`.
        wanted: what the controller commands.
        sound: 1 where nothing else that it made is no number.
        dt: control period, s.

    Returns:
        What is remembered, the command, and 1 where it is the controller's.
    """
    bounds = _bounds(robot)
    made = sight.asks * sound * within(stack(*wanted), -BEYOND, BEYOND)
    without = where(made > 0.5, 0.0, watch.clocks.without + 1.0)
    external = watch.prediction.observer
    back = sight.reference.velocity * where(watch.mode > RETREAT - 0.5, 1.0, 0.0)
    reserve = reserve_thrusts(
        sight.body, Wrench(external.force, external.torque), back, watch.loss.left, bounds[0]
    )
    # A command is repeated for moments only: frozen thrusts lose the flight by themselves.
    holds = within(without * dt, 0.0, limits.hold_for) * within(watch.mode, 0.0, DESCEND - 0.5)
    least = within(watch.mode, DESCEND + 0.5, CUT) + (1.0 - watch.started)
    thrusts = where(least > 0.5, bounds[0][0], where(holds > 0.5, watch.command.thrusts, reserve))
    first = Command(thrusts, sight.reference.joint_angles, sight.reference.vectoring_angles)
    instead = _chosen(watch.started > 0.5, watch.command._replace(thrusts=thrusts), first)
    # What the controller believes to be made of its command is made, as far as the rotor can.
    share = clip(watch.loss.left, LEAST_SHARE, 1.0)
    command = _chosen(made > 0.5, wanted._replace(thrusts=wanted.thrusts / share), instead)
    parts = zip(command, watch.command, bounds, strict=True)
    command = Command(*(clip(_numbers(part, last), *bound) for part, last, bound in parts))
    prediction = moved(
        watch.prediction,
        sight.body,
        sight.measurement.quaternion,
        command.thrusts,
        limits.latency,
        limits.rotor_lag,
        dt,
    )
    clocks = watch.clocks._replace(without=without)
    new = watch._replace(told=Told(), clocks=clocks, prediction=prediction, command=command)
    return new, command, made


def _heard(said: Imu | None, last: Imu | None) -> tuple[Imu | None, Any]:
    """What an IMU says, where that is no number, what it said last; and 1 where it says anything new."""
    if said is None or last is None:
        return last, 0.0
    heard = _chosen(within(stack(*said), -BEYOND, BEYOND) > 0.5, said, last)
    return heard, 1.0 - within(stack(*heard) - stack(*last), 0.0, 0.0)


def _bounds(robot: Robot) -> tuple[tuple[Array, Array], ...]:
    """Least and greatest of every part of a command."""
    return robot.thrust_limits(), robot.joint_limits(), robot.vectoring_limits()


def _over(value: Any, limit: float) -> Any:
    """1 where a value is beyond a limit, or no number, else 0; sums of periods may round."""
    return 1.0 - within(value, -BEYOND, limit + 1e-9)


def _numbers(values: Array, instead: Array, most: float = BEYOND) -> Array:
    """The values, and others in the place of those that are no numbers or absurd ones."""
    return where(abs(values) < most, values, instead)


def _chosen(first: Any, one: Any, other: Any) -> Any:
    """One record or another, entry by entry."""
    layout = Layout(one)
    return layout.unpack(where(first, layout.pack(one), layout.pack(other)))
