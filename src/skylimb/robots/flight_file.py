"""The flight TOML: what a robot needs that URDF cannot say. Each class is one table of the file."""

from __future__ import annotations

import math
from dataclasses import field
from typing import Annotated, Literal

from skylimb.base.keys import Key, configuration, refused
from skylimb.robots.description import Servo

_TURN = 2.0 * math.pi
_Place = tuple[float, float, float]

ThrustFactor = Annotated[float | None, Key("N s^2", "thrust over squared speed (rad/s)", above=0.0, high=1.0)]
RotorInertia = Annotated[
    float | None, Key("kg m^2", "of propeller and motor bell about their axis", low=0.0, high=0.1)
]
RotorRadius = Annotated[
    float | None,
    Key("m", "radius of its disc; that of the drawn propeller when left out", above=0.0, high=2.0),
]
TorqueLimit = Annotated[
    float | None, Key("N m", "greatest torque of the motor, driving and braking", above=0.0, high=1e3)
]
CurrentLimit = Annotated[
    float | None, Key("A", "greatest current of the motor; needs torque_constant", above=0.0, high=1e4)
]
TorqueConstant = Annotated[
    float | None, Key("N m/A", "torque of the motor per current", above=0.0, high=10.0)
]


@configuration
class ShapeSection:
    """The joints that bend the chain, and their servo."""

    joints: Annotated[tuple[str, ...], Key("", "names, in the order of the joint angles q")]
    servo: Servo


@configuration
class VectoringSection:
    """The joints that turn the rotors, and their servo."""

    joints: Annotated[tuple[str, ...], Key("", "names, in the order of the vectoring angles psi")]
    servo: Servo
    start: Annotated[
        tuple[float, ...],
        Key("rad", "where the search for good vectoring angles begins", low=-2.0 * _TURN, high=2.0 * _TURN),
    ]


@configuration
class RotorSection:
    """One rotor; the thrust acts along z of its frame {F_i}."""

    link: Annotated[str, Key("", "link that {F_i} is fixed to")]
    spin: Annotated[Literal[1, -1], Key("", "1 where it turns about +z, -1 about -z")]
    drag_torque_coefficient: Annotated[
        float, Key("m", "drag torque per thrust, without sign: that follows from spin", low=0.0, high=1.0)
    ]
    thrust_min: Annotated[float, Key("N", "least thrust, below thrust_max", low=0.0, high=1e4)]
    thrust_max: Annotated[float, Key("N", "greatest thrust", above=0.0, high=1e4)]
    lag: Annotated[float, Key("s", "time constant of the thrust, and of the speed", above=0.0, high=10.0)]
    thrust_factor: ThrustFactor = None
    inertia: RotorInertia = None
    torque_limit: TorqueLimit = None
    current_limit: CurrentLimit = None
    torque_constant: TorqueConstant = None
    radius: RotorRadius = None
    xyz: Annotated[_Place, Key("m", "origin of {F_i} in the link's frame", low=-10.0, high=10.0)] = (
        0.0,
        0.0,
        0.0,
    )
    rpy: Annotated[
        _Place, Key("rad", "roll, pitch and yaw of {F_i} in the link's frame", low=-_TURN, high=_TURN)
    ] = (0.0, 0.0, 0.0)
    name: Annotated[str | None, Key("", "short name; rotor1, rotor2 ... where there is none")] = None

    def check(self) -> None:
        """Refuse thrust limits that leave no range, and a current that says nothing of the torque."""
        if not self.thrust_min < self.thrust_max:
            raise refused(self, "thrust_min", f"must be below thrust_max = {self.thrust_max:g} N")
        if (self.current_limit is None) != (self.torque_constant is None):
            said, lacking = "current_limit", "torque_constant"
            if self.current_limit is None:
                said, lacking = lacking, said
            raise refused(self, said, f"needs {lacking} beside it: together they limit the torque")
        if not self.thrust_min < self.thrust_most:
            key = "current_limit" if self.torque_limit is None else "torque_limit"
            raise refused(
                self,
                key,
                f"holds the rotor against its drag up to {self.thrust_most:.3g} N only; that must be above "
                f"thrust_min = {self.thrust_min:g} N",
            )

    @property
    def torque_max(self) -> float:
        """The least of what torque and current allow, N m; infinite where the file says neither."""
        by_current = math.inf
        if self.current_limit is not None and self.torque_constant is not None:
            by_current = self.current_limit * self.torque_constant
        return min(by_current, math.inf if self.torque_limit is None else self.torque_limit)

    @property
    def thrust_most(self) -> float:
        """`thrust_max`, or less where the drag at that thrust is more than the motor's torque, N."""
        drag = self.drag_torque_coefficient
        return min(self.thrust_max, self.torque_max / drag if drag > 0.0 else math.inf)


