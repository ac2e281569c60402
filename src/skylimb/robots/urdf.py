"""Links and joints of a URDF; meshes are named, not loaded.

A mesh that is not there, or of a kind that the physics engine does not draw, is left out with a warning: no
flight hangs on a picture.
"""

from __future__ import annotations

import logging
import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from skylimb.base.errors import DescriptionError, unknown_name
from skylimb.base.rotations import rotation_from_rpy
from skylimb.base.sources import Source
from skylimb.base.xml_text import read_xml
from skylimb.robots.description import Inertial, Joint, Link, Visual
from skylimb.robots.packages import find_file

Tree = tuple[str, tuple[Link, ...], tuple[Joint, ...]]
"""The root link's name, all links (parents first) and all joints."""

_KINDS = ("revolute", "continuous", "fixed")
_GREY = (0.6, 0.6, 0.6, 1.0)
DRAWN = (".stl", ".obj", ".msh")
"""Endings of the meshes that the physics engine draws."""
_DUST = 1e-3
"""Mass of a root link that stands for nothing, kg."""
INERTIA = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
"""Where the attributes of an <inertia> stand in the matrix."""
INERTIA = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
"""Where the attributes of an <inertia> stand in the matrix."""
INERTIA = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
"""Where the attributes of an <inertia> stand in the matrix."""
_log = logging.getLogger(__name__)


def read_urdf(source: Source, root_link: str | None = None) -> Tree:
    """What stands in a URDF.

    Args:
        source: the file as it was read.
        root_link: leave out what stands above this link, which must be massless; None keeps all.

    Raises:
        DescriptionError: the file is not a URDF, or its links and joints do not form one
            tree; or a link with mass stands above `root_link`.
        UnknownNameError: a joint, or `root_link`, names a link that is not there.
    """
    path = source.path
    robot = robot_element(source.content, str(path))
    links, joints = robot.findall("link"), robot.findall("joint")
    if root_link is not None:
        links, joints = _cut_above(root_link, links, joints, path)
    colours = {material.get("name"): material.find("color") for material in robot.findall("material")}
    read = [_link(link, colours, path) for link in links]
    turned = [_joint(joint, path) for joint in joints]
    _require_unique("link", [link.name for link in read], path)
    _require_unique("joint", [joint.name for joint in turned], path)
    return _sorted_tree({link.name: link for link in read}, turned, path)


def robot_element(content: bytes, where: str) -> Element:
    """The <robot> of a URDF's text; `where` is what messages call it.

    Raises:
        DescriptionError: it is none.
    """
    try:
        root = read_xml(content)
    except ValueError as error:
        raise DescriptionError(f"'{where}' is no XML: {' '.join(str(error).split())}") from None
    if root.tag != "robot":
        raise DescriptionError(f"'{where}' is no URDF: it begins with <{root.tag[:60]}>, not <robot>")
    return root


def word(element: Element | None, key: str, where: str) -> str:
    """An attribute that has to be there; `where` is what messages call the element."""
    said = None if element is None else element.get(key)
    if said is None:
        raise DescriptionError(f"{where} has no {key}")
    return said


def number(element: Element | None, key: str, where: str, default: float) -> float:
    """A number of any size; `default` where none is said."""
    said = None if element is None else element.get(key)
    try:
        return default if said is None else float(said)
    except ValueError:
        raise DescriptionError(f"{key} of {where} is '{str(said)[:60]}', which is no number") from None


def numbers(
    element: Element | None, key: str, where: str, default: str = "0 0 0", counts: Collection[int] = (3,)
) -> np.ndarray:
    """Finite numbers, as many as may be; those of `default` where none are said."""
    said = default if element is None else element.get(key, default)
    try:
        values = np.array(said.replace(",", " ").split(), dtype=float)
    except ValueError:
        values = np.full(1, np.nan)
    if values.size not in counts or not np.isfinite(values).all():
        allowed = " or ".join(map(str, counts))
        raise DescriptionError(f"{key} of {where} is '{said[:60]}'; allowed are {allowed} finite numbers")
    return values


