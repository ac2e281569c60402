"""The flight TOML of a recognised description, with a doubt for what is assumed or contradicts itself."""

from __future__ import annotations

import math
import re
from xml.etree.ElementTree import Element

import numpy as np

from skylimb.apps.robot_import.doubts import Doubt
from skylimb.apps.robot_import.mapping import MappedRotor, Mapping
from skylimb.apps.robot_import.roles import Roles
from skylimb.apps.robot_import.spin_guess import spins_of
from skylimb.apps.robot_import.tables import LabTables, MotorTable
from skylimb.apps.robot_import.thrust_limits import Axle, thrust_limits
from skylimb.apps.robot_import.tip_guess import guess_tip
from skylimb.apps.robot_import.tool_guess import with_axes
from skylimb.apps.robot_import.tree import UrdfTree, number
from skylimb.apps.robot_import.turning_guess import turning
from skylimb.base.errors import DescriptionError
from skylimb.robots.description import GRAVITY, Servo
from skylimb.robots.flight_file import (
    FlightFile,
    ImuSection,
    PostureSection,
    RotorSection,
    ShapeSection,
    VectoringSection,
)

URDF_NAME = "robot.urdf"
KAPPA, LAG, THRUST_MIN, THRUST_TO_WEIGHT = 0.016, 0.05, 0.5, 2.0
"""Assumed where nothing says it: drag torque per thrust (m), lag (s), least thrust (N), lift over weight."""

SPIN = "spin of the rotors"
"""What is doubted where no file says how rotors turn."""

_FAR_APART = 0.05
_IMU = re.compile(r"(^|[_/])(imu|fc|flight_?controller)\d*(_link)?$", re.IGNORECASE)
"""Names of links on which an IMU sits; the lab's flight controller is called fc."""
_SERVOS = {"joints": Servo(50.0, 2.0, 3.0, 0.5), "gimbals": Servo(5.0, 0.1, 3.0, 10.0)}


def propose(
    tree: UrdfTree, roles: Roles, axles: list[Axle], mapping: Mapping, tables: LabTables
) -> tuple[FlightFile, list[Doubt]]:
    """The flight file, and a doubt for each number that is assumed or said twice differently.

    Args:
        tree: after the repairs.
        roles: as recognised.
        axles: what is said of each rotor's axle before the repairs; the laboratory's limits are newtons.
        mapping: what the user says.
        tables: of the laboratory's package.

    Raises:
        DescriptionError: there are no rotors.
    """
    if not roles.rotors:
        ends = [tree.end(joint, "child") or "" for joint in roles.locked + roles.shape]
        ends = [f"'{end}'" for end in ends if not tree.below(end)]
        turned = f"; links on joints of other names are {', '.join(ends[:12])}" if ends else ""
        raise DescriptionError(
            f"no rotors are recognised in '{tree.name}': neither joints called rotor1 .. or propeller1 .. "
            f"that spin, nor [[rotors]] of a mapping file (--mapping FILE){turned}"
        )
    doubts: list[Doubt] = []
    rotors = _rotors(tree, roles, axles, tables.motors, doubts)
    shape = tuple(joint.get("name", "") for joint in roles.shape)
    vectoring = tuple(joint.get("name", "") for joint in roles.vectoring)
    tip = with_axes(tree, roles, mapping.tip or guess_tip(tree, roles, doubts))
    flight = FlightFile(
        name=mapping.name or tree.name,
        summary=f"{len(rotors)} rotors, {len(shape)} bending and {len(vectoring)} vectoring joints, imported",
        urdf=URDF_NAME,
        measured_link=tree.base(),
        tip=tip,
        shape=ShapeSection(shape, mapping.shape_servo or _servo("joints", tree, roles.shape, tables, doubts))
        if shape
        else None,
        vectoring=VectoringSection(
            vectoring,
            mapping.vectoring_servo or _servo("gimbals", tree, roles.vectoring, tables, doubts),
            mapping.vectoring_start or (0.0,) * len(vectoring),
        )
        if vectoring
        else None,
        posture=(mapping.posture or _level(tree, roles.shape)) if shape else None,
        imu=mapping.imu or _imu(tree, doubts),
        rotors=rotors,
    )
    return flight, doubts


def _imu(tree: UrdfTree, doubts: list[Doubt]) -> ImuSection | None:
    """The link that is called an IMU or a flight controller, at its origin; None where none is."""
    link = next(filter(_IMU.search, tree.links()), None)
    if link is None:
        return None
    value = f"is taken to be link '{link}', by its name, in that link's axes"
    doubts.append(Doubt("the IMU", value, "say [imu] in a mapping file: link, xyz, rpy"))
    return ImuSection(link)


def _level(tree: UrdfTree, shape: tuple[Element, ...]) -> PostureSection:
    """Joints at zero, or as near to it as their limits let them; a better posture is sought later."""
    rest = tuple(tree.rest(joint) for joint in shape)
    return PostureSection(rest, (1.0,) * len(shape), -1e-3, 1e-3, 0.0)


