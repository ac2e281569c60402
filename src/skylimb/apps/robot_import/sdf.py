"""SDF as a URDF: links stand on the joints that lead to them, and motor plugins go along to say the rotors.

Poses may be relative to any link, joint or frame of the model; each is resolved once. A frame becomes a link
without mass. A capsule is drawn as the cylinder around it, an ellipsoid as its box.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from skylimb.apps.robot_import.sdf_include import ADDED, WHOLE, MergedModel
from skylimb.apps.robot_import.tree import INERTIA, add_joint, origin
from skylimb.base.errors import DescriptionError
from skylimb.base.rotations import rotation_from_rpy

_KINDS = ("revolute", "continuous", "prismatic", "fixed")
_ENDLESS = 1e15
"""Limits beyond this are none, as SDF has it; rad or m."""


def read_sdf(path: Path, folders: Sequence[Path] = ()) -> tuple[bytes, Mapping[str, Path]]:
    """The model of an SDF file as a URDF with its motor plugins.

    Args:
        path: the file.
        folders: where models that it includes lie, each in a folder of its name, beside those around the file
            and of GZ_SIM_RESOURCE_PATH.

    Returns:
        The URDF, and the folders of all models that were read, by name, as `package://NAME/...` means them.

    Raises:
        DescriptionError: no tree of links in one model, or an included one that is not found.
    """
    merged = MergedModel(path, folders)
    try:
        robot = _Written(merged).robot()
    except ValueError as error:
        raise DescriptionError(f"'{path.name}' cannot be read: {error}") from None
    return ElementTree.tostring(robot), merged.folders


class _Written:
    """One model, written as links and joints."""

    def __init__(self, merged: MergedModel) -> None:
        self._model = merged.model
        self._links, self._joints, self._frames = (
            _by_name(self._model, tag) for tag in ("link", "joint", "frame")
        )
        self._parts = {**self._links, **self._joints, **self._frames}
        self._placed = dict[str, np.ndarray]()
        self._above = dict[str, Element]()
        for joint in self._joints.values():
            if _text(joint, "parent") != "world":  # a stand, which does not fly
                self._above[self._holder(_text(joint, "child"))] = joint

    def robot(self) -> Element:
        """The <robot> element.

        Raises:
            ValueError: something that is no robot, by name.
        """
        robot = Element("robot", {"name": self._model.get("name") or "robot"})
        roots = [name for name in self._links if name not in self._above]
        if len(roots) != 1:
            raise ValueError(
                f"one link is needed that no joint leads to; found: {', '.join(roots) or 'none'}"
            )
        for name, link in self._links.items():
            robot.append(self._link(name, link))
        for child, joint in self._above.items():
            self._joint(robot, child, joint)
        for name, frame in self._frames.items():
            if ADDED not in frame.attrib:
                held = self._holder(name)
                SubElement(robot, "link", {"name": name})
                add_joint(robot, f"{name}_fixed", "fixed", held, name, *self._seen(self._place(name), held))
        SubElement(robot, "gazebo").extend(self._model.findall("plugin"))
        return robot

    def _link(self, name: str, link: Element) -> Element:
        written = Element("link", {"name": name})
        own = self._place(name)
        inertial = link.find("inertial")
        if inertial is not None and inertial.get("auto") in ("true", "1"):
            raise ValueError(
                f"link '{name}' leaves its mass to the simulator (auto); write <mass> and <inertia>"
            )
        inertia = None if inertial is None else inertial.find("inertia")
        # SDF assumes 1 kg and 1 kg m^2 where nothing is said.
        values = {key: repr(_number(inertia, key, float(i == j))) for key, (i, j) in INERTIA.items()}
        body = SubElement(written, "inertial")
        body.append(origin(*self._seen(own @ _pose(inertial), name)))
        SubElement(body, "mass", {"value": repr(_number(inertial, "mass", 1.0))})
        SubElement(body, "inertia", values)
        for tag in ("visual", "collision"):
            for shape in link.findall(tag):
                for kind, said in _shapes(shape.find("geometry")):
                    shown = SubElement(written, tag)
                    shown.append(origin(*self._seen(own @ _pose(shape), name)))
                    SubElement(SubElement(shown, "geometry"), kind, said)
        return written

    def _joint(self, robot: Element, child: str, joint: Element) -> None:
        name, kind = joint.get("name", ""), joint.get("type", "")
        if kind not in _KINDS:
            raise ValueError(f"joint '{name}' is {kind or 'of no kind'}; read are {', '.join(_KINDS)}")
        at, parent = self._place(name), self._holder(_text(joint, "parent"))
        written = add_joint(robot, name, kind, parent, child, *self._seen(at, parent))
        axis = joint.find("axis")
        if axis is None or kind == "fixed":
            return
        direction = axis.find("xyz")
        turned = np.array(_numbers(None if direction is None else direction.text, 3) or (0.0, 0.0, 1.0))
        seen_from = None if direction is None else direction.get("expressed_in")
        if seen_from:
            turned = at[:3, :3].T @ self._place(seen_from)[:3, :3] @ turned
        SubElement(written, "axis", {"xyz": " ".join(repr(float(value)) for value in turned)})
        _move(written, axis)

    def _place(self, name: str, above: tuple[str, ...] = ()) -> np.ndarray:
        """Pose (4, 4) of a link, joint or frame in the model's frame."""
        if name == WHOLE:
            return np.eye(4)
        part = self._parts.get(name)
        if part is None or name in above:
            raise ValueError(f"something is placed from '{name}', which is not there or placed from itself")
        if name not in self._placed:
            pose = part.find("pose")
            implied = {"joint": _text(part, "child"), "frame": part.get("attached_to")}.get(part.tag)
            seen_from = (None if pose is None else pose.get("relative_to")) or implied or WHOLE
            self._placed[name] = self._place(seen_from, (name, *above)) @ _pose(part)
        return self._placed[name]

    def _seen(self, pose: np.ndarray, link: str) -> tuple[np.ndarray, np.ndarray]:
        """Place (3,) and orientation (3, 3) of a pose as seen from a link, which stands on its joint."""
        above = self._above.get(link)
        H = np.linalg.inv(self._place(link if above is None else above.get("name", ""))) @ pose
        return H[:3, 3], H[:3, :3]

    def _holder(self, name: str, above: tuple[str, ...] = ()) -> str:
        """The link that a name means: itself, or the one that the frame or joint of that name is on."""
        if name in self._links:
            return name
        if name == WHOLE:
            return self._model.get("canonical_link") or next(iter(self._links), "")
        part = self._parts.get(name)
        if part is None or name in above:
            raise ValueError(f"a joint or a frame is on '{name}', which is not there or on itself")
        on = _text(part, "child") if part.tag == "joint" else part.get("attached_to") or WHOLE
        return self._holder(on, (name, *above))


