"""A URDF as a tree of XML that can be changed before it is read strictly."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from skylimb.base.errors import DescriptionError
from skylimb.base.rotations import rotation_from_rpy, rotation_from_vector
from skylimb.base.xml_text import read_xml

FIXED = "fixed"
INERTIA = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
"""Where the numbers of an <inertia> stand in its matrix."""

_ENDLESS = 2.0 * math.pi + 1e-6


class UrdfTree:
    """Links and joints of a URDF by name, and the few changes that an import makes.

    Attributes:
        root: the <robot> element.
        name: the robot's name.
    """

    def __init__(self, content: bytes, where: str) -> None:
        try:
            self.root = read_xml(content)
        except ValueError as error:
            raise DescriptionError(f"'{where}' is no XML: {' '.join(str(error).split())}") from None
        if self.root.tag != "robot":
            raise DescriptionError(
                f"'{where}' is no URDF: it begins with <{self.root.tag[:60]}>, not <robot>"
            )
        self.name = (self.root.get("name") or "robot").strip()
        self._where = where
        for joint in self.joints():
            for role in ("parent", "child"):
                if self.end(joint, role) is None:
                    raise DescriptionError(f"joint '{joint.get('name')}' in '{where}' has no {role} link")

    def joints(self) -> Iterator[Element]:
        """All <joint> elements of the robot (not those of a <transmission>)."""
        return iter(self.root.findall("joint"))

    def moving(self) -> list[Element]:
        """The joints that are not fixed, floating ones left out."""
        return [joint for joint in self.joints() if joint.get("type") not in (FIXED, "floating")]

    def link(self, name: str) -> Element | None:
        """The <link> of that name."""
        return next((link for link in self.root.findall("link") if link.get("name") == name), None)

    def links(self) -> list[str]:
        """Names of all links, as they stand in the file."""
        return [link.get("name", "") for link in self.root.findall("link")]

    def end(self, joint: Element, role: str) -> str | None:
        """The joint's parent or child link."""
        element = joint.find(role)
        return None if element is None else element.get("link")

    def above(self, link: str) -> Element | None:
        """The joint that leads to a link."""
        return next((joint for joint in self.joints() if self.end(joint, "child") == link), None)

    def below(self, link: str) -> list[Element]:
        """The joints that start at a link."""
        return [joint for joint in self.joints() if self.end(joint, "parent") == link]

    def path_up(self, link: str) -> Iterator[Element]:
        """The joints from a link up to the root, each once."""
        seen: set[str] = set()
        joint = self.above(link)
        while joint is not None:
            name = joint.get("name", "")
            if name in seen:
                return
            seen.add(name)
            yield joint
            joint = self.above(self.end(joint, "parent") or "")

    def subtree(self, link: str, fixed: bool = False) -> set[str]:
        """Names of the link and of all links below it, or of those that fixed joints hold to it."""
        found, open_ = {link}, [link]
        while open_:
            for joint in self.below(open_.pop()):
                child = self.end(joint, "child") or ""
                if child not in found and (not fixed or joint.get("type") == FIXED):
                    found.add(child)
                    open_.append(child)
        return found

    def base(self) -> str:
        """The first link that is no joint's child.

        Raises:
            DescriptionError: there is none.
        """
        children = {self.end(joint, "child") for joint in self.joints()}
        if not self.links():
            raise DescriptionError(f"'{self._where}' has no links; is it a part that other files include?")
        root = next((name for name in self.links() if name not in children), None)
        if root is None:
            raise DescriptionError(f"'{self._where}' has no root link: its joints form a loop")
        return root

    def mass(self, link: str) -> float:
        """Mass that the file says of a link, kg; 0 where it says none."""
        element = self.link(link)
        mass = None if element is None else element.find("inertial/mass")
        return number(mass, "value", 0.0)

    def total_mass(self) -> float:
        """Sum of all links' masses, kg."""
        return sum(self.mass(name) for name in self.links())

    def limit(self, joint: Element, key: str) -> float:
        """A number of the joint's <limit>, NaN where there is none."""
        return number(joint.find("limit"), key, math.nan)

    def axis(self, joint: Element) -> np.ndarray:
        """The joint's axis (3,), as URDF has it: x where none is given."""
        element = joint.find("axis")
        return np.array(triple(element, "xyz", (1.0, 0.0, 0.0)))

    def place(self, joint: Element) -> tuple[np.ndarray, np.ndarray]:
        """Origin (3,) in m and orientation (3, 3) of the child's frame in the parent's."""
        origin = joint.find("origin")
        xyz = np.array(triple(origin, "xyz", (0.0, 0.0, 0.0)))
        return xyz, rotation_from_rpy(*triple(origin, "rpy", (0.0, 0.0, 0.0)))

    def endless(self, joint: Element) -> bool:
        """Whether the joint turns without end, whatever it is called."""
        if joint.get("type") == "continuous":
            return True
        lower, upper = self.limit(joint, "lower"), self.limit(joint, "upper")
        return joint.get("type") == "revolute" and (lower < -_ENDLESS and upper > _ENDLESS)

    # What an import changes

    def rest(self, joint: Element, above: tuple[str, ...] = ()) -> float:
        """Where a joint rests, rad or m, within its limits: at zero, or where one that it mimics puts it."""
        limit, mimic, name = joint.find("limit"), joint.find("mimic"), joint.get("name", "")
        at = number(mimic, "offset", 0.0)
        master = None if mimic is None else mimic.get("joint")
        for other in self.joints():
            if other.get("name") == master and master not in (name, *above):
                at += number(mimic, "multiplier", 1.0) * self.rest(other, (*above, name))
        if joint.get("type") in ("revolute", "prismatic"):
            at = min(max(at, number(limit, "lower", at)), number(limit, "upper", at))
        return at

    def hold(self, joint: Element, at: float) -> None:
        """Make a joint fixed at an angle or way."""
        kind, axis = joint.get("type"), self.axis(joint)
        size = float(np.linalg.norm(axis))
        if at != 0.0 and kind in ("revolute", "continuous", "prismatic") and size > 0.0:
            xyz, R = self.place(joint)
            if kind == "prismatic":
                self._set_place(joint, xyz + at / size * R @ axis, R)
            else:
                self._set_place(joint, xyz, R @ rotation_from_vector(at / size * axis))
        self.fix(joint)

    def hold_stiff(self) -> None:
        """Make every joint fixed whose limits leave it no way."""
        for joint in self.joints():
            lower, upper = self.limit(joint, "lower"), self.limit(joint, "upper")
            if joint.get("type") in ("revolute", "prismatic") and lower == upper:
                self.hold(joint, lower)

    def fix(self, joint: Element) -> None:
        """Make a joint fixed, at its zero."""
        joint.set("type", FIXED)
        for tag in ("axis", "limit", "dynamics", "mimic", "safety_controller", "calibration"):
            for element in joint.findall(tag):
                joint.remove(element)

    def set_limit(self, joint: Element, key: str, value: float) -> None:
        """Write one number of the joint's <limit>."""
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit")
        limit.set(key, repr(value))

    def keep_robot_only(self) -> None:
        """Remove what is no link, joint or material, such as transmissions and tags of simulators."""
        for element in list(self.root):
            if element.tag not in ("link", "joint", "material"):
                self.root.remove(element)

    def plant_root(self, link: str) -> None:
        """Make a link the root whose parents, all on fixed joints, become leaves of it; nothing is lost."""
        for joint in list(self.path_up(link)):
            parent, child = self.end(joint, "parent") or "", self.end(joint, "child") or ""
            xyz, R = self.place(joint)
            self._set_place(joint, -R.T @ xyz, R.T)
            for role, name in (("parent", child), ("child", parent)):
                element = joint.find(role)
                assert element is not None  # checked when the tree was read
                element.set("link", name)

    def drop_empty_leaf(self, name: str) -> None:
        """Take out a link that weighs nothing, shows nothing and carries nothing, with the joint above it."""
        link, joint = self.link(name), self.above(name)
        if link is None or joint is None or self.below(name) or self.mass(name) > 0.0:
            return
        if link.find("visual") is None and link.find("collision") is None:
            self.root.remove(link)
            self.root.remove(joint)

    def _set_place(self, joint: Element, xyz: np.ndarray, R: np.ndarray) -> None:
        for element in joint.findall("origin"):
            joint.remove(element)
        joint.append(origin(xyz, R))

    def text(self) -> bytes:
        """The tree as a file's content."""
        root = copy.deepcopy(self.root)
        ElementTree.indent(root)
        return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def pose_at_rest(tree: UrdfTree, link: str) -> tuple[np.ndarray, np.ndarray]:
    """Origin (3,) in m and orientation (3, 3) of a link in the root's frame, joints at zero."""
    xyz, R = np.zeros(3), np.eye(3)
    for joint in tree.path_up(link):
        at, turned = tree.place(joint)
        xyz, R = at + turned @ xyz, turned @ R
    return xyz, R