def _rotors(
    tree: UrdfTree, roles: Roles, axles: list[Axle], motors: MotorTable, doubts: list[Doubt]
) -> tuple[RotorSection, ...]:
    """Each number from the first that says it: mapping, URDF, motor table; else it is assumed."""
    kappa = _drag(tree, roles.rotors, motors, doubts)
    spins, why = spins_of(tree, roles)
    if why and len(roles.rotors) > 1 and kappa > 0.0:
        doubts.append(Doubt(SPIN, f"is not said; they are taken to turn {why}", "say spin in a mapping file"))
    share = tree.total_mass() * GRAVITY / len(roles.rotors)
    sections = []
    for rotor, axle, spin in zip(roles.rotors, axles, spins, strict=True):
        low, high = _thrusts(rotor, axle, share, motors, doubts)
        lag = _first(rotor.lag, motors.lag)
        if lag is None:
            guess = f"is not said; {LAG:g} s is assumed"
            doubts.append(Doubt("lag of the rotors", guess, "say lag, from a step of thrust"))
        inertia, factor = turning(tree, rotor, high, doubts)
        sections.append(
            RotorSection(
                link=rotor.link,
                spin=1 if spin > 0 else -1,
                drag_torque_coefficient=_first(rotor.drag_torque_coefficient, kappa) or 0.0,
                thrust_min=low,
                thrust_max=high,
                lag=lag or LAG,
                thrust_factor=factor,
                inertia=inertia,
                torque_limit=rotor.torque_limit,
                current_limit=rotor.current_limit,
                radius=rotor.radius,
                torque_constant=rotor.torque_constant,
                xyz=rotor.xyz,
                rpy=rotor.rpy,
            )
        )
    return tuple(sections)


def _first(*values: float | None) -> float | None:
    """The first value that is said."""
    return next((value for value in values if value is not None), None)


def _drag(tree: UrdfTree, rotors: tuple[MappedRotor, ...], motors: MotorTable, doubts: list[Doubt]) -> float:
    """Drag torque per thrust, without sign."""
    said, table = number(tree.root.find("m_f_rate"), "value", math.nan), motors.drag_torque_coefficient
    what = "drag torque per thrust"
    if not math.isfinite(said):
        if table is None and any(rotor.drag_torque_coefficient is None for rotor in rotors):
            guess = f"is not said; {KAPPA:g} m is assumed"
            doubts.append(Doubt(what, guess, "say drag_torque_coefficient in a mapping file"))
        return KAPPA if table is None else table
    if table is not None and abs(abs(said) - table) > _FAR_APART * max(abs(said), table):
        value = f"is {abs(said):g} m in the URDF and {table:g} m in {_named(motors)}; the URDF's is taken"
        doubts.append(Doubt(what, value, "measure it, and correct one of the two"))
    return abs(said)


def _thrusts(
    rotor: MappedRotor, axle: Axle, share: float, motors: MotorTable, doubts: list[Doubt]
) -> tuple[float, float]:
    """Least and greatest thrust, N; `share` is the weight that a rotor carries, N."""
    low, high, odd = thrust_limits(axle)
    of = f"greatest thrust of joint {axle.joint}"
    table, most, what = motors.thrust_max, rotor.thrust_max, "greatest thrust"
    if not most and high is not None and table is not None:
        most = min(high, table)
        if abs(high - table) > _FAR_APART * table:
            value = f"is {high:g} N in the URDF and {table:g} N in {_named(motors)}; the smaller is taken"
            doubts.append(Doubt(what, value, "say thrust_max in a mapping file, as measured"))
    most = _first(most or None, high, table)
    if most is None:
        most = round(THRUST_TO_WEIGHT * share, 2)
        value = (
            f"{odd or 'is not said'}; {THRUST_TO_WEIGHT:g} times the weight is assumed, {most:g} N a rotor"
        )
        doubts.append(Doubt(of if odd else what, value, "say thrust_max in a mapping file"))
    elif odd and not rotor.thrust_max:
        doubts.append(Doubt(of, f"{odd}; {most:g} N of {_named(motors)} is taken", "correct it in the files"))
    least = _first(rotor.thrust_min, low, motors.thrust_min, min(THRUST_MIN, 0.1 * most)) or 0.0
    return (least, most) if least < most else (0.0, most)


def _named(motors: MotorTable) -> str:
    """Name of the table, and the voltage that its thrust is for."""
    return motors.file if motors.voltage is None else f"{motors.file} (at {motors.voltage:g} V)"


def _servo(
    group: str, tree: UrdfTree, joints: tuple[Element, ...], tables: LabTables, doubts: list[Doubt]
) -> Servo:
    """Gains of the laboratory's table, else assumed, and so is no damping; limits of each joint's file."""
    gains = tables.servos.get(group)
    if gains is None:
        gains = _SERVOS[group].stiffness, _SERVOS[group].damping
        value = f"are not said; {gains[0]:g} N m/rad and {gains[1]:g} N m s/rad are assumed"
        doubts.append(
            Doubt(f"gains of the servos of {group}", value, "say them in a mapping file, as measured")
        )
    elif not gains[1]:
        # Vectoring angles that swing undamped at some 14 Hz take the robot along: it drifts away.
        rate = float(np.divide(_SERVOS[group].damping, _SERVOS[group].stiffness))
        gains = gains[0], gains[0] * rate
        value = (
            f"are {gains[0]:g} N m/rad without damping in the laboratory's table, which swings; "
            f"{gains[1]:g} N m s/rad are assumed"
        )
        doubts.append(
            Doubt(f"damping of the servos of {group}", value, "say it in a mapping file, as measured")
        )
    limits = list[float | tuple[float, ...]]()
    for key, most in (("effort", 1e5), ("velocity", 1e3)):
        said = [float(np.clip(tree.limit(joint, key), 1e-3, most)) for joint in joints]
        limits.append(said[0] if len(set(said)) == 1 else tuple(said))
    return Servo(*gains, *limits)
