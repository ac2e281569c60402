"""Which way a tool points, and what the heading is, where nobody says it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from skylimb.apps.robot_import.roles import Roles
from skylimb.apps.robot_import.tree import UrdfTree, pose_at_rest
from skylimb.robots.flight_file import TipSection
from skylimb.robots.loader import tool_rotation

_NEAR = 0.35
"""Angle from an axis at which a direction counts as that axis, rad."""
_STEEP = 0.7
"""A tool that rises by this share of its length, or more, gives no heading."""
_SHORT = 0.01
"""A tip nearer to its last joint than this says no direction, m."""


def with_axes(tree: UrdfTree, roles: Roles, tip: TipSection) -> TipSection:
    """The tip with a direction and a heading, where it says none.

    A tool on an arm points away from the arm's last joint, along x of its link, along z, or as it happens.
    One on the body points away from the rotors' middle, level, or straight up or down. An arm may turn its
    tool anywhere, so the heading is the body's; it is as well where a tool on the body points up or down.
    """
    if tip.rpy is None and tip.forward is None:
        tip = _along(tip, _outward(tree, roles, tip))
    if tip.heading is not None:
        return tip
    rotors, bending = {rotor.link for rotor in roles.rotors}, {joint.get("name") for joint in roles.shape}
    if not any(joint.get("name") in bending for joint in tree.path_up(tip.link)):
        rise = (pose_at_rest(tree, tip.link)[1] @ tool_rotation(tip))[2, 0]
        return replace(tip, heading="root" if abs(rise) > _STEEP else "tool")
    carried = set[str]().union(*(tree.subtree(tree.end(joint, "child") or "") for joint in roles.shape))
    return replace(tip, heading="tool" if carried & rotors else "root")


def _outward(tree: UrdfTree, roles: Roles, tip: TipSection) -> np.ndarray:
    """The direction in which a tool points, (3,), axes of its link; zeros where nothing says it."""
    bending = {joint.get("name") for joint in roles.shape}
    xyz, R = np.array(tip.position), np.eye(3)
    for joint in tree.path_up(tip.link):
        if joint.get("name") in bending:
            return R.T @ xyz if np.linalg.norm(xyz) > _SHORT else np.zeros(3)
        at, turned = tree.place(joint)
        xyz, R = at + turned @ xyz, turned @ R
    middle = np.mean([pose_at_rest(tree, rotor.link)[0] for rotor in roles.rotors], axis=0)
    ahead, aside, up = xyz - middle
    steep = abs(up) > math.hypot(ahead, aside)
    return R.T @ (np.array([0.0, 0.0, np.sign(up)]) if steep else np.array([ahead, aside, 0.0]))


def _along(tip: TipSection, outward: np.ndarray) -> TipSection:
    """The tip with its tool along a direction: x where that is near, else z, else turned there."""
    size = float(np.linalg.norm(outward))
    if not math.isfinite(size) or size < 1e-9:
        return tip
    out = outward / size
    near = np.abs(out) > math.cos(_NEAR)
    if near[0] and out[0] > 0.0:
        return tip
    if near[2] and out[2] > 0.0:
        return replace(tip, forward="z")
    x, y, z = np.sign(out) * near if near.any() else out
    pitch, yaw = -math.asin(max(-1.0, min(1.0, z))), math.atan2(y, x)
    return replace(tip, rpy=(0.0, round(pitch, 6) + 0.0, round(yaw, 6) + 0.0))