def origin(owner: Element, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Place (3,) in m and orientation (3, 3) that the <origin> of an element says."""
    place, what = owner.find("origin"), f"the origin of {where}"
    xyz, angles = numbers(place, "xyz", what), numbers(place, "rpy", what)
    if np.any(np.abs(angles) > 2.0 * math.pi):  # it would become a plausible rotation
        raise DescriptionError(f"rpy of {where} is {angles.tolist()} rad, more than a turn; is it degrees?")
    return xyz, clean_rotation(rotation_from_rpy(*angles))


def _cut_above(
    root_link: str, links: Sequence[Element], joints: Sequence[Element], path: Path
) -> tuple[list[Element], list[Element]]:
    """Links and joints without those above `root_link`, before joints are read: these may be of any type.

    Some descriptions have a root of a few milligrams, because a reader of theirs wants every link to weigh
    something. Such a one counts as massless.
    """
    names = [link.get("name", "") for link in links]
    if root_link not in names:
        raise unknown_name(f"root_link in '{path.name}'", root_link, names)
    roles = "parent", "child"
    ends = [[word(joint.find(role), "link", f"the {role} of a joint") for role in roles] for joint in joints]
    above = {child: parent for parent, child in ends}
    cut: list[str] = []
    at = root_link
    while at in above and above[at] not in cut:
        at = above[at]
        cut.append(at)
    for name, link in zip(names, links, strict=True):
        mass = number(link.find("inertial/mass"), "value", f"link '{name}'", 0.0)
        if name in cut and mass > _DUST:
            raise DescriptionError(
                f"root_link = '{root_link}' would drop link '{name}' ({mass:g} kg) of '{path.name}'; only "
                "massless links may stand above it"
            )
    return (
        [link for name, link in zip(names, links, strict=True) if name not in cut],
        [joint for (_, child), joint in zip(ends, joints, strict=True) if child not in (root_link, *cut)],
    )


def clean_rotation(R: np.ndarray) -> np.ndarray:
    """A rotation with entries within 1e-14 of -1, 0 or 1 made exact.

    sin(pi) in floating point is 1e-16, not 0, and would otherwise keep terms alive in every symbolic
    expression.
    """
    R = np.array(R, dtype=float)
    near = np.abs(R - np.round(R)) < 1e-14
    R[near] = np.round(R[near])
    return R + 0.0


def _link(link: Element, colours: Mapping[str | None, Element | None], path: Path) -> Link:
    name = word(link, "name", f"a link in '{path.name}'")
    where = f"link '{name}' in '{path.name}'"
    visuals = (
        _shape(one, _colour(one.find("material"), colours, where), where, path)
        for one in link.findall("visual")
    )
    collisions = (_shape(one, _GREY, where, path) for one in link.findall("collision"))
    return Link(name, _inertial(link, where), tuple(filter(None, visuals)), tuple(filter(None, collisions)))


def _inertial(link: Element, where: str) -> Inertial:
    said = link.find("inertial")
    if said is None:
        return Inertial()
    mass, moments = said.find("mass"), said.find("inertia")
    if mass is None or moments is None:
        raise DescriptionError(f"{where} has an <inertial> without <mass> or <inertia>")
    xyz, R = origin(said, f"the inertia of {where}")
    inertia = inertia_in(moments, where)
    weight = number(mass, "value", f"the mass of {where}", 0.0)
    for what, value in (("mass", weight), ("inertia", inertia)):
        if not np.isfinite(value).all():
            shown = " ".join(str(value).split())
            raise DescriptionError(f"the {what} of {where} is {shown}; only finite numbers are allowed")
    return Inertial(weight, xyz, R @ inertia @ R.T)


def inertia_in(element: Element, where: str) -> np.ndarray:
    """The matrix (3, 3) of an <inertia>, kg m^2, in its own axes."""
    inertia = np.eye(3)
    for key, (i, j) in INERTIA.items():
        inertia[i, j] = inertia[j, i] = number(element, key, f"the inertia of {where}", float(i == j))
    return inertia


def _shape(
    element: Element, rgba: tuple[float, float, float, float], where: str, path: Path
) -> Visual | None:
    """The shape of a <visual> or <collision>; None for a mesh that cannot be drawn."""
    geometry, mesh, what = element.find("geometry"), None, f"a shape of {where}"
    if geometry is None:
        raise DescriptionError(f"{where} has a <visual> or <collision> without <geometry>")
    form = next(iter(geometry), geometry)
    if form.tag == "box":
        shape, size = "box", numbers(form, "size", what, "")
    elif form.tag == "cylinder":
        shape, size = (
            "cylinder",
            np.hstack([numbers(form, key, what, "", (1,)) for key in ("radius", "length")]),
        )
    elif form.tag == "sphere":
        shape, size = "sphere", numbers(form, "radius", what, "", (1,))
    elif form.tag == "mesh":
        name = word(form, "filename", what)
        shape, mesh = "mesh", find_file(name, path.parent)
        if mesh is None or mesh.suffix.lower() not in DRAWN:
            reason = "is not there" if mesh is None else f"is none of {', '.join(DRAWN)}"
            _log.warning("%s is drawn without mesh '%s', which %s", where, name, reason)
            return None
        size = np.broadcast_to(numbers(form, "scale", what, "1", (1, 3)), 3)
    else:
        raise DescriptionError(f"{where} has a <geometry> that is no shape")
    return Visual(shape, tuple(map(float, size)), *origin(element, what), rgba, mesh)


def _colour(
    material: Element | None, colours: Mapping[str | None, Element | None], where: str
) -> tuple[float, float, float, float]:
    if material is None:
        return _GREY
    said = material.find("color")
    said = colours.get(material.get("name")) if said is None else said
    rgba = () if said is None else numbers(said, "rgba", where, "1 1 1 1", range(9))
    return tuple(map(float, rgba)) if len(rgba) == 4 else _GREY  # type: ignore[return-value]


def _joint(joint: Element, path: Path) -> Joint:
    name = word(joint, "name", f"a joint in '{path.name}'")
    where, kind = f"joint '{name}' in '{path.name}'", joint.get("type")
    parent, child = (word(joint.find(role), "link", f"the {role} of {where}") for role in ("parent", "child"))
    if kind not in _KINDS:
        hint = f'; the robot flies free anyway: say root_link = "{child}"' if kind == "floating" else ""
        raise DescriptionError(f"{where} is of type '{kind}'; allowed are {', '.join(_KINDS)}{hint}")
    mimic = joint.find("mimic")
    if mimic is not None:
        raise DescriptionError(f"{where} mimics '{mimic.get('joint')}'; mimic joints are not supported")
    axis = numbers(joint.find("axis"), "xyz", f"the axis of {where}", "1 0 0")
    length = float(np.linalg.norm(axis))
    if length < 1e-9:
        raise DescriptionError(f"{where} has the axis {axis}; it needs a direction")
    limit, dynamics, bounded = joint.find("limit"), joint.find("dynamics"), kind == "revolute"
    if bounded and (limit is None or not {"lower", "upper"} <= {*limit.keys()}):
        raise DescriptionError(
            f"{where} is revolute without <limit lower=... upper=...>; give them or make it continuous"
        )
    xyz, R = origin(joint, where)
    return Joint(
        name=name,
        kind=kind,  # type: ignore[arg-type]
        parent=parent,
        child=child,
        xyz=xyz,
        R=R,
        axis=clean_rotation(axis / length),
        lower=number(limit, "lower", where, math.nan) if bounded else -math.inf,
        upper=number(limit, "upper", where, math.nan) if bounded else math.inf,
        effort=number(limit, "effort", where, math.inf),
        speed=number(limit, "velocity", where, math.inf),
        damping=number(dynamics, "damping", where, 0.0),
        friction=number(dynamics, "friction", where, 0.0),
    )


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
