"""Which way rotors turn that no file says: by their names, by their cant, or as PX4 orders them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skylimb.apps.robot_import.mapping import MappedRotor
from skylimb.apps.robot_import.roles import Roles
from skylimb.apps.robot_import.tree import UrdfTree, pose_at_rest
from skylimb.base.rotations import rotation_from_rpy

_CALLED = re.compile(r"(?<![a-z])(c?cw)(?![a-z])", re.IGNORECASE)
"""The words cw and ccw in names of links, joints and meshes."""
_LEVER = 0.05
"""A rotor is canted whose thrust turns the robot by more than this share of its distance from the middle."""
_SAME = 0.2
"""Rotors whose directions from the middle differ by less, rad, are on one arm."""
_UPRIGHT = 0.7
"""Least share of the thrust that is upright of rotors that clockwise means anything for."""


class Guess(NamedTuple):
    """A sense of spin for each rotor, and why, in words."""

    spins: tuple[int, ...]
    why: str


def guess_spins(tree: UrdfTree, roles: Roles) -> Guess:
    """The best guess, from what says most.

    Rotors that are canted about their arms turn the robot by their thrust as well: they are built so that
    their drag helps. Upright ones turn as PX4 orders them, by where they are; those on links that bend
    against each other by turns along the chain.
    """
    called = _called(tree, roles)
    if called is not None:
        return Guess(called, "as their names say")
    bending = {joint.get("name") for joint in roles.shape}
    if not any(joint.get("name") in bending for rotor in roles.rotors for joint in tree.path_up(rotor.link)):
        frames = [_frame(tree, rotor) for rotor in roles.rotors]
        places, axes = np.array([xyz for xyz, _ in frames]), np.array([R[:, 2] for _, R in frames])
        known = bool(np.isfinite(places).all() and np.isfinite(axes).all())
        canted = _with_cant(places, axes) if known else None
        if canted is not None:
            return Guess(canted, "each so that its drag turns the robot as its canted thrust does")
        ordered = _as_px4(places) if known and np.all(axes[:, 2] > _UPRIGHT) else None
        if ordered is not None:
            return Guess(ordered, "as PX4 orders rotors at such places")
    return Guess(tuple(1 - 2 * (k % 2) for k in range(len(roles.rotors))), "one way and the other in turn")


def _called(tree: UrdfTree, roles: Roles) -> tuple[int, ...] | None:
    """Spins by the words cw and ccw; None where a rotor has neither, or both."""
    found = []
    for rotor in roles.rotors:
        words = {word.lower() for name in _names(tree, rotor.link) for word in _CALLED.findall(name)}
        if len(words) != 1:
            return None
        found.append(1 if words == {"ccw"} else -1)
    return tuple(found)


def _names(tree: UrdfTree, link: str) -> Iterator[str]:
    yield link
    above, element = tree.above(link), tree.link(link)
    if above is not None:
        yield above.get("name", "")
    if element is not None:
        yield from (mesh.get("filename", "").rpartition("/")[2] for mesh in element.iter("mesh"))


def _frame(tree: UrdfTree, rotor: MappedRotor) -> tuple[np.ndarray, np.ndarray]:
    xyz, R = pose_at_rest(tree, rotor.link)
    return xyz + R @ np.array(rotor.xyz), R @ rotation_from_rpy(*rotor.rpy)


def _with_cant(places: np.ndarray, axes: np.ndarray) -> tuple[int, ...] | None:
    """Spins whose drag turns the robot about z as the thrust does; None unless all are canted, both ways."""
    arms = (places - places.mean(axis=0))[:, :2]
    turning = arms[:, 0] * axes[:, 1] - arms[:, 1] * axes[:, 0]
    levers = _LEVER * np.linalg.norm(arms, axis=1)
    if np.any(np.abs(turning) <= levers) or len(set(np.sign(turning))) < 2:
        return None
    return tuple(-int(sign) for sign in np.sign(turning) * np.sign(axes[:, 2]))


def _as_px4(places: np.ndarray) -> tuple[int, ...] | None:
    """Spins by turns from arm to arm, and from an upper rotor to the lower one on its arm.

    A rotor at the nose turns clockwise; where none is, the first to its right turns the other way, but for
    eight arms. The upper rotors of an odd number of arms with two each all turn clockwise. None where places
    are no such frame.
    """
    arms = _arms(places)
    sizes = {len(arm) for arm in arms}
    if sizes not in ({1}, {2}) or (sizes == {1} and len(arms) % 2):
        return None
    x, y, _ = (places - places.mean(axis=0))[arms[0][0]]
    nose = abs(np.arctan2(y, x)) <= 0.5 * _SAME
    first = -1 if nose or len(arms) == 8 or len(arms) % 2 else 1
    spins = np.zeros(len(places), dtype=int)
    for k, arm in enumerate(arms):
        upper = first if len(arms) % 2 else first * (-1) ** k
        for layer, rotor in enumerate(sorted(arm, key=lambda rotor: -places[rotor, 2])):
            spins[rotor] = upper * (-1) ** layer
    return tuple(spins.tolist())


def _arms(places: np.ndarray) -> list[list[int]]:
    """Rotors by arm, clockwise from the nose."""
    x, y = (places - places.mean(axis=0))[:, :2].T
    angles = np.mod(-np.arctan2(y, x) + 0.5 * _SAME, 2.0 * np.pi)
    arms: list[list[int]] = []
    for rotor in np.argsort(angles, kind="stable").tolist():
        if arms and angles[rotor] - angles[arms[-1][0]] < _SAME:
            arms[-1].append(rotor)
        else:
            arms.append([rotor])
    return arms


def spins_of(tree: UrdfTree, roles: Roles) -> tuple[Sequence[int], str]:
    """A spin for each rotor: what is said, else guessed; and why the guess, empty where all is said."""
    said = [rotor.spin for rotor in roles.rotors]
    if None not in said:
        return [spin for spin in said if spin is not None], ""
    guess = guess_spins(tree, roles)
    return [spin or guessed for spin, guessed in zip(said, guess.spins, strict=True)], guess.why
