"""Links and joints of a URDF, read with yourdfpy; meshes are named, not loaded.

A mesh that is not there, or of a kind that the physics engine does not draw, is left out with a warning: no
flight hangs on a picture.
"""

from __future__ import annotations

import io
import logging
import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from skylimb.base.errors import DescriptionError, missing_extra, unknown_name
from skylimb.base.sources import Source
from skylimb.base.xml_text import read_xml
from skylimb.robots.links import Inertial, Joint, Link, Visual
from skylimb.robots.packages import find_file
from skylimb.robots.urdf_numbers import odd_number

_KINDS = ("revolute", "continuous", "fixed")
_GREY = (0.6, 0.6, 0.6, 1.0)
DRAWN = (".stl", ".obj", ".msh")
"""Endings of the meshes that the physics engine draws."""
_SIZES = {"box": 3, "cylinder": 2, "sphere": 1}
_LONGEST = 1e3
"""A shape's length stays below, m."""
_LARGEST = 1e6
"""Greatest number of a place, a mass or an inertia, m, kg, kg m^2: beyond any robot."""
_DUST = 1e-3
"""Mass of a root link that stands for nothing, kg."""
_log = logging.getLogger(__name__)


def read_urdf(
    source: Source, root_link: str | None = None
) -> tuple[str, tuple[Link, ...], tuple[Joint, ...]]:
    """The root link's name, all links (parents first) and all joints of a URDF.

    Args:
        source: the file as it was read.
        root_link: leave out what stands above this link, which must be massless; None keeps all.

    Raises:
        DescriptionError: the file is not a URDF, or its links and joints do not form one
            tree; or a link with mass stands above `root_link`.
        UnknownNameError: a joint, or `root_link`, names a link that is not there.
    """
    path = source.path
    robot = _parse(source)
    if root_link is not None:
        _cut_above(root_link, robot, path)
    links = {link.name: _link(link, robot.materials, path) for link in robot.links}
    joints = [_joint(joint, path) for joint in robot.joints]
    _require_unique("link", [link.name for link in robot.links], path)
    _require_unique("joint", [joint.name for joint in joints], path)
    return _sorted_tree(links, joints, path)


def _parse(source: Source) -> Any:
    content, path = source.content, source.path
    try:
        from yourdfpy import URDF
    except ImportError:
        raise DescriptionError(f"'{path}' has not been read yet: {missing_extra('yourdfpy')}") from None
    root = None
    try:
        root = read_xml(content)
        urdf = URDF.load(io.BytesIO(content), build_scene_graph=False, load_meshes=False)
    except Exception as error:  # yourdfpy and lxml let many kinds through: all of them mean "not a URDF"
        reason = "" if root is None else odd_number(root)
        reason = reason or " ".join(str(error).split()) or type(error).__name__
        raise DescriptionError(f"'{path}' is not a URDF that can be read: {reason}") from error
    _refuse_degrees(root, path)
    return urdf.robot


def _refuse_degrees(root: Element, path: Path) -> None:
    """Refuse angles of more than a turn, which become plausible rotation matrices once they are read."""
    for owner in root.iter():
        for origin in owner.findall("origin"):
            angles = [float(angle) for angle in origin.get("rpy", "0 0 0").split()]
            if any(abs(angle) > 2.0 * math.pi for angle in angles):
                tag = f'<{owner.tag} name="{owner.get("name", "")}">'
                raise DescriptionError(
                    f"rpy of {tag} in '{path.name}' is {angles} rad, more than a turn; is it degrees?"
                )


def _cut_above(root_link: str, robot: Any, path: Path) -> None:
    """Remove links and joints above `root_link`, before joints are read: those may be of any type.

    Some descriptions have a root of a few milligrams, because a reader of theirs wants every link to weigh
    something. Such a one counts as massless.
    """
    names = [link.name for link in robot.links]
    if root_link not in names:
        raise unknown_name(f"root_link in '{path.name}'", root_link, names)
    above = {joint.child: joint.parent for joint in robot.joints}
    cut: list[str] = []
    at = root_link
    while at in above and above[at] not in cut:
        at = above[at]
        cut.append(at)
    for link in robot.links:
        if link.name in cut and link.inertial is not None and (link.inertial.mass or 0.0) > _DUST:
            raise DescriptionError(
                f"root_link = '{root_link}' would drop link '{link.name}' ({link.inertial.mass:g} kg) of "
                f"'{path.name}'; only massless links may stand above it"
            )
    robot.links = [link for link in robot.links if link.name not in cut]
    robot.joints = [joint for joint in robot.joints if joint.child != root_link and joint.child not in cut]


