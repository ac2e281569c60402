"""What raises a doubt about a described robot: inertias, flight, links that touch."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from skylimb.apps.robot_import.doubts import Doubt, without_name
from skylimb.apps.robot_import.mechanics import Actuation
from skylimb.apps.robot_import.self_collision import SelfCollision
from skylimb.base.errors import SkylimbError
from skylimb.control.planning.posture import posture_family
from skylimb.robots.description import RobotDescription
from skylimb.robots.flight_check import check_few_rotors, check_robot, least_norm_hover
from skylimb.robots.links import Inertial
from skylimb.robots.model import Robot
from skylimb.robots.turned_rotors import ENOUGH
from skylimb.robots.validation import check_inertial

_OTHER_POSTURE = "say [posture] in a mapping file, or lock a joint that does not move the tip ahead"
_STEADY = 0.1
_LIFT = 1.5
_CONDITION = 100.0
_TILT = 0.3
_UPRIGHT = 0.7
"""Where hover margin, thrust over weight, condition, hover tilt (rad) and fall of a thrust raise a doubt."""


def inertia_doubts(description: RobotDescription) -> Iterator[Doubt]:
    """What is wrong with the links' inertias, or strange about them."""
    for link in description.links:
        remedy = (
            "take it from CAD again (axes, and signs of ixy, ixz, iyz), or --mend for the nearest possible"
        )
        what = f"{'mass' if link.inertial.mass < 0.0 else 'inertia'} of link '{link.name}'"
        yield from faults(
            lambda inertial=link.inertial, name=link.name: check_inertial(name, inertial),
            what,
            "write its mass in kg" if link.inertial.mass < 0.0 else remedy,
        )
        gyration = _gyration(link.inertial)
        if gyration is not None and not 1e-3 < gyration < 1.0 and link.inertial.mass > 1e-3:
            yield Doubt(
                f"inertia of link '{link.name}'",
                f"puts its {link.inertial.mass:g} kg at {gyration:.2g} m from its centre",
                "is a unit or a radius wrong?",
            )


def _gyration(inertial: Inertial) -> float | None:
    if not inertial.mass > 0.0 or not np.isfinite(inertial.inertia).all():
        return None
    largest = float(np.linalg.eigvalsh(inertial.inertia)[-1])
    return float(np.sqrt(largest / inertial.mass)) if largest > 0.0 else None


def faults(
    check: Callable[[], object], what: str, remedy: str = "correct it in the files"
) -> Iterator[Doubt]:
    """A fatal doubt where a check refuses."""
    try:
        check()
    except SkylimbError as error:
        text = without_name(error) if what.endswith("'") else str(error)
        yield Doubt(what, text, remedy, fatal=True)


def rotor_doubts(robot: Robot) -> Iterator[Doubt]:
    """Rotors that push down while the robot stands level, as where a mirrored unit's frame is upside down."""
    poses = robot.link_poses(robot.nominal_posture(), robot.description.vectoring_start)
    for rotor in robot.description.rotors:
        if (poses[rotor.link][1] @ rotor.R)[2, 2] < -_UPRIGHT:
            yield Doubt(
                f"rotor at link '{rotor.link}'",
                "pushes the robot down: thrust is along z of the link, which points down",
                "none, if it does; else say rpy = [3.1416, 0, 0] for it in a mapping file, and its spin",
            )


def flight_doubts(robot: Robot, acting: Actuation) -> Iterator[Doubt]:
    """What keeps a robot from flying, or from flying well."""
    yield from faults(
        lambda: check_few_rotors(robot), "the rotors", "an arm that turns each of them, or more rotors"
    )
    if robot.pairs.n_rotors >= ENOUGH:
        yield from faults(
            lambda: check_robot(robot), "hover", "look at rotor frames, spins, masses and the nominal posture"
        )
        yield from faults(lambda: posture_family(robot), "the postures", _OTHER_POSTURE)
    if acting.thrust_to_weight < _LIFT:
        yield Doubt(
            "thrust over weight",
            f"is {acting.thrust_to_weight:.2f}",
            f"{_LIFT:g} or more; lighten it, or stronger rotors",
        )
    if acting.hover and acting.hover.room < _STEADY:
        yield Doubt(
            "hover margin",
            f"a rotor is within {acting.hover.room:.0%} of its range of a limit",
            f"another nominal posture, or stronger rotors; {_STEADY:.0%} is advised",
        )
    if acting.hover and acting.hover.tilt > _TILT:
        yield Doubt(
            "hover",
            f"the root link tilts by {acting.hover.tilt:.2f} rad",
            "a nominal posture that hovers level",
        )
    if acting.hover and robot.n_rotors > 4 and not least_norm_hover(robot, acting.hover):
        yield Doubt(
            "hover",
            "needs other thrusts than the least-norm ones, of which control laws make their frame",
            "a nominal posture with its centre of gravity nearer to the rotors' middle",
        )
    if not acting.touch:
        yield Doubt("the tip", f"cannot touch: {acting.touch}", "a tip that is foremost in some direction")
    if np.isfinite(acting.condition) and acting.condition > _CONDITION:
        yield Doubt(
            "condition of the allocation",
            f"is {acting.condition:.0f}",
            f"a posture with better levers; {_CONDITION:g} or less is advised",
        )


def hover_doubts(robot: Robot) -> Iterator[Doubt]:
    """What a flight says of a robot of two or three rotors that joints turn; of another one nothing."""
    if robot.pairs is robot:
        return
    # What flies takes a second to import, and other robots need none of it.
    from skylimb.apps.robot_import.hover_flight import require_hover

    yield from faults(
        lambda: require_hover(robot),
        "hover",
        "vectoring servos that turn faster, or rotors farther from the line through their centres",
    )


def collision_doubts(found: SelfCollision, mass: float) -> Iterator[Doubt]:
    """What the simulation says: of the mass, kg, and of links that touch."""
    if abs(found.mass - mass) > 1e-6:
        yield Doubt(
            "mass in the physics",
            f"is {found.mass:.6f} kg, not {mass:.6f} kg",
            "give every moving link an <inertial>",
            fatal=True,
        )
    for one, other, theta in found.family[:5]:
        yield Doubt(
            f"links '{one}' and '{other}'",
            f"touch in the family of postures, first at theta = {theta:.3g} rad",
            "narrow posture.theta_min .. theta_max, or correct the <collision> shapes",
        )
