"""What is believed of a measurement: numbers, near to what the model says, and of a robot's size.

Every gate is a comparison that has to hold, so what is no number passes none.
"""

from __future__ import annotations

from typing import Annotated, Any

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.estimation.records import Measurement
from skylimb.control.estimation.twist_check import TwistGates
from skylimb.symbolic import Array, abs, dot, stack, where, within

BEYOND = 1e9
"""No SI number that a robot measures is as large."""

FAULTS = ("", "not finite", "no attitude", "too fast", "jump", "angle out of range")
"""What is wrong with a measurement, by number."""

JUMP = 4.0


@configuration
class Gates(TwistGates):
    """Sizes beyond which a measurement is not believed."""

    speed: Annotated[float, Key("m/s", "speed above which none is believed", above=0.0, high=1e3)] = 10.0
    turning: Annotated[float, Key("rad/s", "the same of the rates", above=0.0, high=1e3)] = 20.0
    angles: Annotated[
        float,
        Key(
            "rad",
            "way from the last to a measured joint or vectoring angle that is none",
            above=0.0,
            high=1e3,
        ),
    ] = 7.0
    bend: Annotated[
        float,
        Key("rad", "the same of a joint of the shape, farther where none came for long", above=0.0, high=1e3),
    ] = 0.3
    bending: Annotated[
        float, Key("rad/s", "how fast such a joint may move while none comes", low=0.0, high=1e3)
    ] = 2.0
    jump: Annotated[
        float, Key("m", "way from the predicted to a measured position that is none", above=0.0, high=1e3)
    ] = 0.05
    jump_turn: Annotated[float, Key("rad", "the same of the attitude", above=0.0, high=10.0)] = 0.2
    relock_after: Annotated[
        float,
        Key(
            "s",
            "of poses that agree, after which a jump is believed that does not tilt the robot",
            low=0.0,
            high=60.0,
        ),
    ] = 0.2
    relock_within: Annotated[
        float, Key("m", "greatest jump that is believed, of a prediction of now", low=0.0, high=1e3)
    ] = 0.5
    drift: Annotated[
        float, Key("m/s", "how fast a prediction grows uncertain without measurements", low=0.0, high=1e3)
    ] = 0.3
    drift_turn: Annotated[float, Key("rad/s", "the same of the attitude", low=0.0, high=1e3)] = 0.5


def pose_fault(gates: Any, seen: Measurement, predicted: Measurement, unseen: Any, started: Any) -> Any:
    """Number of what is wrong with a measured pose and twist; 0 for nothing.

    Args:
        gates: a `Gates`.
        seen: the measurement.
        predicted: what the model says that it should be.
        unseen: time since a pose came, s: for so long may the prediction have gone astray.
        started: 1 once there is a prediction, else 0.
    """
    size, along = dot(seen.quaternion, seen.quaternion), dot(seen.quaternion, predicted.quaternion)
    way = seen.position - predicted.position
    far = gates.jump + gates.drift * unseen
    # 1 - cos(angle / 2) of the rotation between the two, which needs no arc cosine.
    turned = (gates.jump_turn + gates.drift_turn * unseen) ** 2 / 8.0
    near = within(dot(way, way), 0.0, far * far) * within(along * along, (1.0 - turned) ** 2 * size, BEYOND)
    fault = where(near + (1.0 - started) > 0.5, 0.0, JUMP)
    slow = within(seen.velocity, -gates.speed, gates.speed)
    slow = slow * within(seen.angular_velocity, -gates.turning, gates.turning)
    fault = where(slow > 0.5, fault, 3.0)
    fault = where(within(size, 0.81, 1.21) > 0.5, fault, 2.0)
    flat = stack(seen.position, seen.quaternion, seen.velocity, seen.angular_velocity)
    return where(within(flat, -BEYOND, BEYOND) > 0.5, fault, 1.0)


def relocked(
    gates: Any,
    fault: Any,
    strange: Any,
    seen: Measurement,
    before: Measurement,
    predicted: Measurement,
    unseen: Any,
    dt: float,
) -> tuple[Any, Any]:
    """A fault that is none any more, as a row of poses agrees: the world moved, not the sensor.

    Args:
        gates: a `Gates`.
        fault: of this pose.
        strange: time for which poses that jump have agreed, s.
        seen: the measurement.
        before: of the last tick.
        predicted: what the model says.
        unseen: time since a pose was believed, s: for so long may the prediction have gone astray.
        dt: control period, s.

    Returns:
        The fault, and that time.
    """
    way = seen.position - predicted.position
    agrees = within(pose_fault(gates, seen, before, 0.0, 1.0), 0.0, 0.5) * within(fault, JUMP, JUMP)
    near = within(dot(way, way), 0.0, (gates.relock_within + gates.drift * unseen) ** 2)
    # A capture that is set up anew may turn the heading. What is upright it does not change.
    turned = gates.jump_turn + gates.drift_turn * (unseen - strange)
    axes = (rotation_from_quaternion(each.quaternion)[:, 2] for each in (seen, predicted))
    near = near * within(dot(*axes), 1.0 - 0.5 * turned**2, BEYOND)
    strange = where(agrees > 0.5, strange + dt, 0.0)
    return where(near * over(strange, gates.relock_after) > 0.5, 0.0, fault), strange


def angle_fault(gates: Any, ways: Array, shape: int = 0, missing: Any = 0.0, known: Any = 0.0) -> Any:
    """The same of joint and vectoring angles.

    The size of a vectoring angle says nothing: its servo may turn round and round. A joint of the shape moves
    as fast as its servo turns it, or as it falls: from one tick to the next that is little.

    Args:
        gates: a `Gates`.
        ways: of all angles from those that were believed last, rad; joints of the shape come first.
        shape: how many those are; none of a robot that is bent by hand.
        missing: time for which no angles came, s.
        known: 1 once angles were believed.
    """
    fault = where(within(ways, -gates.angles, gates.angles) > 0.5, 0.0, 5.0)
    if shape:
        far = where(known > 0.5, gates.bend + gates.bending * missing, gates.angles)
        fault = where(within(ways[:shape], -far, far) > 0.5, fault, 5.0)
    return where(within(ways, -BEYOND, BEYOND) > 0.5, fault, 1.0)


def over(value: Any, limit: float) -> Any:
    """1 where a value is beyond a limit, or no number, else 0; sums of periods may round."""
    return 1.0 - within(value, -BEYOND, limit + 1e-9)


def numbers(values: Array, instead: Array, most: float = BEYOND) -> Array:
    """The values, and others in the place of those that are no numbers or absurd ones."""
    return where(abs(values) < most, values, instead)


def same_pose(first: Measurement, second: Measurement) -> Any:
    """1 where not a bit of position and attitude differs, as of sensors that have stopped."""
    return within(stack(first.position - second.position, first.quaternion - second.quaternion), 0.0, 0.0)
