"""Robots made up for tests: chains of links with any joint axes, and multirotors."""

import math
from collections.abc import Sequence
from pathlib import Path

BALL = '<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/>'


def link(name: str, mass: float, com: str = "0 0 0", gyration: float = 0.08) -> str:
    inertia = BALL.format(i=mass * gyration**2)
    inertial = f'<inertial><origin xyz="{com}"/><mass value="{mass}"/>{inertia}</inertial>'
    return f'<link name="{name}">{inertial}</link>\n'


def joint(
    name: str, parent: str, child: str, axis: str = "", xyz: str = "0 0 0", limit: float | None = None
) -> str:
    kind = "fixed" if not axis else "continuous" if limit is None else "revolute"
    bounds = "" if limit is None else f'lower="{-limit}" upper="{limit}"'
    moving = f'<axis xyz="{axis}"/><limit {bounds} effort="10" velocity="2"/>' if axis else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/>{moving}</joint>\n'
    )


def chain(
    folder: Path,
    *,
    links: int = 4,
    bends: Sequence[str] = ("0 0 1",),
    turns: Sequence[str] = ("1 0 0", "0 1 0"),
    turn_limit: float | None = math.pi,
    theta: Sequence[float] = (0.9, 1.2, 1.0),
    thrust_max: float = 30.0,
    more_urdf: str = "",
    tilt: float = 0.0,
) -> Path:
    """A chain of `links`: `bends` are the axes of the joints between two links, `turns` those of each rotor.

    The last bend of each pair of links follows theta; the others stay at zero. Returns the flight TOML.
    """
    parts = [link("link1", 1.2, "0.2 0 0")]
    shape, slope, vectoring, rotors = [], [], [], []
    for k in range(1, links + 1):
        if k > 1:
            parent = f"link{k - 1}"
            for i, axis in enumerate(bends):
                last = i == len(bends) - 1
                child = f"link{k}" if last else f"between{k}_{i}"
                parts.append(link(child, 1.2 if last else 0.1, "0.2 0 0" if last else "0 0 0"))
                name = f"joint{k - 1}_{i}"
                parts.append(joint(name, parent, child, axis, "0.4 0 0" if i == 0 else "0 0 0", limit=1.6))
                shape.append(name)
                slope.append(1.0 if last else 0.0)
                parent = child
        parent = f"link{k}"
        for i, axis in enumerate(turns):
            parts.append(link(f"turn{k}_{i}", 0.2))
            parts.append(
                joint(
                    f"gimbal{k}_{i}",
                    parent,
                    f"turn{k}_{i}",
                    axis,
                    "0.2 0 0" if i == 0 else "0 0 0.02",
                    turn_limit,
                )
            )
            vectoring.append(f"gimbal{k}_{i}")
            parent = f"turn{k}_{i}"
        place = "[0.0, 0.0, 0.05]" if turns else "[0.2, 0.0, 0.05]"
        sign = 1 if k % 2 else -1
        rotors.append(
            f'[[rotors]]\nlink = "{parent}"\nspin = {sign}\nxyz = {place}\nrpy = [{tilt * sign}, 0.0, 0.0]\n'
            f"drag_torque_coefficient = 0.016\nthrust_min = 0.5\nthrust_max = {thrust_max}\nlag = 0.03\n"
        )
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(f'<robot name="made">\n{"".join(parts)}{more_urdf}</robot>\n')
    servo = "{ stiffness = 50.0, damping = 2.0, torque_limit = 10.0, speed_limit = 2.0 }"
    low, high, nominal = theta[0], theta[1], theta[2]
    shape_tables = (
        f"[shape]\njoints = {shape}\nservo = {servo}\n"
        f"[posture]\noffset = {[0.0] * len(slope)}\nslope = {slope}\n"
        f"theta_min = {low}\ntheta_max = {high}\ntheta_nominal = {nominal}\n"
        if shape
        else ""
    )
    vectoring_table = (
        f"[vectoring]\njoints = {vectoring}\nstart = {[0.0] * len(vectoring)}\nservo = {servo}\n"
        if vectoring
        else ""
    )
    text = (
        'name = "made"\nurdf = "robot.urdf"\nmeasured_link = "link1"\n'
        f"{shape_tables}{vectoring_table}"
        f'[tip]\nlink = "link{links}"\nposition = [0.45, 0.0, 0.0]\nradius = 0.01\n' + "\n".join(rotors)
    ).replace("'", '"')
    (folder / "flight.toml").write_text(text)
    return folder / "flight.toml"


def multirotor(
    folder: Path,
    *,
    rotors: int = 6,
    cant: float = 0.35,
    arm: float = 0.3,
    mass: float = 1.2,
    thrust_max: float = 8.0,
    turn_limit: float | None = None,
) -> Path:
    """A multirotor with a stick: each rotor canted about its arm, in turn to both sides.

    With a `turn_limit` each rotor sits on a joint that turns it about its arm instead. Returns the flight
    TOML.
    """
    parts, tables, joints = [link("base", mass, gyration=0.12)], [], []
    for k in range(rotors):
        angle, sign = 2.0 * math.pi * (k + 0.5) / rotors, 1 if k % 2 else -1
        place = f"{arm * math.cos(angle):.6f} {arm * math.sin(angle):.6f} 0"
        rotor = f"rotor{k + 1}"
        if turn_limit is None:
            parts.append(link(rotor, 0.02, gyration=0.01))
            parts.append(joint(f"mount{k + 1}", "base", rotor, xyz=place))
        else:
            axis = f"{math.cos(angle):.6f} {math.sin(angle):.6f} 0"
            parts.append(link(rotor, 0.02, gyration=0.01))
            parts.append(joint(f"turn{k + 1}", "base", rotor, axis, place, turn_limit))
            joints.append(f"turn{k + 1}")
        tilt = cant * sign if turn_limit is None else 0.0
        # A turn about the arm: yaw to the arm, roll by the cant.
        tables.append(
            f'[[rotors]]\nlink = "{rotor}"\nspin = {sign}\n'
            f"rpy = [{tilt}, 0.0, {angle if turn_limit is None else 0.0}]\n"
            f"drag_torque_coefficient = 0.016\nthrust_min = 0.2\nthrust_max = {thrust_max}\nlag = 0.02\n"
        )
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(f'<robot name="made">\n{"".join(parts)}</robot>\n')
    names = ", ".join(f'"{name}"' for name in joints)
    vectoring = (
        f"[vectoring]\njoints = [{names}]\nstart = {[0.1] * len(joints)}\n"
        "servo = { stiffness = 5.0, damping = 0.1, torque_limit = 3.0, speed_limit = 5.0 }\n"
        if joints
        else ""
    )
    (folder / "flight.toml").write_text(
        f'name = "made"\nurdf = "robot.urdf"\nmeasured_link = "base"\n{vectoring}'
        '[tip]\nlink = "base"\nposition = [0.6, 0.0, 0.0]\nradius = 0.01\n' + "\n".join(tables)
    )
    return folder / "flight.toml"
