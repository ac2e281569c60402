"""What each moving joint of a URDF is for, and where its rotors are."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element

import numpy as np

from skylimb.apps.robot_import.doubts import Doubt
from skylimb.apps.robot_import.mapping import MappedRotor, Mapping, Role
from skylimb.apps.robot_import.motor_plugins import plugin_rotors
from skylimb.apps.robot_import.tree import UrdfTree, number, pose_at_rest, rpy_of_z
from skylimb.base.errors import unknown_name

_ROTOR = re.compile(r"(rotor|prop|propeller|motor|thrust)[a-z_-]*?_?(\d+)", re.IGNORECASE)
_VECTORING = re.compile(r"gimbal_?(joint)?_?\d+(_(roll|pitch|yaw))?$", re.IGNORECASE)
_SHAPE = re.compile(r"joint_?\d+(_(roll|pitch|yaw))?$", re.IGNORECASE)
_ARM = re.compile(r"shoulder|elbow|wrist|fore_?arm|upper_?arm|(^|_)arm|manipulator", re.IGNORECASE)
_NO_ARM = re.compile(r"cam|lidar|sensor|grip|finger|claw|jaw|leg|gear|foot|dock", re.IGNORECASE)
"""Names of joints of an arm, and of those that move something else."""
_TURNS = ("revolute", "continuous")
_LEVEL = 0.1
"""Rise of an axle at rest below which it has no upper side, over its length."""


@dataclass(frozen=True)
class Roles:
    """What was recognised.

    Attributes:
        rotors: the link of each rotor with what the URDF or the mapping says of it, in the order of thrusts;
            a spin of None is not said.
        spinning: for each rotor the joint it spins on, None where it has none.
        shape: joints that bend the robot.
        vectoring: joints that turn rotors.
        locked: moving joints that are held at zero.
        doubts: where a guess was made.
    """

    rotors: tuple[MappedRotor, ...]
    spinning: tuple[Element | None, ...]
    shape: tuple[Element, ...]
    vectoring: tuple[Element, ...]
    locked: tuple[Element, ...]
    doubts: tuple[Doubt, ...]

    def by_name(self) -> dict[str, Role]:
        """The role of each joint by its name."""
        roles: tuple[tuple[Role, tuple[Element | None, ...]], ...] = (
            ("shape", self.shape),
            ("vectoring", self.vectoring),
            ("rotor", self.spinning),
            ("locked", self.locked),
        )
        return {
            joint.get("name", ""): role for role, joints in roles for joint in joints if joint is not None
        }


def recognise(tree: UrdfTree, mapping: Mapping) -> Roles:
    """Roles by the mapping, else by simulators' tags, by the laboratory's names, by the tree's structure.

    Raises:
        UnknownNameError: the mapping names a joint or link that is not there.
    """
    moving = {joint.get("name", ""): joint for joint in tree.moving()}
    for entry in mapping.joints:
        if entry.name not in moving:
            raise unknown_name("moving joint in the mapping", entry.name, moving)
    for rotor in mapping.rotors:
        if rotor.link not in tree.links():
            raise unknown_name("link of a rotor in the mapping", rotor.link, tree.links())
    said = mapping.rotors or plugin_rotors(tree)
    driven = {rotor.link for rotor in said}
    spinning = [joint for name, joint in moving.items() if _spins(tree, joint, mapping.role_of(name), driven)]
    rotors, joints = _rotors(tree, said, spinning)
    doubts: list[Doubt] = []
    arm = _arm(tree, [rotor.link for rotor in rotors])
    found: dict[Role, list[Element]] = {"shape": [], "vectoring": [], "rotor": [], "locked": []}
    for name, joint in moving.items():
        if any(joint is other for other in spinning):
            continue
        role, mimics = mapping.role_of(name), joint.find("mimic") is not None
        if joint.get("type") not in _TURNS and role != "locked" and (role is not None or not mimics):
            doubts.append(
                Doubt(
                    f"joint '{name}'",
                    f"is {joint.get('type')}; only joints that turn are simulated, so it is locked",
                    "nothing, if the robot may fly with it held; else replace it by a turning joint",
                )
            )
            role = "locked"
        found[role or _role(tree, joint, [rotor.link for rotor in rotors], arm, doubts)].append(joint)
    return Roles(
        rotors,
        joints,
        tuple(found["shape"]),
        tuple(found["vectoring"]),
        tuple(found["locked"] + found["rotor"]),
        tuple(doubts),
    )


def _spins(tree: UrdfTree, joint: Element, role: Role | None, driven: set[str]) -> bool:
    """Whether a joint is the axle of a rotor: so said, or so called and with nothing that moves below it."""
    if role is not None:
        return role == "rotor"
    name, child = joint.get("name", ""), tree.end(joint, "child") or ""
    called = _ROTOR.match(name) or (_ROTOR.match(child) and not _VECTORING.match(name)) or child in driven
    return (
        bool(called)
        and not _moving_below(tree, child)
        and joint.get("type") in _TURNS
        and not _SHAPE.match(name)
    )


def _moving_below(tree: UrdfTree, link: str) -> list[Element]:
    inside = tree.subtree(link)
    return [joint for joint in tree.moving() if tree.end(joint, "parent") in inside]


def _number_in(name: str) -> tuple[int, str]:
    digits = re.findall(r"\d+", name)
    return (int(digits[-1]) if digits else 0, name)


def _rotors(
    tree: UrdfTree, said: tuple[MappedRotor, ...], spinning: list[Element]
) -> tuple[tuple[MappedRotor, ...], tuple[Element | None, ...]]:
    by_link = {tree.end(joint, "child") or "": joint for joint in spinning}
    if said:
        return said, tuple(by_link.get(rotor.link) for rotor in said)
    if spinning:
        ordered = sorted(spinning, key=lambda joint: _number_in(joint.get("name", "")))
        return _signed(tree, [_spinning_rotor(tree, joint) for joint in ordered]), tuple(ordered)
    # Rotors on fixed joints, known by their links' names alone.
    links = [name for name in tree.links() if _ROTOR.fullmatch(name) and not tree.below(name)]
    return tuple(MappedRotor(link) for link in sorted(links, key=_number_in)), (None,) * len(links)


def _signed(tree: UrdfTree, rotors: list[MappedRotor]) -> tuple[MappedRotor, ...]:
    """The rotors, their spins known where axles point to both sides.

    The laboratory's `m_f_rate` is below zero where an axle along +z means a spin about +z.
    """
    if len({rotor.spin for rotor in rotors}) < 2:
        return tuple(replace(rotor, spin=None) for rotor in rotors)
    if number(tree.root.find("m_f_rate"), "value", -1.0) > 0.0:
        return tuple(replace(rotor, spin=rotor.spin and -rotor.spin) for rotor in rotors)
    return tuple(rotors)


def _spinning_rotor(tree: UrdfTree, joint: Element) -> MappedRotor:
    """Thrust along z of the link; where the axle is not along z, along the axle, to the side that is up."""
    axis = tree.axis(joint)
    size = float(np.linalg.norm(axis))
    link = tree.end(joint, "child") or ""
    if not np.isfinite(size) or size < 1e-9:
        return MappedRotor(link)
    axis = axis / size
    if abs(axis[2]) > 0.9:
        return MappedRotor(link, spin=1 if axis[2] > 0.0 else -1)
    up = float((pose_at_rest(tree, link)[1] @ axis)[2])
    if abs(up) < _LEVEL:
        return MappedRotor(link, rpy=rpy_of_z(axis))
    return MappedRotor(link, spin=1 if up > 0.0 else -1, rpy=rpy_of_z(axis if up > 0.0 else -axis))


def _arm(tree: UrdfTree, rotors: list[str]) -> list[str]:
    """Names of the joints of the longest chain that carries no rotor, one that is called an arm first.

    A single joint without such a name is no arm.
    """

    def may(joint: Element) -> bool:
        inside = tree.subtree(tree.end(joint, "child") or "")
        turns = joint.get("type") in _TURNS and joint.find("mimic") is None
        return turns and not _NO_ARM.search(joint.get("name", "")) and not inside.intersection(rotors)

    joints = [joint for joint in tree.moving() if may(joint)]
    chains = [
        [above.get("name", "") for above in tree.path_up(tree.end(joint, "child") or "") if above in joints]
        for joint in joints
    ]
    best = max(chains, key=lambda chain: (any(map(_ARM.search, chain)), len(chain)), default=[])
    return best if len(best) > 1 or any(map(_ARM.search, best)) else []


def _role(tree: UrdfTree, joint: Element, rotors: list[str], arm: list[str], doubts: list[Doubt]) -> Role:
    name = joint.get("name", "")
    if joint.find("mimic") is not None:
        remedy = "nothing, if the robot may fly with it held"
        doubts.append(Doubt(f"joint '{name}'", "mimics another; it is locked", remedy))
        return "locked"
    if _VECTORING.match(name):
        return "vectoring"
    if _SHAPE.match(name) or (name in arm and any(map(_ARM.search, arm))):
        return "shape"
    inside = tree.subtree(tree.end(joint, "child") or "")
    carried = [link for link in rotors if link in inside]
    others = _moving_below(tree, tree.end(joint, "child") or "")
    leads_on = any(_SHAPE.match(below.get("name", "")) for below in others)
    guess: Role = (
        "shape"
        if name in arm
        else "locked"
        if not carried
        else "vectoring"
        if len(carried) == 1 and not leads_on
        else "shape"
    )
    why = {
        "locked": "it carries no rotor",
        "vectoring": f"it carries one rotor, '{carried[0]}'" if carried else "",
        "shape": f"it carries {len(carried)} rotors" if carried else "it belongs to the longest arm",
    }[guess]
    doubts.append(
        Doubt(
            f"joint '{name}'",
            f"has no name that is known; taken as {guess}, as {why}",
            "if that is wrong, say its name and role under joints in a mapping file (--mapping)",
        )
    )
    return guess
