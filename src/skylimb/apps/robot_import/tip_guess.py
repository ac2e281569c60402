"""Where the tip of a robot probably is: the farthest end of what is drawn or joined at its last link."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np

from skylimb.apps.robot_import.doubts import Doubt
from skylimb.apps.robot_import.roles import Roles
from skylimb.apps.robot_import.tree import UrdfTree, number, pose_at_rest, triple
from skylimb.robots.flight_file import TipSection

_RADIUS = 0.01
_STICK = 0.15
"""How far an assumed tip stands out beyond the rotors of a robot without bending joints, m."""
_BEYOND = 0.05
"""How far an end has to be beyond the rotors' middles of such a robot to be taken for its tip, m."""
_TOOL = re.compile(r"(tool|tcp|tip|ee|eef|end_?effector|pen|probe)(_?(link|frame|tip))?_?0?$", re.IGNORECASE)
"""Names of the frames at the end of an arm."""
_LONG = 0.03
"""How far a tool is drawn beyond its frame to end there, m."""
_LARGEST = 0.05
"""Greatest radius of a drawn sphere that is taken for the ball of a tip, m."""

End = tuple[np.ndarray, float]
"""A point (3,), m, and the radius of the ball about it, m; 0 where there is none."""


def guess_tip(tree: UrdfTree, roles: Roles, doubts: list[Doubt]) -> TipSection:
    """The end of the last link of the longest chain; of a robot that does not bend, that of its stick or arm.

    Ends are origins of links that are fixed to that link, and ends of cylinders, faces of boxes and spheres
    that draw them; a frame that is called tool or tip comes first. Where none is far enough out, a
    chain ends as far behind its last joint as that is behind the one before it, and a robot that does not
    bend gets a stick in front of its rotors.
    """
    names = {joint.get("name") for joint in roles.shape}
    links = [tree.end(joint, "child") or "" for joint in roles.shape]
    if links:
        depth = {link: sum(j.get("name") in names for j in tree.path_up(link)) for link in links}
        last = max(links, key=lambda link: (depth[link], link))
        ends = [tree.place(joint)[0] for joint in tree.path_up(last) if joint.get("name") in names]
        length = max((float(np.linalg.norm(xyz)) for xyz in ends), default=0.0) or 0.3
        assumed, beyond = TipSection(last, (round(length, 4), 0.0, 0.0), _RADIUS), length
    else:
        last = tree.base()
        places = [pose_at_rest(tree, rotor.link)[0] for rotor in roles.rotors]
        reach = max((float(np.linalg.norm(place[:2])) for place in places), default=0.3)
        beyond = max((float(np.linalg.norm(place)) for place in places), default=0.3) + _BEYOND
        assumed = TipSection(last, (round(reach + _STICK, 4), 0.0, 0.0), _RADIUS, (0.0, 0.0, 0.0))
    rotors = {rotor.link for rotor in roles.rotors}
    named = [link for link in tree.subtree(last, fixed=True) if _TOOL.search(link) and not tree.below(link)]
    if len(named) == 1 and (links or _bare(tree.link(named[0]))):
        end = _drawn_end(tree, last, named[0])
        at = f", at its drawn end ({', '.join(f'{part:g}' for part in end)}) m" if any(end) else ""
        doubts.append(
            Doubt("the tip", f"is taken to be link '{named[0]}', by its name{at}", "say [tip] otherwise")
        )
        return TipSection(named[0], end, _RADIUS)
    farthest = max(_ends(tree, last, rotors), key=_distance)
    drawn = _distance(farthest) > beyond
    x, y, z = (float(round(part, 4)) for part in farthest[0]) if drawn else assumed.position
    tip = TipSection(last, (x, y, z), farthest[1] or _RADIUS) if drawn else assumed
    why = "taken, the farthest end that is drawn or joined there" if drawn else "assumed"
    value = f"is not said; ({x:g}, {y:g}, {z:g}) m of link '{last}' is {why}"
    doubts.append(Doubt("the tip", value, "say [tip] in a mapping file"))
    return tip


def _drawn_end(tree: UrdfTree, last: str, tool: str) -> tuple[float, float, float]:
    """The farthest drawn end of a tool's own link, in its frame, m; its origin where that is about as far."""
    link, places = tree.link(tool), _frames(tree, last, set())
    xyz, R = places[tool]
    ends = [xyz + R @ point for point, _ in (_drawn(tree, link) if link is not None else ())]
    far = max(ends, key=lambda end: float(np.linalg.norm(end)), default=xyz)
    if float(np.linalg.norm(far)) < float(np.linalg.norm(xyz)) + _LONG:
        return (0.0, 0.0, 0.0)
    x, y, z = (float(round(part, 4)) + 0.0 for part in R.T @ (far - xyz))
    return (x, y, z)


def _bare(link: Element | None) -> bool:
    """Whether a link is a frame only; on the body, one of a tool's name may hold a tool that is drawn."""
    return link is None or len(link) == 0


def _distance(end: End) -> float:
    return float(np.linalg.norm(end[0])) + end[1]


def _ends(tree: UrdfTree, link: str, without: set[str]) -> Iterator[End]:
    """Ends of a link and of all that fixed joints hold to it, in its frame, m."""
    for name, (xyz, R) in _frames(tree, link, without).items():
        yield xyz, 0.0
        element = tree.link(name)
        for point, radius in _drawn(tree, element) if element is not None else ():
            yield xyz + R @ point, radius


def _frames(tree: UrdfTree, link: str, without: set[str]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Origins (3,), m, and axes (3, 3) of a link and of all that fixed joints hold to it, in its frame."""
    places, inside, open_ = {link: (np.zeros(3), np.eye(3))}, tree.subtree(link, fixed=True), [link]
    while open_:
        name = open_.pop()
        xyz, R = places[name]
        for joint in tree.below(name):
            child = tree.end(joint, "child") or ""
            if child in inside and child not in without and child not in places:
                at, turned = tree.place(joint)
                places[child] = (xyz + R @ at, R @ turned)
                open_.append(child)
    return places


def _drawn(tree: UrdfTree, link: Element) -> Iterator[End]:
    """Ends of the shapes of a link in its frame."""
    for shape in [*link.findall("visual"), *link.findall("collision")]:
        xyz, R = tree.place(shape)
        box, rod, ball = (shape.find(f"geometry/{kind}") for kind in ("box", "cylinder", "sphere"))
        radius = number(ball, "radius", 0.0)
        half = 0.5 * np.array(triple(box, "size", (0.0, 0.0, 0.0)))
        half[2] += 0.5 * number(rod, "length", 0.0)
        if 0.0 < radius <= _LARGEST:
            yield xyz, radius
        else:
            for axis in np.diag(half + max(radius, 0.0)):
                yield xyz + R @ axis, 0.0
                yield xyz - R @ axis, 0.0
