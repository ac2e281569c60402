"""The signals that the log of a flight has besides what is recorded at every tick: they follow from that."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.control.loop.flight import mission_signals
from skylimb.simulation.truth import kinematics_at

_LEFT_OUT = ("skeleton",)
"""Points along the chain: the picture shows them."""


def implied_signals(
    flight: LiveFlight, ticks: int, recorded: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Exact kinematics, angles, and what the mission asks for, under the names of the log.

    Args:
        flight: that is shown.
        ticks: after which it is shown.
        recorded: the signals of the last of them.
    """
    plant, asked = flight.takeoff.plant, flight.asked(ticks)
    qpos = recorded["configuration"]
    moved = kinematics_at(plant, qpos, recorded["configuration_velocity"], asked.reference.contact_axis[0])
    found = {
        **{name: rows[0] for name, rows in mission_signals(asked, 1).items()},
        "root_position": qpos[0:3],
        "root_quaternion": qpos[3:7],
        "joint_angles": qpos[list(plant.joint_qpos)],
        "vectoring_angles": qpos[list(plant.vectoring_qpos)],
        **{name: values for name, values in moved._asdict().items() if name not in _LEFT_OUT},
    }
    return {name: np.atleast_1d(np.asarray(values, dtype=float)) for name, values in found.items()}
