"""What an import changes in a URDF so that physics takes it, each change listed as a doubt."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

import numpy as np

from skylimb.apps.robot_import.doubts import Doubt, without_name
from skylimb.apps.robot_import.roles import Roles
from skylimb.apps.robot_import.tree import INERTIA, UrdfTree, write_inertia
from skylimb.base.errors import DescriptionError
from skylimb.robots.links import Inertial
from skylimb.robots.validation import check_inertial

DUST = 1e-3
"""Links lighter than this stand for nothing real, kg."""

WORLD = "world"
"""What a URDF's root is often called that is no part of the robot; engines have their own of that name."""

_DUST_GYRATION = 0.01
"""Radius of gyration that such a link is given where its own cannot be, m."""

_POINT = 1e-3
"""Radius of gyration below which a link is a point, m."""

_LIMITS = {"effort": (3.0, "N m"), "velocity": (0.5, "rad/s")}
"""Assumed where a joint's limit is missing or not positive."""

_IN_DEGREES = 720.0
"""Greatest limit of a turning joint that may have been written in degrees; +-1e16 means no limit."""

_FARTHEST = 10.0
"""How far a joint may put its link from the one before it, m."""

_SPREAD = 1e-3
"""Share of the second moment that a mended inertia has at least along each axis."""


def repair(tree: UrdfTree, roles: Roles, *, mend: bool = False) -> list[Doubt]:
    """Change the tree in place; what it still weighs is what it weighed.

    Args:
        tree: as it was read; links and joints only remain.
        roles: of its joints. Rotors' axles and locked joints become fixed, the latter within their limits.
        mend: whether inertias of real links that no body has are replaced by the nearest one that a body has.

    Raises:
        DescriptionError: a link is farther from the one before it than any robot is large.
    """
    doubts: list[Doubt] = []
    welded = sum(tree.mass(name) for name in tree.subtree(tree.base(), fixed=True))
    for joint in roles.spinning:
        if joint is not None:
            tree.fix(joint)
    # Before any is fixed, which takes its limits.
    for joint, held in [(joint, tree.rest(joint)) for joint in roles.locked]:
        tree.hold(joint, held)
        if held != 0.0:
            what = f"joint '{joint.get('name')}'"
            doubts.append(
                Doubt(what, f"cannot rest at zero; it is held at {held:g}", "none, if that is right")
            )
    for joint in [*roles.shape, *roles.vectoring]:
        doubts += _mend_joint(tree, joint)
    base = tree.base()
    doubts += _plant_root(tree, welded)
    _require_near(tree, base)
    for name in tree.links():
        doubts += _mend_inertia(tree, name, mend)
    tree.keep_robot_only()
    return doubts


def _mend_joint(tree: UrdfTree, joint: Element) -> list[Doubt]:
    name, doubts = joint.get("name", ""), []
    if joint.find("axis") is None:
        value = "has no <axis>; x of its child is taken, as URDF has it"
        doubts.append(Doubt(f"joint '{name}'", value, "write <axis xyz=.../>"))
    if tree.endless(joint):
        low, high = tree.limit(joint, "lower"), tree.limit(joint, "upper")
        if max(-low, high) <= _IN_DEGREES:
            value = (
                f"has limits of {low:g} .. {high:g} rad, more than a turn; it counts as turning without end"
            )
            remedy = f"none, if that is right; if they are degrees, write {_radians(low)} .. {_radians(high)}"
            doubts.append(Doubt(f"joint '{name}'", value, remedy))
        joint.set("type", "continuous")
    for key, (assumed, unit) in _LIMITS.items():
        value = tree.limit(joint, key)
        if not (np.isfinite(value) and value > 0.0):
            tree.set_limit(joint, key, assumed)
            given = "is missing" if np.isnan(value) else f"is {value:g} {unit}"
            doubts.append(
                Doubt(
                    f"{key} limit of joint '{name}'",
                    f"{given}; {assumed:g} {unit} is assumed",
                    f"write {key}=... of the real servo into the URDF",
                )
            )
    return doubts


def _radians(degrees: float) -> str:
    return f"{math.radians(degrees):.4g}"


