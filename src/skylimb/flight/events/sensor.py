"""Sensors that fail: motion capture that is lost, late, wrong or out of order, encoders, an IMU.

All of it is known before take-off: a few numbers are added to the rows that say how old a tick's frame is,
whether it is the last one still, how far its stamp is off, and what its errors are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, Vector3, configuration, refused
from skylimb.flight.events.event import Event, EventContext, TickRows, require_known
from skylimb.simulation.rows import row_layout
from skylimb.simulation.sensors import LONGEST, SensorConfig, frame_numbers

_ZERO = (0.0, 0.0, 0.0)
_POSE = ("noise.position", "noise.velocity", "noise.attitude", "noise.angular_velocity")
_IMU = ("noise.gyro", "noise.accelerometer")
_BACK = 2.0
"""Frames by which one that is out of order is older."""


@configuration
class SensorFault(Event):
    """Sensors say something else than what is, or nothing."""

    kind: Literal["sensor"] = field(default="sensor", kw_only=True)
    capture: Annotated[
        Literal["", "lost", "frozen", "nan", "disordered"],
        Key(
            "",
            "'lost': no frame comes; 'frozen': frames with new stamps show what the last one did; 'nan': no "
            "numbers; 'disordered': every second frame is older than the one before it",
        ),
    ] = ""
    late: Annotated[float, Key("s", "by which frames come later", low=0.0, high=0.19)] = 0.0
    jump: Annotated[Vector3, Key("m", "from the true to the seen position, W", low=-100.0, high=100.0)] = (
        _ZERO
    )
    turn: Annotated[
        Vector3, Key("rad", "rotation vector from the true to the seen body axes", low=-3.0, high=3.0)
    ] = _ZERO
    stamp: Annotated[
        float, Key("s", "by which stamps are older than the frames; below 0 younger", low=-1e3, high=1e3)
    ] = 0.0
    joint: Annotated[str, Key("", "whose encoder is off, of shape or vectoring joints")] = ""
    offset: Annotated[float, Key("rad", "by how much", low=-6.3, high=6.3)] = 0.0
    imu: Annotated[Literal["", "lost"], Key("", "'lost': the IMU says no numbers")] = ""
    duration: Annotated[float, Key("s", "how long it lasts; 0: for good", low=0.0, high=1e5)] = field(
        default=0.0, kw_only=True
    )

    on: ClassVar[Literal["controller", "plant"]] = "plant"

    def check(self) -> None:
        """Refuse a fault that changes nothing."""
        super().check()
        if bool(self.joint) != bool(self.offset):
            raise refused(self, "offset", "needs a joint, and joint an offset")
        if not self.changed:
            raise refused(self, "time", "changes nothing: give capture, late, jump, turn, stamp, joint, imu")

    @property
    def changed(self) -> dict[str, Any]:
        """What is otherwise."""
        names = ("capture", "late", "jump", "turn", "stamp", "joint", "imu")
        return {name: value for name in names if (value := getattr(self, name)) not in ("", 0.0, _ZERO)}

    @property
    def words(self) -> str:
        """What they do."""
        said = {
            "capture": f"capture {self.capture}",
            "late": f"capture {1e3 * self.late:g} ms later",
            "jump": f"capture {np.linalg.norm(self.jump):.3g} m off",
            "turn": f"capture turned by {np.linalg.norm(self.turn):.3g} rad",
            "stamp": f"stamps {self.stamp:g} s older",
            "joint": f"encoder of {self.joint} {self.offset:g} rad off",
            "imu": "IMU lost",
        }
        return ", ".join(said[name] for name in self.changed)

    def older(self, sensors: SensorConfig) -> float:
        """By how much a frame may be older than it is without the fault, s."""
        return self.late + (_BACK / (sensors.rate or np.inf) if self.capture == "disordered" else 0.0)

    def require(self, context: EventContext) -> None:
        """There is such a joint or an IMU, and frames are not older than the sensors remember."""
        require_known("encoder of an event", self.joint, context.robot.description.moving_joints)
        sensors = context.sensors
        if self.imu and not sensors.imu.on:
            raise ConfigError(f"{self}: there is no IMU that could fail; sensors.imu.on = true gives it one")
        if self.capture == "disordered" and not sensors.rate:
            raise ConfigError(f"{self}: sensors.rate = 0 has a frame at every tick, which come in order")
        oldest = sensors.latency + self.older(sensors)
        if oldest > LONGEST:
            raise ConfigError(f"{self}: frames would be {oldest:g} s old; the sensors remember {LONGEST:g} s")

    @classmethod
    def effect(cls, events: Sequence[SensorFault], context: EventContext, times: np.ndarray) -> TickRows:
        """What is added to the rows of the flight."""
        layout = row_layout(context.robot)
        added = np.zeros((len(times), layout.size))
        part = {name: added[:, where] for name, where in layout.slices.items()}
        for one in events:
            ticks = one.lasting(times)
            since = times[ticks, None] - one.time
            waiting = since < one.late - 1e-9
            part["held"][ticks] += waiting | (one.capture == "lost")
            part["frozen"][ticks] += one.capture == "frozen"
            part["age"][ticks] += np.where(waiting, 0.0, one.late)
            part["stamp"][ticks] += one.stamp
            if one.capture == "disordered":
                odd = frame_numbers(context.sensors, times[ticks, None]) % 2
                part["age"][ticks] += odd * _BACK / context.sensors.rate
            part["noise.position"][ticks] += one.jump
            part["noise.attitude"][ticks] += _small(one.turn)
            for name in (*(_POSE if one.capture == "nan" else ()), *(_IMU if one.imu else ())):
                part[name][ticks] = np.nan
            if one.joint:
                angles = one.offset * (np.array(context.robot.description.moving_joints) == one.joint)
                part["noise.joint_angles"][ticks] += angles[: context.robot.n_joints]
                part["noise.vectoring_angles"][ticks] += angles[context.robot.n_joints :]
        return TickRows(added)


def _small(turn: Vector3) -> np.ndarray:
    """A rotation vector as the sensors' error has it: twice the tangent of half the angle along the axis."""
    angle = float(np.linalg.norm(turn))
    return np.array(turn) * (2.0 * np.tan(0.5 * angle) / angle if angle else 1.0)
