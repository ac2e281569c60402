"""Refuse descriptions of what cannot exist, naming the thing, its value and what was allowed.

The ranges of the flight TOML's own keys stand with the keys, in `skylimb.robots.flight_file`.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from skylimb.base.errors import DescriptionError
from skylimb.robots.description import RobotDescription
from skylimb.robots.links import Inertial, Joint

_GYRATION_MAX = 3.0
"""Greatest believable radius of gyration of one link, m."""


def check_description(description: RobotDescription) -> None:
    """Check every link and joint on its own, and that names and numbers of entries fit together.

    Raises:
        DescriptionError: the first thing that no physical robot can have.
    """
    for link in description.links:
        check_inertial(link.name, link.inertial)
    for joint in description.joints:
        _check_joint(joint)
    _check_roles(description)
    if not description.rotors:
        raise DescriptionError(
            f"'{description.name}' has no rotors; thrust and three torques need at least 4"
        )
    _check_unique("rotor", [rotor.name for rotor in description.rotors])
    _check_root(description)
    _check_weight(description)
    _check_posture(description)


_GRAMS = 2.0
"""Weight of one link over the greatest lift from which on its mass may have been written in grams."""


def check_inertial(name: str, inertial: Inertial) -> None:
    """Check mass and inertia of one body.

    Raises:
        DescriptionError: a negative mass, or an inertia that no body of that mass has.
    """
    mass = inertial.mass
    if mass < 0.0:
        raise DescriptionError(f"mass of link '{name}' is {mass:g} kg; it must not be negative")
    if not np.all(np.isfinite(inertial.inertia)) or not np.all(np.isfinite(inertial.com)):
        raise DescriptionError(f"mass properties of link '{name}' are not finite numbers")
    if mass == 0.0:
        if np.any(inertial.inertia != 0.0):
            raise DescriptionError(f"link '{name}' has inertia but its mass is 0 kg; give both or neither")
        return
    moments = np.linalg.eigvalsh(inertial.inertia)
    shown = ", ".join(f"{moment:.3g}" for moment in moments)
    if moments[0] <= 0.0:
        raise DescriptionError(
            f"inertia of link '{name}' is not positive definite: principal moments {shown} kg m^2"
        )
    if moments[0] + moments[1] < moments[2] * (1.0 - 1e-6):
        raise DescriptionError(
            f"inertia of link '{name}' is that of no body: of the principal moments {shown} kg m^2 the two "
            "smaller must "
            "add up to at least the largest (A + B >= C)"
        )
    gyration = math.sqrt(moments[2] / mass)
    if gyration > _GYRATION_MAX:
        raise DescriptionError(
            f"inertia of link '{name}' puts its {mass:g} kg at {gyration:.3g} m from its centre (at most "
            f"{_GYRATION_MAX:g} "
            "m is believed); is it in g m^2 or kg mm^2?"
        )


def _check_joint(joint: Joint) -> None:
    if joint.kind == "fixed":
        return
    what = f"joint '{joint.name}'"
    for side, limit in (("lower", joint.lower), ("upper", joint.upper)):
        if math.isnan(limit):
            raise DescriptionError(f"{side} limit of {what} is not a number")
        if math.isfinite(limit) and abs(limit) > 2.0 * math.pi:
            raise DescriptionError(
                f"{side} limit of {what} is {limit:g} rad, more than a turn; is it degrees? "
                f"{limit:g} deg = {math.radians(limit):.4g} rad"
            )
    if joint.lower >= joint.upper:
        raise DescriptionError(
            f"{what} has lower limit {joint.lower:g} not below its upper limit {joint.upper:g} rad"
        )
    for key, value in (("effort", joint.effort), ("velocity", joint.speed)):
        if not value > 0.0:
            raise DescriptionError(f"{key} limit of {what} is {value:g}; it must be positive")
    for key, value in (("damping", joint.damping), ("friction", joint.friction)):
        if not value >= 0.0:
            raise DescriptionError(f"{key} of {what} is {value:g}; it must not be negative")


def _check_roles(description: RobotDescription) -> None:
    roles = description.moving_joints
    _check_unique("joint in shape.joints and vectoring.joints", roles)
    for joint in description.joints:
        if joint.kind != "fixed" and joint.name not in roles:
            raise DescriptionError(
                f"joint '{joint.name}' moves but is neither in shape.joints nor in vectoring.joints; name it "
                "or make it fixed"
            )
    expected = (
        ("vectoring.start", len(description.vectoring_start), len(description.vectoring_joints)),
        ("posture.offset", len(description.posture.offset), len(description.shape_joints)),
        ("posture.slope", len(description.posture.slope), len(description.shape_joints)),
    )
    for key, given, wanted in expected:
        if given != wanted:
            raise DescriptionError(
                f"{key} of '{description.name}' has {given} entries; one for each of {wanted} joints"
            )


def _check_unique(kind: str, names: Sequence[str]) -> None:
    for name, count in Counter(names).items():
        if count > 1:
            raise DescriptionError(f"{kind} '{name}' is named {count} times")


def _check_root(description: RobotDescription) -> None:
    """A massless root that the robot is bolted to means a robot bolted to the ground."""
    root = description.link(description.root)
    if root.inertial.mass > 0.0:
        return
    bolted = [joint for joint in description.joints if joint.parent == root.name and joint.kind == "fixed"]
    child = bolted[0].child if bolted else ""
    lost = sum(description.link(joint.child).inertial.mass for joint in bolted)
    lost += sum(
        description.link(joint.child).inertial.mass
        for joint in description.joints
        if joint.parent == child and joint.kind == "fixed"
    )
    if bolted:
        raise DescriptionError(
            f"the URDF's root link '{root.name}' has no mass and link '{child}' is fixed to it: a simulator "
            "would bolt "
            f"'{child}' to the ground and drop {lost:.3f} kg; remove '{root.name}', or say root_link = "
            f'"{child}" in the TOML'
        )
    raise DescriptionError(
        f"the URDF's root link '{root.name}' has no mass; the root must be a body of the robot"
    )


def _check_weight(description: RobotDescription) -> None:
    weight = description.mass * description.gravity
    lift = sum(rotor.thrust_max for rotor in description.rotors)
    if weight >= lift:
        heaviest = max(description.links, key=lambda link: link.inertial.mass)
        raise DescriptionError(
            f"'{description.name}' weighs {description.mass:g} kg ({weight:.4g} N) but its rotors lift at "
            f"most {lift:g} N{limited_by_torque(description)}; "
            f"the heaviest link is '{heaviest.name}' with {heaviest.inertial.mass:g} kg"
            f"{'; is that in grams?' if heaviest.inertial.mass * description.gravity > _GRAMS * lift else ''}"
        )


def limited_by_torque(description: RobotDescription) -> str:
    """Words on the rotor whose motor is too weak for the thrust that it is said to give; empty for none."""
    for rotor in description.rotors:
        drag = abs(rotor.drag_torque_coefficient)
        if drag > 0.0 and rotor.thrust_max >= rotor.torque_max / drag:
            return (
                f" (a motor of {rotor.torque_max:g} N m turns {rotor.name} against its drag up to "
                f"{rotor.thrust_max:.3g} N; see rotors.torque_limit)"
            )
    return ""


def _check_posture(description: RobotDescription) -> None:
    posture = description.posture
    sides = (1.0, -1.0) if posture.contact_side == "mirrored" else (1.0,)
    nominal = zip(description.shape_joints, posture.nominal, strict=True)
    for side, (name, angle) in itertools.product(sides, nominal):
        joint = description.joint(name)
        if not joint.lower <= side * angle <= joint.upper:
            raise DescriptionError(
                f"posture.theta_nominal = {posture.theta_nominal:g} puts '{name}' at {side * angle:.4g} rad, "
                "outside of its limits "
                f"{joint.lower:g} .. {joint.upper:g} rad"
            )