def origin(xyz: np.ndarray, R: np.ndarray) -> Element:
    """An <origin> at a place (3,), m, with an orientation (3, 3)."""
    return Element("origin", {"xyz": _text(xyz), "rpy": _text(_rpy(R))})


def write_inertia(element: Element, inertia: np.ndarray) -> None:
    """Set the six numbers of an <inertia> to those of a matrix (3, 3), kg m^2."""
    for key, place in INERTIA.items():
        element.set(key, repr(float(inertia[place])))


def add_joint(
    robot: Element, name: str, kind: str, parent: str, child: str, xyz: np.ndarray, R: np.ndarray
) -> Element:
    """A <joint> added to a <robot>, at a place (3,), m, with an orientation (3, 3) in its parent."""
    joint = ElementTree.SubElement(robot, "joint", {"name": name, "type": kind})
    ElementTree.SubElement(joint, "parent", {"link": parent})
    ElementTree.SubElement(joint, "child", {"link": child})
    joint.append(origin(xyz, R))
    return joint


def number(element: Element | None, key: str, default: float) -> float:
    """An attribute as a number, `default` where it is none."""
    try:
        return float((element.get(key) if element is not None else None) or "")
    except ValueError:
        return default


def triple(element: Element | None, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
    """An attribute as three numbers, `default` where it is none."""
    text = None if element is None else element.get(key)
    try:
        values = tuple(float(word) for word in (text or "").split())
    except ValueError:
        return default
    return values if len(values) == 3 else default


def rpy_of_z(axis: np.ndarray) -> tuple[float, float, float]:
    """A roll and a pitch, rad, that turn z onto a unit axis (3,)."""
    x, y, z = (float(part) for part in axis)
    # The angles are extrinsic: R = Ry(pitch) Rx(roll).
    return math.asin(min(max(-y, -1.0), 1.0)), math.atan2(x, z), 0.0


def _text(values: np.ndarray) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)


def _rpy(R: np.ndarray) -> np.ndarray:
    """Roll, pitch and yaw of a rotation, rad."""
    pitch = math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    if abs(R[2, 0]) < 1.0 - 1e-12:
        return np.array([math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])])
    return np.array([math.atan2(-R[1, 2], R[1, 1]), pitch, 0.0])
