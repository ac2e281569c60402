"""The findings of a check as text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from skylimb.control.supervisor.descents import descents_of, protecting_posture
from skylimb.control.supervisor.limits import Limits
from skylimb.robots.description import RobotDescription, Rotor, Tip
from skylimb.robots.links import Joint
from skylimb.robots.model import Robot
from skylimb.robots.reaction import DOUBTFUL_ZERO

if TYPE_CHECKING:
    from skylimb.apps.robot_import.checking import RobotReport

CONTACT = "contact"
"""Purpose of the vectoring angles that a robot touches with."""


def report_text(report: RobotReport) -> str:
    """The whole report, one finding a line."""
    heading = f"{report.description.name}  ({report.path})"
    parts = [heading, _bodies(report), rotors_text(report.description), joints_text(report.description)]
    parts += [_abilities(report), _collisions(report), _doubts(report), verdict(report)]
    return "\n".join(filter(None, parts))


def verdict(report: RobotReport) -> str:
    """Whether it can hover, and touch, and else why not, in a line. A task is an experiment's to ask for."""
    name = report.description.name
    if report.can_touch:
        ahead = report.actuation.ahead if report.actuation is not None else True
        return f"{name} can hover and can touch{'.' if ahead else f', but no wall ahead: {ahead}'}"
    if report.can_hover:
        why = f": {report.actuation.touch}" if report.actuation is not None else ""
        return f"{name} can hover and cannot touch{why}"
    return f"{name} loads and cannot hover: {report.reasons[0].what}: {report.reasons[0].value}"


def _bodies(report: RobotReport) -> str:
    description = report.description
    moving = sum(joint.kind != "fixed" for joint in description.joints)
    physics = f", {report.collisions.mass:.6f} kg in the physics" if report.collisions else ""
    return (
        f"  mass      {report.mass_in:.6f} kg in the file, {report.mass:.6f} kg in the model{physics}\n"
        f"  bodies    {len(description.links)} links, {moving + 1} moving bodies, root '{description.root}'"
    )


def rotors_text(description: RobotDescription) -> str:
    """What is known of each rotor, one a line."""
    lines = [f"  rotors    {len(description.rotors)}"]
    above = {joint.child: joint for joint in description.joints}
    for rotor in description.rotors:
        turning, link = [], rotor.link
        while link in above:
            if above[link].name in description.vectoring_joints:
                turning.append(above[link].name)
            link = above[link].parent
        turned = f", turned by {', '.join(reversed(turning))}" if turning else ""
        lines.append(
            f"    {rotor.name:<9} at '{rotor.link}', spins {'+' if rotor.spin > 0 else '-'}z, "
            f"{rotor.thrust_min:g} .. {rotor.thrust_max:g} N, drag {abs(rotor.drag_torque_coefficient):g} m, "
            f"lag {rotor.lag:g} s{_size(rotor)}{_inertia(rotor)}{turned}"
        )
    return "\n".join(lines)


def lost_rotors_text(description: RobotDescription) -> str:
    """What happens without each rotor in the posture of contact, one a line."""
    robot, lines = Robot(description), ["  without"]
    ways = descents_of(robot, CONTACT, Limits(losses=True)).angles
    for lost, (rotor, way) in enumerate(zip(description.rotors, ways, strict=True)):
        said = "the others bring it down, with `supervisor.losses`"
        if way is None:
            q = protecting_posture(robot, CONTACT, lost)
            there = "nor in any posture that was tried"
            if q is not None:
                names = zip(description.shape_joints, q, strict=True)
                there = "they would at " + ", ".join(f"{name} {angle:.2f}" for name, angle in names) + " rad"
            said = f"NOT PROTECTED, the rotors stop: the others cannot carry it; {there}"
        lines.append(f"    {rotor.name:<9} {said}")
    return "\n".join(lines)


def _size(rotor: Rotor) -> str:
    return "" if rotor.radius is None else f", disc of {rotor.radius:g} m"


