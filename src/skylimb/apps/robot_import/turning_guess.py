"""Inertia of a rotor and its thrust over squared speed, where only its link tells of them."""

from __future__ import annotations

import math

from skylimb.apps.robot_import.doubts import Doubt
from skylimb.apps.robot_import.mapping import MappedRotor
from skylimb.apps.robot_import.tree import UrdfTree, number

_HEAVIEST, _SMALLEST, _LARGEST = 0.3, 0.02, 0.4
"""A link is a rotor alone up to this mass (kg), and with a disc's radius between these (m)."""
_COEFFICIENT = 0.12
"""Of usual propellers, thrust over squared turns a second and diameter to the fourth, kg/m^3: a thrust
coefficient of 0.1 in air."""
_FASTEST, _USUAL = 200.0, 150.0
"""Speed of a propeller's tip that is not believed, and that of a usual one at its greatest thrust, m/s."""


def turning(
    tree: UrdfTree, rotor: MappedRotor, thrust: float, doubts: list[Doubt]
) -> tuple[float | None, float | None]:
    """Inertia of a rotor, kg m^2, and its thrust over squared speed, N s^2; None for what nothing tells.

    Where the rotor has a link of its own, that link's inertia is taken, and the propeller is as large as a
    disc of that mass and inertia. Where such a one would be too fast, as where the link is a motor without
    its propeller, it is as large as usual ones of its thrust.

    Args:
        tree: has the rotor's link.
        rotor: what is said of it.
        thrust: its greatest, N.
        doubts: gets what is assumed.
    """
    inertia, factor, mass = rotor.inertia, rotor.thrust_factor, tree.mass(rotor.link)
    element = tree.link(rotor.link)
    said = number(element.find("inertial/inertia") if element is not None else None, "izz", 0.0)
    radius = math.sqrt(2.0 * said / mass) if said > 0.0 and mass > 0.0 else 0.0
    if mass > _HEAVIEST or not _SMALLEST < radius < _LARGEST:
        return inertia, factor
    if inertia is None:
        inertia = said
        value = f"is not said; {said:.3g} kg m^2 of the rotor's own link is taken"
        doubts.append(
            Doubt("inertia of the rotors", value, "say inertia in a mapping file: propeller and bell")
        )
    if factor is None:
        of = "its link's inertia"
        if _tip_speed(radius, thrust) > _FASTEST:
            radius *= _tip_speed(radius, thrust) / _USUAL
            of = "its thrust, as its link is too small"
        factor = float(f"{_factor(radius):.3g}")
        speed = math.sqrt(thrust / factor)
        turns, tip = _rounded(30.0 * speed / math.pi), _rounded(speed * radius)
        value = (
            f"is not said; {factor:g} N s^2 is assumed, as for a propeller of {2.0 * radius:.2g} m (by "
            f"{of}): {turns} rpm and {tip} m/s at its tip for {thrust:g} N"
        )
        doubts.append(Doubt("thrust over squared speed", value, "say thrust_factor, from a data sheet"))
    return inertia, factor


def _factor(radius: float) -> float:
    """Thrust over squared speed of a usual propeller of a radius (m), N s^2."""
    return _COEFFICIENT * (2.0 * radius) ** 4 / (2.0 * math.pi) ** 2


def _tip_speed(radius: float, thrust: float) -> float:
    """Speed of the tip of such a propeller at a thrust (N), m/s; it falls as the radius grows."""
    return math.sqrt(thrust / _factor(radius)) * radius


def _rounded(value: float) -> str:
    """A number to two digits."""
    return f"{float(f'{value:.2g}'):g}"
