"""Robots that the table of robots flies besides those that ship: other kinds, and multirotors with arms.

All are made by `tests/helpers/armed_robots.py`, as their makers write them; sizes and masses are those of
robots of that kind. What a file cannot say stands in a mapping, a line each.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from armed_robots import SIX, TWO


class Made(NamedTuple):
    """What `multirotor_with_arm` is given, and the mapping that the robot needs."""

    given: dict[str, Any]
    mapping: str = ""


THREE = (*TWO, ("wrist_pitch", "0 1 0", 0.08))
PLAIN = (("m1", "0 1 0", 0.25), ("m2", "0 1 0", 0.25))
ARM: dict[str, Any] = {"joints": TWO}
STICK: dict[str, Any] = {"joints": (), "stick": 0.45}
HEX: dict[str, Any] = {"rotors": 6, "place": 0.32, "mass": 2.2}
OCTO: dict[str, Any] = {"rotors": 8, "place": 0.36, "mass": 3.0, "radius": 0.1}
CANTED: dict[str, Any] = {"rotors": 6, "place": 0.32, "cant": 0.3}
DOWN = "posture = {{ offset = [{0}], slope = [{1}], theta_min = 0.3, theta_max = 1.0, theta_nominal = 0.6 }}"
TWO_DOWN, SIX_DOWN = (
    DOWN.format("1.2, 0.0", "0.0, 0.6"),
    DOWN.format("0, 1.2, 0, 0, 0, 0", "0, 0, 0.6, 0, 0, 0"),
)

KINDS = {
    "X8: four arms, rotors above each other": Made({**STICK, "layers": (0.08, -0.02), "mass": 2.2}),
    "Y6: three arms, rotors above each other": Made(
        {**STICK, "rotors": 3, "layers": (0.08, -0.02), "place": 0.3, "mass": 2.0}
    ),
    "quadrotor +": Made({**STICK, "ahead": 0.0, "stick": 0.55}),
    "decacopter": Made({**STICK, "rotors": 10, "place": 0.45, "mass": 3.5, "radius": 0.1, "stick": 0.6}),
    "hexarotor, heavy in front": Made({**HEX, "joints": (), "stick": 0.5, "heavy": 1.2}),
    "hexarotor, too heavy in front": Made({**HEX, "joints": (), "stick": 0.5, "heavy": 3.0}),
    "Tilt-Hex, canted by 20 degrees": Made(
        {**CANTED, "cant": 0.35, "place": 0.39, "mass": 2.5, "joints": (), "stick": 0.5}
    ),
    "tilted octorotor, reversible": Made(
        {**OCTO, "cant": 0.5, "least": -12.0, "joints": (), "stick": 0.5, "mass": 2.0}
    ),
    "quadrotor, each arm turns": Made({**STICK, "turning": 1.5}),
    "tricopter, each arm turns": Made({**STICK, "rotors": 3, "turning": 1.5, "mass": 1.2}),
    "tricopter, its tail turns": Made(
        {**STICK, "rotors": 3, "turning": 1.5, "fixed": (0, 2), "mass": 1.2}
    ),
    "bicopter, each arm turns": Made(
        {**STICK, "rotors": 2, "turning": 1.5, "mass": 0.8, "ahead": 0.5}
    ),
    "bicopter, rotors above its stick": Made(
        {**STICK, "rotors": 2, "turning": 1.5, "mass": 0.8, "layers": (0.15,), "mount": "0.1 0 0"}
    ),
}  # fmt: skip
"""Robots of other kinds, with a stick."""

ARMED = {
    "quadrotor, 2 joints": Made(ARM),
    "quadrotor, 2 joints, tool's z forward": Made({**ARM, "tool": "0 1.5708 0"}),
    "quadrotor, 1 joint": Made({"joints": TWO[:1], "stick": 0.2}),
    "quadrotor, 3 joints": Made({"joints": THREE}),
    "quadrotor, plain names": Made({"joints": PLAIN}),
    "quadrotor, stick": Made(STICK),
    "quadrotor, stick down": Made({**STICK, "mount": "0 0 0", "turned": "0 1.5708 0"}),
    "quadrotor, stick up": Made({**STICK, "mount": "0 0 0.05", "turned": "0 -1.5708 0"}),
    "quadrotor, 2 joints down": Made(ARM, TWO_DOWN),
    "hexarotor, 2 joints": Made({**ARM, **HEX}),
    "hexarotor, 2 joints down": Made({**ARM, **HEX}, TWO_DOWN),
    "hexarotor, 6 joints": Made({"joints": SIX, **HEX}),
    "hexarotor, 6 joints down": Made({"joints": SIX, **HEX}, SIX_DOWN),
    "hexarotor, stick": Made({**HEX, "joints": (), "stick": 0.5}),
    "octorotor, 6 joints": Made({"joints": SIX, **OCTO}),
    "tilted hexarotor, stick": Made({**CANTED, "joints": (), "stick": 0.4}),
    "tilted hexarotor, 2 joints": Made({**ARM, **CANTED, "mass": 2.2}),
    "tilted octorotor, 6 joints": Made({"joints": SIX, **OCTO, "cant": 0.3}),
}
"""Multirotors with arms and sticks."""
