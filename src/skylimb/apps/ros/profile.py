"""What a node can be, and the topics of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.lab_ticks import Names
from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.exchange.messages import MotorInfo, UavInfo
from skylimb.analysis.recording.run import Run
from skylimb.robots.model import Robot

PROFILES = ("simulator", "controller", "both")


class PendingRun(NamedTuple):
    """A flight or mission to keep: its name, and what makes its run, which takes too long for a tick."""

    name: str
    run: Callable[[], Run]


class ProfileTopics(NamedTuple):
    """Topics that a profile subscribes to, and those that it publishes."""

    subscribed: tuple[Topic, ...]
    published: tuple[Topic, ...]

    @property
    def commands(self) -> tuple[Topic, ...]:
        """Those on which nobody else may publish: what moves a robot, but for what its user asks for."""
        own = (topic for topic in self.published if topic in topics.ACTUATORS)
        return tuple(topic for topic in own if topic not in topics.USER)

    @property
    def sensors(self) -> tuple[Topic, ...]:
        """Those on which a robot speaks: this one, or else the one that is commanded."""
        said = self.published if topics.MOCAP in self.published else self.subscribed
        return tuple(topic for topic in said if topic in topics.SENSORS)


def profile_topics(profile: str, servos: bool = False) -> ProfileTopics:
    """The topics of a profile.

    Args:
        profile: one of `PROFILES`.
        servos: whether it speaks with the servos in their own counts. Then nobody need translate for
            `controller`, and for `simulator` the lab's `servo_bridge` does.
    """
    sensors = (topics.MOCAP, topics.IMU)
    board = tuple(topic for topic in topics.ACTUATORS if topic.type.startswith("spinal"))
    board = tuple(topic for topic in board if topic is not topics.SERVO_TARGETS)
    if profile == "both":
        commands = (topics.FOUR_AXES, topics.GIMBALS_CTRL, topics.CONFIG)
        robot = (*sensors, topics.JOINT_STATES, *commands)
        return ProfileTopics((*topics.USER, topics.BATTERY), (topics.CLOCK, *robot, *topics.VIEWS))
    states, targets = (topics.JOINT_STATES,), (topics.JOINTS_CTRL, topics.GIMBALS_CTRL)
    if servos:
        states, targets = (topics.SERVO_STATES,), (topics.SERVO_TARGETS,)
    robot = (*sensors, *states, topics.ACK, topics.PWMS, topics.BATTERY)
    if profile == "simulator":
        switch = (topics.GIMBAL_DOF, *((topics.SERVO_TORQUE,) if servos else ()))
        return ProfileTopics(
            (*board, *targets, *switch), (topics.CLOCK, *robot, topics.RPY_PID, topics.DIAGNOSTICS)
        )
    more = (topics.JOINT_STATES, topics.SERVO_TORQUE) if servos else ()
    return ProfileTopics((*topics.USER, *robot), (*board, *targets, *more, *topics.VIEWS))


def profile_services(profile: str, servos: bool = False) -> tuple[Topic, ...]:
    """The services that a profile offers on ROS 1: those of `servo_bridge`, where it stands for one."""
    offers = profile == "both" or (profile == "controller" and servos)
    return (topics.JOINTS_TORQUE, topics.GIMBALS_TORQUE) if offers else ()


@dataclass(frozen=True)
class Dialect:
    """How a node speaks.

    Attributes:
        topics: of a profile, and whether it speaks with the servos in their own counts.
        named: gives names of a robot's joints and frames, by the topics' namespace.
        known: to a simulated flight controller with so many rotors from the start, as nobody will tell it.
    """

    topics: Callable[[str, bool], ProfileTopics] = profile_topics
    named: Callable[[Robot, str], Names] = Names
    known: Callable[[int], tuple[UavInfo | MotorInfo, ...]] = lambda rotors: ()


LAB = Dialect()
"""The lab's own, on ROS 1."""
