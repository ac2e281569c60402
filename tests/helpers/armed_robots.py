"""URDFs of multirotors with arms as their makers write them: names, drawings and limits of the field."""

from __future__ import annotations

import math
from pathlib import Path

Joint = tuple[str, str, float]
"""Name, axis, and length of the link behind it along x, m."""

TWO: tuple[Joint, ...] = (("shoulder_pitch", "0 1 0", 0.25), ("elbow_pitch", "0 1 0", 0.25))
SIX: tuple[Joint, ...] = (
    ("shoulder_yaw", "0 0 1", 0.04),
    ("shoulder_pitch", "0 1 0", 0.25),
    ("elbow_pitch", "0 1 0", 0.15),
    ("forearm_roll", "1 0 0", 0.1),
    ("wrist_pitch", "0 1 0", 0.05),
    ("wrist_roll", "1 0 0", 0.05),
)


def multirotor_with_arm(
    path: Path,
    *,
    rotors: int = 4,
    joints: tuple[Joint, ...] = TWO,
    radius: float = 0.12,
    place: float = 0.25,
    mass: float = 1.6,
    thrust: float = 12.0,
    cant: float = 0.0,
    stick: float = 0.0,
    tool: str = "0 0 0",
    limit: float = 1.57,
) -> Path:
    """Write a multirotor with an arm under its nose that ends in a fixed link called `tool0`.

    Args:
        path: of the URDF.
        rotors: how many.
        joints: of the arm, from the base on.
        radius: of the drawn propellers, m.
        place: of the rotors from the middle, m.
        mass: of the base, kg.
        thrust: greatest of a rotor, N, as the limit of its axle.
        stick: length of a stick between the base, or the last joint, and the tool, m.
        cant: turn of each rotor about its arm, in turn to both sides, rad.
        tool: roll, pitch and yaw of the tool's frame.
        limit: of every joint, rad.
    """
    parts = [_link("base_link", mass, 0.1, _box("0.2 0.2 0.08", "0 0 0"))]
    for k in range(rotors):
        angle, sign = 2.0 * math.pi * (k + 0.5) / rotors, 1 if k % 2 else -1
        x, y = place * math.cos(angle), place * math.sin(angle)
        disc = f'<visual><geometry><cylinder radius="{radius}" length="0.01"/></geometry></visual>'
        parts.append(_link(f"propeller_{k}", 0.02, 0.05, disc))
        parts.append(
            _joint(
                f"rotor_{k}_joint",
                "continuous",
                "base_link",
                f"propeller_{k}",
                f"0 0 {sign}",
                f"{x} {y} 0.05",
                f'<limit lower="0" upper="{thrust}" effort="10" velocity="1000"/>',
                f"{cant * sign} 0 {angle}",
            )
        )
    above, at = "base_link", "0.1 0 -0.06"
    for name, axis, length in joints:
        child = name.replace("_pitch", "").replace("_yaw", "_turn") + "_link"
        rod = _box(f"{length} 0.02 0.02", f"{0.5 * length} 0 0")
        parts.append(_link(child, 0.06, 0.04, rod, f"{0.5 * length} 0 0"))
        bounds = f'<limit lower="{-limit}" upper="{limit}" effort="4" velocity="2"/>'
        parts.append(_joint(name, "revolute", above, child, axis, at, bounds))
        above, at = child, f"{length} 0 0"
    end = [float(part) for part in at.split()]
    parts.append(_link("tool0", 0.0, 0.0, ""))
    place_of_tool = f"{end[0] + stick} {end[1]} {end[2]}"
    parts.append(_joint("tool0_fixed", "fixed", above, "tool0", "1 0 0", place_of_tool, "", tool))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<robot name="{path.stem}">\n{"".join(parts)}</robot>\n', encoding="utf-8")
    return path


def _link(name: str, mass: float, gyration: float, drawn: str, middle: str = "0 0 0") -> str:
    i = mass * gyration**2
    body = (
        f'<inertial><origin xyz="{middle}"/><mass value="{mass}"/>'
        f'<inertia ixx="{i}" iyy="{i}" izz="{1.5 * i}" ixy="0" ixz="0" iyz="0"/></inertial>'
        if mass
        else ""
    )
    return f'<link name="{name}">{body}{drawn}</link>\n'


def _box(size: str, middle: str) -> str:
    return f'<visual><origin xyz="{middle}"/><geometry><box size="{size}"/></geometry></visual>'


def _joint(
    name: str, kind: str, parent: str, child: str, axis: str, xyz: str, bounds: str, rpy: str = "0 0 0"
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{bounds}</joint>\n'
    )