def _moderate(value: Any, what: str, path: Path) -> Any:
    entries = np.ravel(value)
    wrong = entries[~(np.abs(entries) <= _LARGEST)]  # so that nan is wrong, too
    if wrong.size:
        raise DescriptionError(
            f"{what} in '{path.name}' has {wrong[0]:g}; only finite numbers up to {_LARGEST:g} are allowed"
        )
    return value


def clean_rotation(R: np.ndarray) -> np.ndarray:
    """A rotation with entries within 1e-14 of -1, 0 or 1 made exact.

    sin(pi) in floating point is 1e-16, not 0, and would otherwise keep terms alive in every symbolic
    expression.
    """
    R = np.array(R, dtype=float)
    near = np.abs(R - np.round(R)) < 1e-14
    R[near] = np.round(R[near])
    return R + 0.0


def _origin(origin: np.ndarray | None, what: str, path: Path) -> tuple[np.ndarray, np.ndarray]:
    if origin is None:
        return np.zeros(3), np.eye(3)
    _moderate(origin, f"the origin of {what}", path)
    return np.array(origin[:3, 3]), clean_rotation(origin[:3, :3])


def _link(link: Any, materials: Iterable[Any], path: Path) -> Link:
    what = f"link '{link.name}'"
    inertial = Inertial()
    if link.inertial is not None:
        if link.inertial.mass is None or link.inertial.inertia is None:
            raise DescriptionError(f"{what} in '{path.name}' has an <inertial> without <mass> or <inertia>")
        xyz, R = _origin(link.inertial.origin, f"the inertia of {what}", path)
        inertia = _moderate(link.inertial.inertia, f"the inertia of {what}", path)
        mass = _moderate(link.inertial.mass, f"the mass of {what}", path)
        inertial = Inertial(float(mass), xyz, R @ inertia @ R.T)
    visuals = (_shape(one, _colour(one.material, materials), what, path) for one in link.visuals)
    collisions = (_shape(one, _GREY, what, path) for one in link.collisions)
    return Link(link.name, inertial, tuple(filter(None, visuals)), tuple(filter(None, collisions)))


def _shape(element: Any, rgba: tuple[float, float, float, float], what: str, path: Path) -> Visual | None:
    """The shape of a <visual> or <collision>; None for a mesh that cannot be drawn."""
    geometry, mesh = element.geometry, None
    if geometry is None:
        raise DescriptionError(f"{what} in '{path.name}' has a <visual> or <collision> without <geometry>")
    xyz, R = _origin(element.origin, f"a shape of {what}", path)
    if geometry.box is not None:
        shape, size = "box", tuple(float(edge) for edge in geometry.box.size)
    elif geometry.cylinder is not None:
        shape, size = "cylinder", (float(geometry.cylinder.radius), float(geometry.cylinder.length))
    elif geometry.sphere is not None:
        shape, size = "sphere", (float(geometry.sphere.radius),)
    else:
        if geometry.mesh is None:
            raise DescriptionError(f"{what} in '{path.name}' has a <geometry> that is no shape")
        shape, mesh = "mesh", find_file(geometry.mesh.filename, path.parent)
        if mesh is None or mesh.suffix.lower() not in DRAWN:
            kinds = ", ".join(DRAWN)
            reason = "is not there" if mesh is None else f"is none of {kinds}"
            _log.warning("%s is drawn without mesh '%s', which %s", what, geometry.mesh.filename, reason)
            return None
        scale = 1.0 if geometry.mesh.scale is None else geometry.mesh.scale
        size = tuple(float(factor) for factor in np.broadcast_to(scale, 3))
    if mesh is None and not (len(size) == _SIZES[shape] and all(0.0 < length < _LONGEST for length in size)):
        lengths = ", ".join(f"{length:g}" for length in size)
        raise DescriptionError(
            f"{what} in '{path.name}' has a {shape} of {lengths} m; every length must be positive, below 1 km"
        )
    return Visual(shape, size, xyz, R, rgba, mesh)