def _inertia(rotor: Rotor) -> str:
    said = f", inertia {rotor.inertia:g} kg m²" if rotor.inertia is not None else ""
    return f"{said}, motor {rotor.torque_max:g} N m" if math.isfinite(rotor.torque_max) else said


def joints_text(description: RobotDescription) -> str:
    """What is known of each joint that moves, one a line."""
    lines = []
    for title, names in (("bending", description.shape_joints), ("vectoring", description.vectoring_joints)):
        if not names:
            lines.append(f"  {title:<9} none")
            continue
        lines.append(f"  {title:<9} {len(names)}")
        lines += [f"    {_joint(description.joint(name))}" for name in names]
    return "\n".join(lines)


def _joint(joint: Joint) -> str:
    endless = math.isinf(joint.lower)
    travel = "without end" if endless else f"{joint.lower:.4g} .. {joint.upper:.4g} rad"
    return f"{joint.name:<15} {travel}, at most {joint.speed:g} rad/s and {joint.effort:g} N m"


def _abilities(report: RobotReport) -> str:
    acting = report.actuation
    if acting is None:
        return ""
    hover = acting.hover
    steady = f"none: {hover}"
    if hover:
        level = "level" if hover.tilt < 0.01 else f"root tilted by {hover.tilt:.3f} rad"
        steady = f"{level}, every rotor {hover.room:.0%} of its range from a limit"
        steady += f", {hover.margin:.2f} N m left about any axis" if hover.margin > 0.0 else ""
    condition = (
        f", condition {acting.condition:.3g} for lift and torque" if math.isfinite(acting.condition) else ""
    )
    return (
        f"  hover     {steady}; thrust over weight {acting.thrust_to_weight:.2f}\n"
        f"  actuation rank {acting.rank} of 6{condition}; rank {acting.rank_moving} with vectoring moving: "
        f"{acting.in_words}\n"
        f"  tool      {_tool(report.description.tip)}\n"
        f"  touch     {acting.touch}\n"
        f"  reaction  {_reaction(acting.unstable_zero)}"
    )


def _tool(tip: Tip) -> str:
    """Where the tip is, which way its tool points in its link's axes, and what the heading is."""
    at = ", ".join(f"{part:g}" for part in tip.position)
    way = ", ".join(f"{part:.2f}" for part in tip.R[:, 0] + 0.0)
    return f"at ({at}) m of '{tip.link}', pointing along ({way}) there; heading: x of the {tip.heading}"


def _reaction(zero: float | None) -> str:
    """How the rotors' change of speed limits the attitude's loop."""
    if zero is None:
        return "not known: rotors.inertia and rotors.thrust_factor say it"
    if math.isinf(zero):
        return "rotors that change their speed do not work against lift and torque at these angles"
    return (
        f"rotors that change their speed work against lift and torque: zero at +{zero:.3g} rad/s, so an "
        f"attitude loop up to about {zero / DOUBTFUL_ZERO:.2g} rad/s"
    )


def _collisions(report: RobotReport) -> str:
    found = report.collisions
    if found is None:
        return ""
    if not found.shaped:
        return "  touching  not known: no link has a <collision> shape"
    links = f"{found.shaped} of {len(report.description.links)} links have a shape"
    if not report.description.shape_joints:
        return f"  touching  nothing moves against anything ({links})"
    family = f"{len(found.family)} pairs" if found.family else "none"
    return (
        f"  touching  in the family of postures: {family}; in {found.share:.0%} of all postures within the "
        f"joint limits ({links})"
    )


def _doubts(report: RobotReport) -> str:
    if not report.doubts:
        return ""
    ordered = sorted(report.doubts, key=lambda doubt: not doubt.fatal)
    lines = [f"  {'FAULT' if doubt.fatal else 'doubt'}     {doubt}" for doubt in ordered]
    return "\n".join(["", *lines, ""])
