"""Integrators hold while the rotors fall short: what cannot be given must not pile up.

While the rotors are at their limits, an error cannot shrink as fast as the law expects. An integrator that
goes on grows without effect, and later carries the robot past its goal by as much. So an integral grows no
further in a direction in which the rotors fell short at the last tick, and comes back freely. That is
conditional integration.
"""

from __future__ import annotations

from skylimb.symbolic import Array, where


def unless_short(increment: Array, residual: Array) -> Array:
    """The increment of an integral, 0 where it has the sign of what the rotors fell short of, entry by entry.

    Args:
        increment: in the direction of the force or torque that it makes.
        residual: wanted less given force or torque of the last tick, N or N m; zeros change nothing.
    """
    return where(increment * residual > 0.0, 0.0, increment)
