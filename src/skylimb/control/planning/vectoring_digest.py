"""The digest of all that a search for vectoring angles depends on."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from skylimb.control.planning.vectoring_criteria import TORQUE, VectoringCriteria
from skylimb.control.planning.vectoring_search import VERSION
from skylimb.robots import Robot


def robot_digest(robot: Robot, criteria: VectoringCriteria = TORQUE) -> str:
    """SHA-256 over every number that the search depends on, hexadecimal.

    It follows the model, not the files: another colour or lag keeps the table, another mass in memory does
    not. Numbers count to nine decimals, so that the last bit of a sine on another machine makes no other
    robot.
    """
    total = hashlib.sha256()
    for item in _relevant(robot, criteria):
        text = (
            item
            if isinstance(item, str)
            else " ".join(f"{entry:.9f}" for entry in np.round(np.ravel(item), 9) + 0.0)
        )
        total.update(text.encode() + b"\n")
    return total.hexdigest()


def _relevant(robot: Robot, criteria: VectoringCriteria) -> Iterator[Any]:
    description = robot.description
    yield f"search {VERSION}"
    yield [criteria.degree, criteria.smoothing, criteria.slope, criteria.tilt]
    joints = description.moving_joints
    yield [len(description.shape_joints), len(description.vectoring_joints)]
    for body in robot.bodies:
        yield [
            body.parent,
            -1 if body.joint is None else joints.index(body.joint.name),
            body.mass,
            *body.xyz,
            *body.com,
        ]
        yield body.R
        if body.joint is not None:
            yield body.joint.axis
    for rotor in description.rotors:
        place = robot.placements[rotor.link]
        yield [place.body, *(place.xyz + place.R @ rotor.xyz), rotor.drag_torque_coefficient]
        yield (place.R @ rotor.R)[:, 2]
        yield [rotor.thrust_min, rotor.thrust_max]
    posture = description.posture
    yield [*posture.offset, *posture.slope, posture.theta_min, posture.theta_max, posture.theta_nominal]
    yield description.vectoring_start
    limits = np.array(robot.vectoring_limits())
    if np.isfinite(limits).any():
        yield np.nan_to_num(limits, posinf=1e9, neginf=-1e9)
    if criteria == TORQUE:
        return
    # Only now, so that tables found before there were other criteria keep their digest.
    yield [criteria.thrust_margin, *criteria.span(robot)]
    yield f"leak {criteria.leak!r} sideways {criteria.sideways!r} effort {criteria.effort!r}"
    if np.isfinite(criteria.servos):
        yield [criteria.servos, *np.broadcast_to(description.shape_servos.torque_limit, robot.n_joints)]
    place = robot.placements[description.tip.link]
    yield [
        place.body,
        *(place.xyz + place.R @ description.tip.position),
        *(place.R @ description.tip.R)[:, 0],
    ]
    if description.tip.heading != "tool":  # as above
        yield description.tip.heading
