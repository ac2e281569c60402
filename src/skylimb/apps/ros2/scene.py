"""What stands around the robot, as rviz and Foxglove draw it."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from skylimb.analysis.exchange.lab_messages import Fields, floats
from skylimb.analysis.exchange.ros2_topics import marker
from skylimb.analysis.viewer.shapes import shapes
from skylimb.flight.plan import FlightPlan
from skylimb.flight.takeoff import simulated

_KINDS = {"box": 1, "sphere": 2, "ellipsoid": 2, "cylinder": 3, "capsule": 3, "mesh": 11}
"""Numbers of visualization_msgs/Marker."""


def scene(plan: FlightPlan) -> Fields:
    """The surface, and what carries it."""
    model = mujoco.MjModel.from_xml_string(simulated(plan).plant.scene)
    fixed = [shape for shape in shapes(model) if shape["body"] == 0 and shape["kind"] in _KINDS]
    return {"markers": [_drawn(model, number, shape) for number, shape in enumerate(fixed)]}


def _drawn(model: Any, number: int, shape: dict[str, Any]) -> Fields:
    """A shape of the engine's, whose sizes are half lengths: a radius and half a length of a cylinder."""
    kind, size = shape["kind"], 2.0 * np.array(shape["size"], dtype=float)
    if kind in ("cylinder", "capsule"):
        size = size[[0, 0, 1]]
    elif kind == "sphere":
        size = size[[0, 0, 0]]
    points: list[tuple[float, ...]] = []
    if kind == "mesh":
        first, corners = model.mesh_vertadr[shape["mesh"]], model.mesh_faceadr[shape["mesh"]]
        faces = model.mesh_face[corners : corners + model.mesh_facenum[shape["mesh"]]]
        points, size = [floats(one) for one in model.mesh_vert[first + faces.ravel()]], np.ones(3)
    look = marker("scene", number, _KINDS[kind], floats(size), (*shape["colour"][:3], 1.0))
    place = {"pose.position": tuple(shape["position"]), "pose.orientation": tuple(shape["quaternion"])}
    return {**look, **place, "points": points}
