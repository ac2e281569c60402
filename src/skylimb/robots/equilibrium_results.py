"""What is kept, and what comes of the question whether it can be held (`robots.equilibrium`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

LEVEL = 1e-3
"""Tilt that stands for none, rad; four rotors hold a wrench of six only with some."""

TILT = 0.35
"""Tilt to which a robot may lean into a push unless another is given, rad (20 degrees)."""


@dataclass(frozen=True)
class Within:
    """What has to be kept beside the limits of rotors and servos.

    Attributes:
        tilt: of the measured link from the vertical, the greatest, rad; less than `LEVEL` counts as that.
        moves: how far each vectoring angle may move from the given one, rad; infinite for all of its travel.
        margin: torque that has to be left about any axis, N m.
        servo: share of its torque that a servo may give.
        stiff: whether the joint angles are measured ones, so that no joint gives way.
    """

    tilt: float = TILT
    moves: float = 0.0
    margin: float = 0.0
    servo: float = 1.0
    stiff: bool = False


USUAL = Within()


@dataclass(frozen=True)
class Limit:
    """What ends it.

    Attributes:
        kind: "greatest thrust", "least thrust", "servo", "tilt", "vectoring angle" or "margin".
        name: of the rotor or joint; else empty.
        value: the limit, in `unit`.
        unit: N, N m or rad.
        kept: margin that is kept from it, N m; of thrusts.
    """

    kind: str
    name: str
    value: float
    unit: str
    kept: float = 0.0

    def __str__(self) -> str:
        whose = f" of '{self.name}'" if self.name else ""
        kept = f", with {self.kept:.3g} N m kept" if self.kept > 0.0 else ""
        return f"the {self.kind}{whose} ({self.value:.4g} {self.unit}{kept})"


@dataclass(frozen=True, eq=False)
class Held:
    """A robot that rests.

    Attributes:
        push: of the tip on its surroundings, in the level frame whose x axis is the heading, N, (3,).
        thrusts: N, (n,).
        vectoring_angles: rad, (nv,).
        joint_angles: where the servos hold the joints, rad, (nq,).
        joint_torques: of rotors, weight and push on each shape joint, N m, (nq,).
        tilt: of the measured link from the vertical, rad.
        margin: torque that is left about any axis, N m; 0 where the rotors do not give lift and all torques.
        room: least distance of a thrust to one of its limits, as a share of its range.
        limit: what ends it, or what the margin runs into first; None where nothing did.
    """

    push: np.ndarray
    thrusts: np.ndarray
    vectoring_angles: np.ndarray
    joint_angles: np.ndarray
    joint_torques: np.ndarray
    tilt: float
    margin: float
    room: float
    limit: Limit | None

    def __bool__(self) -> Literal[True]:
        return True

    @property
    def force(self) -> float:
        """Size of the push, N."""
        return float(np.linalg.norm(self.push))


@dataclass(frozen=True, eq=False)
class NotHeld:
    """A robot that cannot rest so.

    Attributes:
        limit: the limit in the way; None where the search came to no end.
        excess: by which share all limits together would have to give way.
        margin: what is left, where it is only less than what was asked for, N m.
        greatest: the greatest push the same way that can be held, N; None where not even none can.
    """

    limit: Limit | None
    excess: float
    margin: float | None = None
    greatest: float | None = None

    def __bool__(self) -> Literal[False]:
        return False

    def __str__(self) -> str:
        if self.limit is None:
            return "the search for thrusts and angles that hold it came to no end"
        if self.margin is not None:
            return f"{self.limit} leaves a margin of {self.margin:.3g} N m"
        return f"{self.limit} is in the way"
