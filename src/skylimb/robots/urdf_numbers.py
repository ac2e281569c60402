"""Which text of a URDF should be a number and is none: its reader says the text alone."""

from __future__ import annotations

from xml.etree.ElementTree import Element

_NUMBERS = {
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
    "mimic": ("multiplier", "offset"),
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "mesh": ("scale",),
}


def odd_number(robot: Element) -> str:
    """The first text in a <robot> that should be a number and is none, with its link or joint; else empty."""
    for part in (*robot.findall("link"), *robot.findall("joint")):
        for element in part.iter():
            for key in _NUMBERS.get(element.tag, ()):
                text = element.get(key, "")
                if not all(map(is_number, text.split())):
                    comma = "; a decimal point is meant?" if "," in text else ""
                    name = f"{part.tag} '{part.get('name', '')}'"
                    return f"{key} = '{text[:60]}' of <{element.tag}> in {name} is no number{comma}"
    return ""


def is_number(text: str) -> bool:
    """Whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True
