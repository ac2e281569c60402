"""Sensors that fail: motion capture that is lost, late, wrong or out of order, encoders, an IMU.

All of it is known before take-off: a few numbers are added to the rows that say how old a tick's frame is,
what of it is still the last one's, how far its stamp and its twist are off, and what its errors are.
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
    velocity: Annotated[
        float,
        Key("", "share of the true velocity that is seen; below 0 its sign is wrong", low=-10.0, high=10.0),
    ] = 1.0
    rates: Annotated[float, Key("", "the same of the rates", low=-10.0, high=10.0)] = 1.0
    joint: Annotated[str, Key("", "whose encoder fails, of shape or vectoring joints")] = ""
    offset: Annotated[float, Key("rad", "by how much it is off", low=-6.3, high=6.3)] = 0.0
    stuck: Annotated[
        Literal["", "velocity", "rates", "twist", "encoder"],
        Key("", "what stays as it was to the bit: of the capture, both as 'twist', or the joint's encoder"),
    ] = ""
    imu: Annotated[Literal["", "lost"], Key("", "'lost': the IMU says no numbers")] = ""
    duration: Annotated[float, Key("s", "how long it lasts; 0: for good", low=0.0, high=1e5)] = field(
        default=0.0, kw_only=True
    )

    on: ClassVar[Literal["controller", "plant"]] = "plant"
    lasts: ClassVar[bool] = True

    def check(self) -> None:
        """Refuse a fault that changes nothing."""
        super().check()
        if self.offset and self.stuck == "encoder":
            raise refused(self, "offset", "of an encoder that is stuck means nothing")
        if bool(self.joint) != bool(self.offset or self.stuck == "encoder"):
            raise refused(self, "joint", "needs an offset or stuck = 'encoder', and either one a joint")
        for key in ("velocity", "rates"):
            if getattr(self, key) != 1.0 and self.stuck in (key, "twist"):
                raise refused(self, key, f"means nothing beside stuck = '{self.stuck}'")
        if not self.changed:
            raise refused(self, "time", f"changes nothing: give {', '.join((*self._otherwise, 'joint'))}")

    @property
    def changed(self) -> dict[str, Any]:
        """What is otherwise, encoder by encoder."""
        names = {"offset": f"{self.joint} offset", "stuck": f"{self._stuck} stuck"}
        return {
            names.get(name, name): value
            for name, (value, right, _) in self._otherwise.items()
            if value != right
        }

    @property
    def _stuck(self) -> str:
        """What is stuck, in words."""
        return f"encoder of {self.joint}" if self.stuck == "encoder" else self.stuck

    @property
    def _otherwise(self) -> dict[str, tuple[Any, Any, str]]:
        """What may be otherwise: what it is, what it is where it is right, and in words."""
        return {
            "capture": (self.capture, "", f"capture {self.capture}"),
            "late": (self.late, 0.0, f"capture {1e3 * self.late:g} ms later"),
            "jump": (self.jump, _ZERO, f"capture {np.linalg.norm(self.jump):.3g} m off"),
            "turn": (self.turn, _ZERO, f"capture turned by {np.linalg.norm(self.turn):.3g} rad"),
            "stamp": (self.stamp, 0.0, f"stamps {self.stamp:g} s older"),
            "velocity": (self.velocity, 1.0, f"velocity {self.velocity:g} times the true one"),
            "rates": (self.rates, 1.0, f"rates {self.rates:g} times the true ones"),
            "offset": (self.offset, 0.0, f"encoder of {self.joint} {self.offset:g} rad off"),
            "stuck": (self.stuck, "", f"{self._stuck} stuck"),
            "imu": (self.imu, "", f"IMU {self.imu}"),
        }

    @property
    def words(self) -> str:
        """What they do."""
        return ", ".join(said for value, right, said in self._otherwise.values() if value != right)

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
            part["failure.held"][ticks] += waiting | (one.capture == "lost")
            part["failure.frozen"][ticks] += one.capture == "frozen"
            part["age"][ticks] += np.where(waiting, 0.0, one.late)
            part["failure.stamp"][ticks] += one.stamp
            part["failure.velocity"][ticks] += one.velocity - 1.0
            part["failure.rates"][ticks] += one.rates - 1.0
            part["failure.stuck_velocity"][ticks] += one.stuck in ("velocity", "twist")
            part["failure.stuck_rates"][ticks] += one.stuck in ("rates", "twist")
            if one.capture == "disordered":
                odd = frame_numbers(context.sensors, times[ticks, None]) % 2
                part["age"][ticks] += odd * _BACK / context.sensors.rate
            part["noise.position"][ticks] += one.jump
            part["noise.attitude"][ticks] += _small(one.turn)
            for name in (*(_POSE if one.capture == "nan" else ()), *(_IMU if one.imu else ())):
                part[name][ticks] = np.nan
            if one.joint:
                which = np.array(context.robot.description.moving_joints) == one.joint
                angles = one.offset * which
                part["failure.stuck_angles"][ticks] += (one.stuck == "encoder") * which
                part["noise.joint_angles"][ticks] += angles[: context.robot.n_joints]
                part["noise.vectoring_angles"][ticks] += angles[context.robot.n_joints :]
        return TickRows(added)


def _small(turn: Vector3) -> np.ndarray:
    """A rotation vector as the sensors' error has it: twice the tangent of half the angle along the axis."""
    angle = float(np.linalg.norm(turn))
    return np.array(turn) * (2.0 * np.tan(0.5 * angle) / angle if angle else 1.0)
