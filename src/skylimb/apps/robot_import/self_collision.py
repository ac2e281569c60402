"""Which links of a robot touch each other, over its range of postures, as the engine sees their shapes."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from skylimb.base.errors import DescriptionError
from skylimb.robots.description import RobotDescription
from skylimb.robots.starts import golden_steps
from skylimb.simulation.robot_bodies import add_robot, add_shape

_DRAWS = 200


@dataclass(frozen=True)
class SelfCollision:
    """What touches.

    Attributes:
        mass: of the robot as the physics engine has it, kg.
        shaped: links that have a shape to collide with.
        family: pairs of links that touch in the family of postures, with the first theta (rad) of each.
        share: share of all postures within the joint limits in which any pair touches.
        always: pairs that touch in every posture, and do not count.
    """

    mass: float
    shaped: int
    family: tuple[tuple[str, str, float], ...]
    share: float
    always: tuple[tuple[str, str], ...]


def find_self_collisions(description: RobotDescription) -> SelfCollision:
    """Put the robot into many postures and ask the engine what touches.

    Links that are joined, directly or across bodies without a shape, never count.

    Raises:
        DescriptionError: the engine does not take the robot.
    """
    spec = mujoco.MjSpec()
    shaped = [link for link in description.links if link.collisions]
    try:
        add_robot(spec, description)
        for link in shaped:
            for index, shape in enumerate(link.collisions):
                add_shape(spec, spec.body(link.name), shape, f"collision_{link.name}_{index}", collides=True)
        model = spec.compile()
    except ValueError as error:
        raise DescriptionError(
            f"the physics engine refuses it: {' '.join(str(error).split())[:300]}"
        ) from None
    data = mujoco.MjData(model)
    posture, joined = description.posture, _joined(description)
    addresses = [int(model.jnt_qposadr[model.joint(name).id]) for name in description.shape_joints]
    turning = [int(model.jnt_qposadr[model.joint(name).id]) for name in description.vectoring_joints]

    def touching(q: np.ndarray) -> set[tuple[str, str]]:
        data.qpos[addresses] = q
        data.qpos[turning] = description.vectoring_start
        mujoco.mj_fwdPosition(model, data)
        return {_pair(model, contact.geom1, contact.geom2) for contact in data.contact} - joined

    thetas = np.linspace(posture.theta_min, posture.theta_max, 15)
    along = [touching(posture.offset + posture.slope * theta) for theta in thetas]
    drawn = [touching(q) for q in _draws(description)]
    always = set.intersection(*along, *drawn) if along else set()
    family: dict[tuple[str, str], float] = {}
    for theta, pairs in zip(thetas, along, strict=True):
        for pair in sorted(pairs - always):
            family.setdefault(pair, float(theta))
    share = float(np.mean([bool(pairs - always) for pairs in drawn])) if drawn else 0.0
    return SelfCollision(
        float(model.body_subtreemass[model.body(description.root).id]),
        len(shaped),
        tuple((*pair, theta) for pair, theta in family.items()),
        share,
        tuple(sorted(always)),
    )


def _joined(description: RobotDescription) -> set[tuple[str, str]]:
    """Pairs of shaped links with no other shaped body between them in the tree."""
    above = {joint.child: joint for joint in description.joints}
    shaped = {link.name for link in description.links if link.collisions}

    def body(link: str) -> str:
        while link in above and above[link].kind == "fixed":
            link = above[link].parent
        return link

    bodies = {body(name) for name in shaped}

    def anchor(link: str) -> str:
        """The nearest shaped body above the link's own, the root where there is none."""
        at = body(link)
        while at in above:
            at = body(above[at].parent)
            if at in bodies:
                return at
        return at

    return {
        (one, other)
        for one in shaped
        for other in shaped
        if one < other
        and (
            body(one) == body(other)
            or anchor(one) in (body(other), anchor(other))
            or anchor(other) == body(one)
        )
    }


def _draws(description: RobotDescription) -> list[np.ndarray]:
    joints = [description.joint(name) for name in description.shape_joints]
    if not joints:
        return []
    low = np.array([joint.lower if np.isfinite(joint.lower) else -np.pi for joint in joints])
    high = np.array([joint.upper if np.isfinite(joint.upper) else np.pi for joint in joints])
    steps = np.outer(np.arange(_DRAWS), golden_steps(len(joints))) % 1.0
    return list(low + (high - low) * steps)


def _pair(model: mujoco.MjModel, one: int, other: int) -> tuple[str, str]:
    names = sorted(model.body(int(model.geom_bodyid[geom])).name for geom in (one, other))
    return names[0], names[1]
