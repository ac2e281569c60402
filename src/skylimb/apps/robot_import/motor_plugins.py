"""Rotors as simulators know them: the motor plugins of RotorS, PX4's Gazebo models and gz-sim."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

from skylimb.apps.robot_import.mapping import MappedRotor
from skylimb.apps.robot_import.tree import UrdfTree
from skylimb.base.config import from_mapping

_WAYS = {"cw": -1, "ccw": 1}


def plugin_rotors(tree: UrdfTree) -> tuple[MappedRotor, ...]:
    """One for each <plugin> with a motorConstant and the name of a link, in the order of motorNumber.

    All three plugins count alike: thrust = motorConstant w^2 along z of the link, up to maxRotVelocity, and a
    drag torque of momentConstant times the thrust.

    Raises:
        ConfigError: a number that no rotor has.
    """
    links, found = set(tree.links()), list[tuple[float, MappedRotor]]()
    for plugin in tree.root.iter("plugin"):
        link, factor = (plugin.findtext("linkName") or "").strip(), _number(plugin, "motorConstant")
        if link not in links or factor is None:
            continue
        fastest = _number(plugin, "maxRotVelocity")
        lags = [_number(plugin, f"timeConstant{way}") for way in ("Up", "Down")]
        said = {
            "drag_torque_coefficient": _number(plugin, "momentConstant"),
            "thrust_max": None if fastest is None else float(f"{factor * fastest * fastest:.6g}"),
            "lag": max((lag for lag in lags if lag is not None), default=None),  # the slower of both
            "thrust_factor": factor,
        }
        said = {key: value for key, value in said.items() if value is not None}
        spin = _WAYS.get((plugin.findtext("turningDirection") or "").strip())
        where = f"the motor plugin of link '{link}'"
        rotor = from_mapping(MappedRotor, {"link": link, "spin": spin, **said}, where)
        found.append((_number(plugin, "motorNumber") or 0.0, rotor))
    return tuple(rotor for _, rotor in sorted(found, key=lambda one: one[0]))


def _number(plugin: Element, tag: str) -> float | None:
    """A positive number of a plugin; None for what is none, so that it is proposed."""
    try:
        value = float(plugin.findtext(tag) or "")
    except ValueError:
        return None
    return value if 0.0 < value < math.inf else None
