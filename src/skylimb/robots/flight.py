"""The flight TOML: what a robot needs that URDF cannot say. Each class is one table of the file."""

from __future__ import annotations

from dataclasses import dataclass, field

from skylimb.robots.description import Servo


@dataclass(frozen=True)
class ShapeSection:
    """`[shape]`: the joints that bend the chain, in the order of q, and their servo."""

    joints: tuple[str, ...]
    servo: Servo


@dataclass(frozen=True)
class VectoringSection:
    """`[vectoring]`: joints that turn the rotors, in the order of psi, their servo, a start guess (rad)."""

    joints: tuple[str, ...]
    servo: Servo
    start: tuple[float, ...]


@dataclass(frozen=True)
class RotorSection:
    """`[[rotors]]`: one rotor; `xyz` (m) and `rpy` (rad) place {F_i} on `link`; zero when that is {F_i}."""

    link: str
    spin: int
    drag_torque_coefficient: float
    thrust_min: float
    thrust_max: float
    lag: float
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    name: str | None = None


@dataclass(frozen=True)
class TipSection:
    """`[tip]`: centre (m, in the link's frame) and radius (m) of the ball that touches.

    `stem` (m, same frame) is where a stick that carries it begins; it is drawn, and weighs nothing.
    """

    link: str
    position: tuple[float, float, float]
    radius: float
    stem: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class PostureSection:
    """`[posture]`: q = offset + slope * theta for theta_min <= theta <= theta_max (eq:joint angles), rad."""

    offset: tuple[float, ...]
    slope: tuple[float, ...]
    theta_min: float
    theta_max: float
    theta_nominal: float


@dataclass(frozen=True)
class FlightFile:
    """A whole flight TOML.

    Attributes:
        name: short name of the robot.
        urdf: file name of the URDF, beside the TOML.
        measured_link: the link whose pose and twist are measured.
        rotors: in the order of the thrust vector.
        summary: one line for people.
        root_link: when the URDF has massless links above the first real one (ROS does that), the name of the
            real one.
    """

    name: str
    urdf: str
    measured_link: str
    shape: ShapeSection
    vectoring: VectoringSection
    tip: TipSection
    posture: PostureSection
    rotors: tuple[RotorSection, ...] = field(default_factory=tuple)
    summary: str = ""
    root_link: str | None = None