def _plant_root(tree: UrdfTree, welded: float) -> list[Doubt]:
    """The first link that weighs something, or from which joints move, becomes the root.

    `welded` is the mass (kg) that fixed joints hold to the old one in the file.
    """
    base, at = tree.base(), tree.base()
    while tree.mass(at) < DUST:
        below = tree.below(at)
        fixed = [joint for joint in below if joint.get("type") == "fixed"]
        floating = [joint for joint in below if joint.get("type") == "floating"]
        if len(below) != 1 or not (fixed or floating):
            break
        child = tree.end(below[0], "child") or ""
        if floating:
            tree.fix(below[0])
        at = child
    if at == base:
        return []
    tree.plant_root(at)
    tree.drop_empty_leaf(WORLD)
    share = welded / max(tree.total_mass(), 1e-12)
    return [
        Doubt(
            f"root link '{base}'",
            f"weighs {tree.mass(base):g} kg; '{at}' becomes the root and nothing is lost (an engine that "
            f"welds the root to the world drops {welded:.3f} kg, {share:.0%}, from this file)",
            "none is needed",
        )
    ]


def _require_near(tree: UrdfTree, base: str) -> None:
    """Refuse lengths in millimetres, but for the place of the file's root `base`, where it may be spawned."""
    for joint in tree.joints():
        far, child = float(np.linalg.norm(tree.place(joint)[0])), tree.end(joint, "child")
        if far > _FARTHEST and child != base:
            raise DescriptionError(
                f"joint '{joint.get('name')}' puts link '{child}' {far:g} m from "
                f"'{tree.end(joint, 'parent')}' (at most {_FARTHEST:g} m is believed); is it in millimetres? "
                f"{far:g} mm = {1e-3 * far:g} m"
            )


def _mend_inertia(tree: UrdfTree, name: str, mend: bool) -> list[Doubt]:
    inertial = _inertial(tree, name)
    if inertial is None:
        return []
    try:
        check_inertial(name, inertial)
    except DescriptionError as error:
        if not np.isfinite(inertial.mass) or inertial.mass < 0.0 or not np.isfinite(inertial.inertia).all():
            return []  # refused with a message when the tree is read
        if inertial.mass < DUST:
            inertia = inertial.mass * _DUST_GYRATION**2 * np.eye(3)
            moments = _moments(inertial)
            value = f"weighs {inertial.mass:g} kg, and its inertia is no such body's ({moments} kg m^2)"
            _write_inertia(tree, name, inertia)
            return [
                Doubt(f"link '{name}'", f"{value}; that of a ball is taken", "none, if it stands for nothing")
            ]
        if mend:
            mended = nearest_inertia(inertial.inertia)
            if np.trace(mended) < inertial.mass * _POINT**2:  # a point mass, which the physics engine refuses
                mended = inertial.mass * _DUST_GYRATION**2 * np.eye(3)
            _write_inertia(tree, name, mended)
            new = _moments(Inertial(inertial.mass, inertial.com, mended))
            value = f"{without_name(error)}; mended to {new} kg m^2"
            return [Doubt(f"inertia of link '{name}'", value, "measure it, or take it from CAD again")]
    return []


def _moments(inertial: Inertial) -> str:
    return ", ".join(f"{moment:.3g}" for moment in np.linalg.eigvalsh(inertial.inertia))


def nearest_inertia(inertia: np.ndarray) -> np.ndarray:
    """The nearest inertia (3, 3) that a body can have, in the Frobenius norm of the second moments.

    I = trace(S) E - S with the second moment S = integral of x x^T dm, which is positive semidefinite for
    every body, and only then. So the negative eigenvalues of S are cut off, and a small share is left along
    each axis.
    """
    S = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    values, vectors = np.linalg.eigh(0.5 * (S + S.T))
    values = np.maximum(values, _SPREAD * max(float(values.max()), 1e-12))
    S = vectors @ np.diag(values) @ vectors.T
    return np.trace(S) * np.eye(3) - S


def _inertial(tree: UrdfTree, name: str) -> Inertial | None:
    link = tree.link(name)
    element = None if link is None else link.find("inertial/inertia")
    if element is None:
        return None
    inertia = np.zeros((3, 3))
    for key, (i, j) in INERTIA.items():
        try:
            inertia[i, j] = inertia[j, i] = float(element.get(key, "0"))
        except ValueError:
            return None
    return Inertial(tree.mass(name), np.zeros(3), inertia)


def _write_inertia(tree: UrdfTree, name: str, inertia: np.ndarray) -> None:
    link = tree.link(name)
    element = None if link is None else link.find("inertial/inertia")
    assert element is not None  # it was read from there
    write_inertia(element, inertia)
