"""Layout files with the plots that matter, for Foxglove and for PlotJuggler, of what `write_log` writes."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

from skylimb.analysis.exchange.containers import container_of
from skylimb.analysis.exchange.lab_topics import NAMESPACE
from skylimb.analysis.exchange.stream import Message, decoded
from skylimb.base.errors import ConfigError
from skylimb.base.files import new_file

THRUSTS, JOINT_STATES = "four_axes/command", "joint_states"
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")


_BEGINNING = 10**9
"""Nanoseconds of a log in which every topic of ours has spoken."""


class Curve(NamedTuple):
    """A number of a message over time.

    Attributes:
        topic: whole name.
        field: "pose.position.x", or "position[3]".
        joint: whose entry of a joint state it is; empty elsewhere.
    """

    topic: str
    field: str
    joint: str = ""

    @property
    def foxglove(self) -> str:
        """As a message path of Foxglove."""
        return f"{self.topic}.{self.field}"

    @property
    def plotjuggler(self) -> str:
        """As PlotJuggler's ROS parser calls it: slashes all along; joint states by the joint's name."""
        if self.joint:
            return f"{self.topic}/{self.joint}/position"
        return f"{self.topic}/{self.field.replace('.', '/')}"


Plots = Mapping[str, Sequence[Curve]]
"""The curves of each plot, by its title."""


def first_second(messages: Iterable[Message]) -> dict[str, Any]:
    """What the first second of a log has: by topic, its first message."""
    found, end = dict[str, Any](), math.inf
    for message in messages:
        end = min(end, message.time + _BEGINNING)
        if message.time > end:
            break
        found.setdefault(message.topic, message.value)
    return found


def plots(known: Mapping[str, Any], namespace: str = NAMESPACE) -> Plots:
    """The plots of what a log has; curves of topics that it lacks are left out.

    Args:
        known: a message of each topic (`first_second`).
        namespace: of the lab's topics.
    """
    thrusts, states = (known.get(f"/{namespace}/{topic}") for topic in (THRUSTS, JOINT_STATES))
    rotors, joints = len(thrusts.base_thrust) if thrusts else 0, states.name if states else ()
    wrench, contact, cog = "estimated_external_wrench", "skylimb/contact_wrench", "uav/cog/odom"
    chosen = {
        "Force: estimate and truth (N)": (*_xyz(wrench, "wrench.force"), *_xyz(contact, "wrench.force")),
        "Torque: estimate and truth (N m)": (*_xyz(wrench, "wrench.torque"), *_xyz(contact, "wrench.torque")),
        "Centre of gravity and reference (m)": (
            *_xyz(cog, "pose.pose.position"),
            *_xyz("skylimb/cog_reference", "point"),
        ),
        "Its velocity (m/s)": _xyz(cog, "twist.twist.linear"),
        "Thrusts (N)": tuple(Curve(THRUSTS, f"base_thrust[{i}]") for i in range(rotors)),
        "Joints and gimbals (rad)": tuple(
            Curve(JOINT_STATES, f"position[{i}]", name) for i, name in enumerate(joints)
        ),
    }
    whole = {
        title: [curve._replace(topic=f"/{namespace}/{curve.topic}") for curve in curves]
        for title, curves in chosen.items()
    }
    there = {title: [one for one in curves if one.topic in known] for title, curves in whole.items()}
    return {title: curves for title, curves in there.items() if curves}


def _xyz(topic: str, field: str) -> tuple[Curve, ...]:
    return tuple(Curve(topic, f"{field}.{axis}") for axis in "xyz")


def foxglove_layout(chosen: Plots) -> str:
    """The layout as Foxglove imports it: plots in a mosaic, two in a row."""
    panels = {
        f"Plot!skylimb{index}": {
            "foxglovePanelTitle": title,
            "paths": [
                {"value": curve.foxglove, "enabled": True, "timestampMethod": "receiveTime", "color": colour}
                for curve, colour in zip(curves, cycle(COLOURS), strict=False)
            ],
            "xAxisVal": "timestamp",
            "showLegend": True,
            "isSynced": True,
        }
        for index, (title, curves) in enumerate(chosen.items())
    }
    layout = _split("column", [_split("row", pair) for pair in _pairs(list(panels))])
    shown = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": layout,
    }
    return json.dumps(shown, indent=1)


def _pairs(items: Sequence[Any]) -> list[Sequence[Any]]:
    return [items[i : i + 2] for i in range(0, len(items), 2)]


def _split(direction: str, parts: Sequence[Any]) -> Any:
    """Parts of equal size beside each other, or one below the other."""
    if len(parts) == 1:
        return parts[0]
    share, rest = 100.0 / len(parts), _split(direction, parts[1:])
    return {"direction": direction, "first": parts[0], "second": rest, "splitPercentage": share}


def plotjuggler_layout(chosen: Plots) -> str:
    """The layout as PlotJuggler loads it."""
    root = ElementTree.Element("root")
    tabs = ElementTree.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    tab = ElementTree.SubElement(tabs, "Tab", {"tab_name": "skylimb", "containers": "1"})
    rows = _pairs(list(chosen.items()))
    down = _splitter(ElementTree.SubElement(tab, "Container"), "-", len(rows))
    for row in rows:
        across = _splitter(down, "|", len(row))
        for title, curves in row:
            area = ElementTree.SubElement(across, "DockArea", {"name": title})
            shown = ElementTree.SubElement(area, "plot", {"mode": "TimeSeries", "style": "Lines"})
            for curve, colour in zip(curves, cycle(COLOURS), strict=False):
                ElementTree.SubElement(shown, "curve", {"name": curve.plotjuggler, "color": colour})
    ElementTree.SubElement(tabs, "currentTabIndex", {"index": "0"})
    ElementTree.indent(root)
    return "<?xml version='1.0' encoding='UTF-8'?>\n" + ElementTree.tostring(root, encoding="unicode") + "\n"


def _splitter(parent: ElementTree.Element, orientation: str, count: int) -> ElementTree.Element:
    sizes = ";".join(f"{1.0 / count:g}" for _ in range(count))
    return ElementTree.SubElement(
        parent, "DockSplitter", {"orientation": orientation, "count": str(count), "sizes": sizes}
    )


def require_layouts(log: str | Path) -> None:
    """Raise a `ConfigError` for a log that neither tool opens."""
    if Path(log).suffix == ".nc":
        raise ConfigError("--layouts is for .bag and .mcap: neither Foxglove nor PlotJuggler opens NetCDF")


def write_layouts(log: str | Path, namespace: str = NAMESPACE) -> list[Path]:
    """Write both layouts of a bag or MCAP file beside it: NAME.foxglove.json and NAME.plotjuggler.xml.

    Raises:
        OutputError: if one exists or cannot be written, or the log cannot be read.
    """
    require_layouts(log)
    with container_of(log).read(Path(log)) as messages:
        chosen = plots(first_second(decoded(messages)), namespace)
    texts = {
        Path(log).with_suffix(".foxglove.json"): foxglove_layout(chosen),
        Path(log).with_suffix(".plotjuggler.xml"): plotjuggler_layout(chosen),
    }
    for path, text in texts.items():
        with new_file(path) as aside:
            aside.write_text(text, encoding="utf-8")
    return list(texts)