def _move(joint: Element, axis: Element) -> None:
    """How far, how fast and against what a URDF's joint moves, by the <axis> of SDF."""
    limit, dynamics, mimic = axis.find("limit"), axis.find("dynamics"), axis.find("mimic")
    ends = {"lower": _number(limit, "lower", -np.inf), "upper": _number(limit, "upper", np.inf)}
    if all(abs(end) > _ENDLESS for end in ends.values()):
        ends = {}
        if joint.get("type") == "revolute":
            joint.set("type", "continuous")
    most = {key: _number(limit, key, -1.0) for key in ("effort", "velocity")}
    said = {**ends, **{key: value for key, value in most.items() if value > 0.0 and isfinite(value)}}
    SubElement(joint, "limit", {key: repr(value) for key, value in said.items()})
    lost = {key: repr(_number(dynamics, key, 0.0)) for key in ("damping", "friction")}
    SubElement(joint, "dynamics", lost)
    if mimic is not None:
        times = _number(mimic, "multiplier", 1.0)
        offset = _number(mimic, "offset", 0.0) - times * _number(mimic, "reference", 0.0)
        other = {"joint": mimic.get("joint", ""), "multiplier": repr(times), "offset": repr(offset)}
        SubElement(joint, "mimic", other)


def _by_name(model: Element, tag: str) -> dict[str, Element]:
    found = dict[str, Element]()
    for element in model.findall(tag):
        name = element.get("name", "")
        if not name or name in found:
            raise ValueError(f"a <{tag}> has no name, or '{name}' stands twice")
        found[name] = element
    return found


def _pose(element: Element | None) -> np.ndarray:
    """An element's own <pose> (4, 4), wherever it is seen from."""
    H, pose = np.eye(4), None if element is None else element.find("pose")
    if pose is None:
        return H
    if pose.get("rotation_format", "euler_rpy") != "euler_rpy":
        raise ValueError("a <pose> is a quaternion; roll, pitch and yaw are read")
    values = _numbers(pose.text, 6)
    if values:
        turns = np.array(values[3:])
        H[:3, :3] = rotation_from_rpy(*(np.deg2rad(turns) if pose.get("degrees") in ("true", "1") else turns))
        H[:3, 3] = values[:3]
    return H


def _shapes(geometry: Element | None) -> Iterator[tuple[str, dict[str, str]]]:
    """Tag and sizes of a geometry that is drawn."""
    for shape in () if geometry is None else geometry:
        if shape.tag == "box":
            yield "box", {"size": _sizes(shape, "size")}
        elif shape.tag == "ellipsoid":
            yield "box", {"size": _sizes(shape, "radii", 2.0)}
        elif shape.tag == "sphere":
            yield "sphere", {"radius": repr(_number(shape, "radius", 1.0))}
        elif shape.tag in ("cylinder", "capsule"):
            radius, length = _number(shape, "radius", 0.5), _number(shape, "length", 1.0)
            length += 2.0 * radius * (shape.tag == "capsule")
            yield "cylinder", {"radius": repr(radius), "length": repr(length)}
        elif shape.tag == "mesh":
            name = _text(shape, "uri").replace("model://", "package://")
            yield "mesh", {"filename": name, "scale": _sizes(shape, "scale")}


def _sizes(shape: Element, tag: str, factor: float = 1.0) -> str:
    values = _numbers(shape.findtext(tag), 3) or (1.0, 1.0, 1.0)
    return " ".join(repr(factor * value) for value in values)


def _text(element: Element, tag: str) -> str:
    return (element.findtext(tag) or "").strip()


def _numbers(text: str | None, count: int) -> tuple[float, ...]:
    """The numbers of a text; none where it is empty."""
    values = tuple(float(word) for word in (text or "").split())
    if len(values) not in (0, count):
        raise ValueError(f"{count} numbers are needed, not {(text or '').strip()[:60]!r}")
    return values


def _number(element: Element | None, tag: str, default: float) -> float:
    """The number in a child, or in an attribute of that name."""
    said = "" if element is None else element.findtext(tag) or element.get(tag) or ""
    try:
        return float(said) if said.strip() else default
    except ValueError:
        raise ValueError(f"<{tag}> is no number: {said.strip()[:60]!r}") from None