@configuration
class TipSection:
    """The ball that touches, and the stick that carries it; the stick is drawn, and weighs nothing."""

    link: Annotated[str, Key("", "link that carries it")]
    position: Annotated[_Place, Key("m", "centre of the ball in the link's frame", low=-10.0, high=10.0)]
    radius: Annotated[float, Key("m", "radius of the ball", above=0.0, high=1.0)]
    stem: Annotated[
        _Place | None, Key("m", "where the stick begins, in the link's frame", low=-10.0, high=10.0)
    ] = None
    rpy: Annotated[
        _Place | None,
        Key("rad", "roll, pitch and yaw of the tool in the link's frame", low=-_TURN, high=_TURN),
    ] = None
    forward: Annotated[
        Literal["x", "z"] | None, Key("", "axis of that frame which points out of the tool; x when left out")
    ] = None
    heading: Annotated[
        Literal["tool", "root"] | None,
        Key(
            "",
            "whose x axis, seen from above, is the heading: the tool's, pointing out, or 'root' for one that "
            "points up or down or may turn past that; 'tool' when left out of a flight file",
        ),
    ] = None


@configuration
class ImuSection:
    """The IMU; where there is no such table it sits at the measured link's origin, in that link's axes."""

    link: Annotated[str, Key("", "link that it sits on")]
    xyz: Annotated[_Place, Key("m", "its origin in the link's frame", low=-10.0, high=10.0)] = (0.0, 0.0, 0.0)
    rpy: Annotated[
        _Place, Key("rad", "roll, pitch and yaw of its axes in the link's frame", low=-_TURN, high=_TURN)
    ] = (0.0, 0.0, 0.0)


@configuration
class PostureSection:
    """Postures with one parameter, the shape angle: q = offset + slope theta (eq:joint angles)."""

    offset: Annotated[tuple[float, ...], Key("rad", "q at theta = 0", low=-_TURN, high=_TURN)]
    slope: Annotated[tuple[float, ...], Key("rad/rad", "dq/dtheta", low=-100.0, high=100.0)]
    theta_min: Annotated[float, Key("rad", "smallest theta", low=-_TURN, high=_TURN)]
    theta_max: Annotated[float, Key("rad", "largest theta", low=-_TURN, high=_TURN)]
    theta_nominal: Annotated[float, Key("rad", "theta that it flies with", low=-_TURN, high=_TURN)]
    contact_side: Annotated[
        Literal["same", "mirrored"],
        Key(
            "",
            "'mirrored': with vectoring angles for contact the joints bend to the other side, "
            "q = -(offset + slope theta)",
        ),
    ] = "same"

    def check(self) -> None:
        """Refuse a nominal posture outside of the range, and an empty range."""
        low, high = self.theta_min, self.theta_max
        if not low < high:
            raise refused(self, "theta_min", f"must be below theta_max = {high:g} rad")
        if not low <= self.theta_nominal <= high:
            raise refused(
                self, "theta_nominal", f"is outside of theta_min = {low:g} .. theta_max = {high:g} rad"
            )


@configuration
class FlightFile:
    """A whole flight TOML; a robot without bending joints, or without vectoring, leaves their tables out."""

    name: Annotated[str, Key("", "short name of the robot")]
    urdf: Annotated[str, Key("", "file name of the URDF, beside the TOML")]
    measured_link: Annotated[str, Key("", "the link whose pose and twist are measured")]
    tip: TipSection
    shape: ShapeSection | None = None
    vectoring: VectoringSection | None = None
    posture: PostureSection | None = None
    imu: ImuSection | None = None
    rotors: tuple[RotorSection, ...] = field(default_factory=tuple)
    summary: Annotated[str, Key("", "one line for people")] = ""
    root_link: Annotated[
        str | None,
        Key("", "where the URDF has massless links above the first real one, the name of the real one"),
    ] = None

    def check(self) -> None:
        """Refuse joints that bend without postures for them."""
        if self.shape is not None and self.shape.joints and self.posture is None:
            raise refused(self, "posture", "is missing: it says how the joints of [shape] stand")
