"""The flight TOML of a recognised description; what is assumed, or said twice differently, is told."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from skylimb.apps.robot_import.doubts import Doubt
from skylimb.apps.robot_import.mapping import MappedRotor, Mapping
from skylimb.apps.robot_import.roles import Roles
from skylimb.apps.robot_import.tables import MotorTable, ServoTable
from skylimb.apps.robot_import.tree import UrdfTree
from skylimb.base.errors import DescriptionError
from skylimb.robots.description import GRAVITY, Servo
from skylimb.robots.flight_file import (
    FlightFile,
    PostureSection,
    RotorSection,
    ShapeSection,
    TipSection,
    VectoringSection,
)

URDF_NAME = "robot.urdf"
KAPPA, LAG, THRUST_MIN, THRUST_TO_WEIGHT = 0.016, 0.05, 0.5, 2.0
"""Assumed where nothing says it: drag torque per thrust (m), lag (s), least thrust (N), lift over weight."""

_TIP_RADIUS = 0.01
_STICK = 0.15
"""How far an assumed tip stands out beyond the rotors of a robot without bending joints, m."""
_BELIEVED = 1e3
"""Greatest thrust that a limit of a rotor's axle may mean, N; +-1e16 means none."""
_FAR_APART = 0.05
_SERVOS = {"joints": Servo(50.0, 2.0, 3.0, 0.5), "gimbals": Servo(5.0, 0.1, 3.0, 10.0)}


@dataclass(frozen=True)
class Sources:
    """What is known besides the tree: the mapping, motor and servo tables."""

    mapping: Mapping
    motors: MotorTable | None
    servos: dict[str, ServoTable]


def propose(
    tree: UrdfTree, roles: Roles, axles: list[dict[str, float]], sources: Sources
) -> tuple[FlightFile, list[Doubt]]:
    """The flight file, and a doubt for each number that is assumed or said twice differently.

    Args:
        tree: after the repairs.
        roles: as recognised.
        axles: limits of each rotor's axle before the repairs, which the laboratory gives in newtons.
        sources: besides the tree.

    Raises:
        DescriptionError: there are no rotors.
    """
    if not roles.rotors:
        raise DescriptionError(
            f"no rotors are recognised in '{tree.name}': neither joints called rotor1 .. or propeller1 .. "
            "that spin, nor [[rotors]] of a mapping file (--mapping FILE)"
        )
    doubts: list[Doubt] = []
    rotors = _rotors(tree, roles, axles, sources, doubts)
    mapping = sources.mapping
    shape = tuple(joint.get("name", "") for joint in roles.shape)
    vectoring = tuple(joint.get("name", "") for joint in roles.vectoring)
    tip = mapping.tip or _tip(tree, roles, doubts)
    flight = FlightFile(
        name=mapping.name or tree.name,
        summary=f"{len(rotors)} rotors, {len(shape)} bending and {len(vectoring)} vectoring joints, imported",
        urdf=URDF_NAME,
        measured_link=tree.base(),
        tip=tip,
        shape=ShapeSection(shape, mapping.shape_servo or _servo("joints", tree, roles.shape, sources))
        if shape
        else None,
        vectoring=VectoringSection(
            vectoring,
            mapping.vectoring_servo or _servo("gimbals", tree, roles.vectoring, sources),
            mapping.vectoring_start or (0.0,) * len(vectoring),
        )
        if vectoring
        else None,
        posture=(mapping.posture or _level(len(shape))) if shape else None,
        rotors=rotors,
    )
    return flight, doubts


def _level(n: int) -> PostureSection:
    """Joints at zero; a better posture is sought later."""
    return PostureSection((0.0,) * n, (1.0,) * n, -1e-3, 1e-3, 0.0)


def _rotors(
    tree: UrdfTree,
    roles: Roles,
    axles: list[dict[str, float]],
    sources: Sources,
    doubts: list[Doubt],
) -> tuple[RotorSection, ...]:
    kappa, sense = _drag(tree, sources, doubts)
    signs = [rotor.spin for rotor in roles.rotors]
    told = any(sign == -1 for sign in signs)
    if len(signs) > 1 and not told and kappa > 0.0:
        doubts.append(
            Doubt(
                "spin of the rotors",
                "is not said; they are taken to turn in alternation",
                "say spin in a mapping file",
            )
        )
    share = tree.total_mass() * GRAVITY / len(roles.rotors)
    sections = []
    for k, (rotor, axle) in enumerate(zip(roles.rotors, axles, strict=True)):
        low, high = _thrusts(k, rotor, axle, share, sources, doubts)
        spin = sense * (rotor.spin if told and rotor.spin else 1 if k % 2 == 0 else -1)
        lag = rotor.lag or (sources.motors.lag if sources.motors else None)
        if lag is None and k == 0:
            doubts.append(
                Doubt(
                    "lag of the rotors",
                    f"is not said; {LAG:g} s is assumed",
                    "say lag, from a step of thrust",
                )
            )
        sections.append(
            RotorSection(
                link=rotor.link,
                spin=1 if spin > 0 else -1,
                drag_torque_coefficient=kappa
                if rotor.drag_torque_coefficient is None
                else rotor.drag_torque_coefficient,
                thrust_min=low,
                thrust_max=high,
                lag=lag or LAG,
                xyz=rotor.xyz,
                rpy=rotor.rpy,
            )
        )
    return tuple(sections)


