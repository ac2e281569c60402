"""What a tool at the tip did: how deep a peg went, and how flat a foot lay."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.loop.flight import Flight
from skylimb.simulation.plant import Plant


def tool_signals(plant: Plant, flight: Flight, tip_position: np.ndarray) -> dict[str, np.ndarray]:
    """Truth of the tool at the tip at every tick; nothing of a tip without one.

    What a tool touches stands still: no event changes such a surface (`events.surface`).

    Args:
        plant: what flew.
        flight: the raw record.
        tip_position: W, m, (ticks, 3).

    Returns:
        `peg_depth`, how far the round end of the peg is below the face of its hole at its deepest point (m,
        negative before it); and
        `foot_angle`, between the foot's outward axis and the surface's inward normal (rad).
    """
    found: dict[str, np.ndarray] = {}
    tip, surface = plant.robot.description.tip, plant.surface
    if plant.peg is not None:
        radius, _ = plant.peg
        middle = tip_position + (tip.radius - radius) * _in_world(plant, flight, tip.along)
        found["peg_depth"] = surface.to_local(middle)[:, 0] + radius
    if plant.foot is not None:
        outward = _in_world(plant, flight, tip.R[:, 0])
        cosine = -np.sum(outward * surface.normal(tip_position), axis=1)
        found["foot_angle"] = np.arccos(np.clip(cosine, -1.0, 1.0))
    return found


def _in_world(plant: Plant, flight: Flight, direction: np.ndarray) -> np.ndarray:
    """A direction (3,) of the tip's link at every tick, W, (ticks, 3)."""
    qpos = flight.signal("configuration")
    at = ca.SX.sym("qpos", qpos.shape[1])
    pose = plant.robot.link_pose_function(plant.robot.description.tip.link)
    link: Any = pose(at[list(plant.joint_qpos)], at[list(plant.vectoring_qpos)])
    turned = rotation_from_quaternion(at[3:7]) @ link[:, 1:4] @ ca.DM(direction)
    return np.asarray(ca.Function("turned", [at], [turned]).map(len(qpos))(qpos.T)).T
