"""What the robot should do at a tick."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.symbolic import Array


class Reference(NamedTuple):
    """What the robot should do at a tick.

    Attributes:
        position: of the centre of gravity in W, m, (3,).
        velocity: m/s, zero when positions alone are sent.
        acceleration: m/s^2, zero when positions alone are sent.
        heading: about W's z in the nominal posture, rad.
        reach: tip to centre of gravity along the heading, m (r_ref of eq:admittance control).
        joint_angles: nominal posture q, rad; the shape law's change of reach comes on top of it.
        vectoring_angles: nominal psi of that posture, rad.
        contact_axis: unit vector in W pointing from the robot into the surface, (3,).
        tare: 1 while the observer's bias is averaged, else 0.
        align: 1 to turn the whole robot so that it keeps its heading though the joints give way,
            else 0.
        adapt: 1 while the shape law may answer to force, else 0.
        tip_position: of the tip on its path over the nominal surface, in W, m, (3,): before the approach it
            stands off, afterwards it lies on the nominal surface, wherever the real one is.
        tip_velocity: its rate, m/s, whether or not velocities are sent.
        tip_acceleration: m/s^2.
        touch: 1 while the tip is to touch, or to go on until it does, else 0.
        wait: 1 while the mission should not go on without touch, else 0.
        sliding_axis: unit vector u of the sliding plane in W, (3,); the other one is contact_axis x u.
        force: wanted normal force, N; 0 where the path says none, and the controller's own gain counts.
        clearance: way that a pen lifted from one stroke to the next has to keep from a surface that goes on
            as where it left, with its slope or, where it recedes, level, m; 0 where `tip_position` says all.
        fine: 1 while a small stroke is drawn (`planning.trajectories.FINE`), else 0.
        ahead: the references at later times on the mission's clock, as many as the controller's laws declare
            (`Needs.preview`); they have no `ahead` of their own.
    """

    position: Array
    velocity: Array
    acceleration: Array
    heading: Any
    reach: Any
    joint_angles: Array
    vectoring_angles: Array
    contact_axis: Array
    tare: Any
    align: Any
    adapt: Any
    tip_position: Array
    tip_velocity: Array
    tip_acceleration: Array
    touch: Any
    wait: Any
    sliding_axis: Array
    force: Any
    clearance: Any
    fine: Any
    ahead: tuple[Reference, ...] = ()

    @property
    def entries(self) -> tuple[Any, ...]:
        """Every entry in turn, those of the references ahead behind the others: what travels flat."""
        return (*self[:-1], *(entry for later in self.ahead for entry in later[:-1]))


def zero_reference(n_joints: int, n_vectoring: int) -> Reference:
    """A reference of zeros, which tells the sizes of all entries."""
    z3, q, psi = np.zeros(3), np.zeros(n_joints), np.zeros(n_vectoring)
    return Reference(
        *(z3, z3, z3, 0.0, 0.0, q, psi, z3, 0.0, 0.0, 0.0, z3, z3, z3, 0.0, 0.0, z3, 0.0, 0.0, 0.0)
    )


def untasked(reference: Reference, **changes: Any) -> Reference:
    """The reference without what a mission asks for beside places and posture, other entries changed."""
    return reference._replace(
        tare=0.0, adapt=0.0, touch=0.0, wait=0.0, clearance=0.0, fine=0.0, ahead=(), **changes
    )


RATES = ("velocity", "tip_velocity")
"""Entries that scale with the pace of the mission's clock."""

ACCELERATIONS = ("acceleration", "tip_acceleration")
"""Entries that scale with the square of the pace."""