def _colour(material: Any, materials: Iterable[Any]) -> tuple[float, float, float, float]:
    if material is None:
        return _GREY
    named = [other for other in materials if other.name == material.name]
    colour = next((entry.color for entry in [material, *named] if entry.color is not None), None)
    if colour is None or len(colour.rgba) != 4:
        return _GREY
    red, green, blue, alpha = (float(channel) for channel in colour.rgba)
    return (red, green, blue, alpha)


def _joint(joint: Any, path: Path) -> Joint:
    what = f"joint '{joint.name}' in '{path.name}'"
    if joint.type not in _KINDS:
        hint = (
            f'; the robot flies free anyway: say root_link = "{joint.child}"'
            if joint.type == "floating"
            else ""
        )
        raise DescriptionError(f"{what} is of type '{joint.type}'; allowed are {', '.join(_KINDS)}{hint}")
    if joint.mimic is not None:
        raise DescriptionError(f"{what} mimics '{joint.mimic.joint}'; mimic joints are not supported")
    xyz, R = _origin(joint.origin, what, path)
    axis = np.array([1.0, 0.0, 0.0])
    if joint.axis is not None and joint.type != "fixed":  # some files write 0 0 0 where nothing turns
        axis = _moderate(joint.axis, f"the axis of {what}", path)
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        raise DescriptionError(f"{what} has the axis {axis}; it needs a direction")
    limit, dynamics = joint.limit, joint.dynamics
    if joint.type == "revolute" and (limit is None or limit.lower is None or limit.upper is None):
        raise DescriptionError(
            f"{what} is revolute without <limit lower=... upper=...>; give them or make it continuous"
        )
    bounded = joint.type == "revolute"
    return Joint(
        name=joint.name,
        kind=joint.type,
        parent=joint.parent,
        child=joint.child,
        xyz=xyz,
        R=R,
        axis=clean_rotation(axis / length),
        lower=float(limit.lower) if bounded else -math.inf,
        upper=float(limit.upper) if bounded else math.inf,
        effort=_or(limit and limit.effort, math.inf),
        speed=_or(limit and limit.velocity, math.inf),
        damping=_or(dynamics and dynamics.damping, 0.0),
        friction=_or(dynamics and dynamics.friction, 0.0),
    )


def _or(value: float | None, default: float) -> float:
    try:
        return default if value is None else float(value)
    except (TypeError, ValueError):
        raise DescriptionError(f"'{str(value)[:60]}' of a joint is no number") from None


def _require_unique(kind: str, names: list[str], path: Path) -> None:
    for name, count in Counter(names).items():
        if count > 1:
            raise DescriptionError(
                f"{kind} '{name}' stands {count} times in '{path.name}'; names must be unique"
            )


def _sorted_tree(
    links: dict[str, Link], joints: list[Joint], path: Path
) -> tuple[str, tuple[Link, ...], tuple[Joint, ...]]:
    for joint in joints:
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                raise unknown_name(f"{role} link of joint '{joint.name}' in '{path.name}'", name, links)
    children = Counter(joint.child for joint in joints)
    twice = next((name for name, count in children.items() if count > 1), None)
    if twice is not None:
        raise DescriptionError(
            f"link '{twice}' in '{path.name}' is the child of {children[twice]} joints; it can have one"
        )
    roots = [name for name in links if name not in children]
    if len(roots) != 1:
        found = ", ".join(roots) or "none, the joints form a loop"
        raise DescriptionError(
            f"'{path.name}' needs exactly one root link (that is no joint's child); found: {found}"
        )
    names, ordered = [roots[0]], []
    for name in names:
        below = [joint for joint in joints if joint.parent == name]
        ordered += below
        names += [joint.child for joint in below]
    if len(names) != len(links):
        lost = ", ".join(sorted(set(links) - set(names)))
        raise DescriptionError(f"links in a loop, not joined to root '{roots[0]}' of '{path.name}': {lost}")
    return roots[0], tuple(links[name] for name in names), tuple(ordered)
