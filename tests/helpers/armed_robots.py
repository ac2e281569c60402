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
    mount: str = "0.1 0 -0.06",
    turned: str = "0 0 0",
    layers: tuple[float, ...] = (0.05,),
    turning: float = 0.0,
    fixed: tuple[int, ...] = (),
    least: float = 0.0,
    heavy: float = 0.0,
    ahead: float = 0.5,
) -> Path:
    """Write a multirotor with an arm that ends in a fixed link called `tool0`, by default under its nose.

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
        mount: where arm or stick begin, m.
        turned: roll, pitch and yaw of the arm's or stick's x axis there.
        layers: heights of the rotors, m; with two, each place has two rotors that turn against each other.
        turning: travel of a joint along each rotor's arm that turns it, rad; 0 where there is none.
        fixed: arms, by number, that do not turn all the same.
        least: thrust of a rotor, N.
        heavy: mass of a battery 0.35 m ahead, kg.
        ahead: where the first rotor is, in rotors from the nose; 0 for one right there.
    """
    whole = mass + heavy
    middle = f"{0.35 * heavy / whole} 0 0"
    parts = [_link("base_link", whole, 0.1, _box("0.2 0.2 0.08", "0 0 0"), middle)]
    for k in range(rotors * len(layers)):
        corner, layer = k % rotors, k // rotors
        angle, sign = 2.0 * math.pi * (corner + ahead) / rotors, 1 if (corner + layer) % 2 else -1
        if rotors % 2 and len(layers) == 2:
            sign = 1 if layer else -1
        x, y = place * math.cos(angle), place * math.sin(angle)
        above, at, canted = "base_link", f"{x} {y} {layers[layer]}", f"{cant * sign} 0 {angle}"
        if turning and corner not in fixed:
            parts.append(_link(f"arm_{k}", 0.05, 0.02, ""))
            parts.append(
                _joint(
                    f"gimbal{k + 1}", "revolute", above, f"arm_{k}", "1 0 0", at,
                    f'<limit lower="{-turning}" upper="{turning}" effort="3" velocity="5"/>', f"0 0 {angle}",
                )
            )  # fmt: skip
            above, at, canted = f"arm_{k}", "0 0 0", f"{cant * sign} 0 0"
        disc = f'<visual><geometry><cylinder radius="{radius}" length="0.01"/></geometry></visual>'
        parts.append(_link(f"propeller_{k}", 0.02, 0.05, disc))
        parts.append(
            _joint(
                f"rotor_{k}_joint",
                "continuous",
                above,
                f"propeller_{k}",
                f"0 0 {sign}",
                at,
                f'<limit lower="{least}" upper="{thrust}" effort="10" velocity="1000"/>',
                canted,
            )
        )
    above, at = "base_link", mount
    if turned != "0 0 0":
        parts.append(_link("mount", 0.01, 0.02, ""))
        parts.append(_joint("mount_fixed", "fixed", above, "mount", "1 0 0", at, "", turned))
        above, at = "mount", "0 0 0"
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