def _drag(tree: UrdfTree, sources: Sources, doubts: list[Doubt]) -> tuple[float, int]:
    """Drag torque per thrust, and -1 where the file counts its sense of spin the other way round."""
    element = tree.root.find("m_f_rate")
    said = float("nan")
    if element is not None:
        try:
            said = float(element.get("value") or "nan")
        except ValueError:
            said = float("nan")
    table = sources.motors.drag_torque_coefficient if sources.motors else None
    if math.isfinite(said):
        if table is not None and abs(abs(said) - table) > _FAR_APART * max(abs(said), table):
            doubts.append(
                Doubt(
                    "drag torque per thrust",
                    f"is {abs(said):g} m in the URDF and {table:g} m in {_told(sources.motors)}; the "
                    "URDF's is taken",
                    "measure it, and correct one of the two",
                )
            )
        return abs(said), -1 if said > 0.0 else 1
    if table is not None:
        return table, 1
    doubts.append(
        Doubt(
            "drag torque per thrust",
            f"is not said; {KAPPA:g} m is assumed",
            "say drag_torque_coefficient in a mapping file",
        )
    )
    return KAPPA, 1


def _thrusts(
    k: int, rotor: MappedRotor, axle: dict[str, float], share: float, sources: Sources, doubts: list[Doubt]
) -> tuple[float, float]:
    low, high = axle.get("lower", math.nan), axle.get("upper", math.nan)
    usable = (
        math.isfinite(low) and math.isfinite(high) and 0.0 <= low < high < _BELIEVED and high != 2 * math.pi
    )
    motors = sources.motors
    table = motors.thrust_max if motors else None
    most = rotor.thrust_max or (high if usable else None)
    if most is not None and table is not None and rotor.thrust_max is None:
        if abs(most - table) > _FAR_APART * table and k == 0:
            doubts.append(
                Doubt(
                    "greatest thrust",
                    f"is {most:g} N in the URDF and {table:g} N in {_told(motors)}; the smaller is taken",
                    "say thrust_max in a mapping file, as measured",
                )
            )
        most = min(most, table)
    if most is None:
        most = table
    if most is None:
        most = round(THRUST_TO_WEIGHT * share, 2)
        if k == 0:
            doubts.append(
                Doubt(
                    "greatest thrust",
                    f"is not said; {THRUST_TO_WEIGHT:g} times the weight is assumed, {most:g} N a rotor",
                    "say thrust_max in a mapping file",
                )
            )
    least = rotor.thrust_min if rotor.thrust_min is not None else low if usable else None
    if least is None:
        least = motors.thrust_min if motors and motors.thrust_min is not None else min(THRUST_MIN, 0.1 * most)
    return (least, most) if least < most else (0.0, most)


def _told(motors: MotorTable | None) -> str:
    """Name of the table, and the voltage that its thrust is for."""
    if motors is None:
        return ""
    return motors.path.name if motors.voltage is None else f"{motors.path.name} (at {motors.voltage:g} V)"


def _servo(group: str, tree: UrdfTree, joints: tuple[Element, ...], sources: Sources) -> Servo:
    table, assumed = sources.servos.get(group), _SERVOS[group]
    effort = min((tree.limit(joint, "effort") for joint in joints), default=assumed.torque_limit)
    speed = min((tree.limit(joint, "velocity") for joint in joints), default=assumed.speed_limit)
    return Servo(
        stiffness=table.stiffness if table else assumed.stiffness,
        damping=table.damping if table else assumed.damping,
        torque_limit=float(np.clip(effort, 1e-3, 1e5)),
        speed_limit=float(np.clip(speed, 1e-3, 1e3)),
    )


def _tip(tree: UrdfTree, roles: Roles, doubts: list[Doubt]) -> TipSection:
    """The end of the last link of the longest chain, or a stick in front of a robot that does not bend."""
    names = {joint.get("name") for joint in roles.shape}
    links = [tree.end(joint, "child") or "" for joint in roles.shape]
    if links:
        depth = {link: sum(j.get("name") in names for j in tree.path_up(link)) for link in links}
        last = max(links, key=lambda link: (depth[link], link))
        ends = [tree.place(joint)[0] for joint in tree.path_up(last) if joint.get("name") in names]
        length = max((float(np.linalg.norm(xyz)) for xyz in ends), default=0.0) or 0.3
        position = (round(length, 4), 0.0, 0.0)
        tip = TipSection(last, position, _TIP_RADIUS)
    else:
        reach = max(
            (float(np.linalg.norm(_from_base(tree, rotor.link)[:2])) for rotor in roles.rotors), default=0.3
        )
        tip = TipSection(tree.base(), (round(reach + _STICK, 4), 0.0, 0.0), _TIP_RADIUS, (0.0, 0.0, 0.0))
    x, y, z = tip.position
    doubts.append(
        Doubt(
            "the tip",
            f"is not said; ({x:g}, {y:g}, {z:g}) m of link '{tip.link}' is assumed",
            "say [tip] in a mapping file",
        )
    )
    return tip


def _from_base(tree: UrdfTree, link: str) -> np.ndarray:
    """Origin of a link in the root's frame, joints at zero."""
    point = np.zeros(3)
    for joint in tree.path_up(link):
        xyz, R = tree.place(joint)
        point = xyz + R @ point
    return point
