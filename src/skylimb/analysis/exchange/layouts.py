"""Layout files with the plots that matter, for Foxglove and for PlotJuggler, of what `write_log` writes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from itertools import cycle
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from skylimb.analysis.exchange.containers import container_of
from skylimb.analysis.exchange.lab_topics import NAMESPACE
from skylimb.analysis.exchange.stream import Message
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


class Plot(NamedTuple):
    """A plot: its title, and its curves."""

    title: str
    curves: tuple[Curve, ...]


class Shown(NamedTuple):
    """What a log has to plot.

    Attributes:
        topics: whole names.
        rotors: how many.
        joints: names, in the order of joint_states.
    """

    topics: frozenset[str]
    rotors: int
    joints: tuple[str, ...]


def shown_of(messages: Iterable[Message], namespace: str = NAMESPACE) -> Shown:
    """What the first second of a log has to plot."""
    topics, rotors, joints, begin = set[str](), 0, tuple[str, ...](), None
    for message in messages:
        begin = message.time if begin is None else begin
        if message.time - begin > _BEGINNING:
            break
        topics.add(message.topic)
        if message.topic == f"/{namespace}/{THRUSTS}":
            rotors = len(message.value.base_thrust)
        elif message.topic == f"/{namespace}/{JOINT_STATES}":
            joints = tuple(message.value.name)
    return Shown(frozenset(topics), rotors, joints)


def plots(shown: Shown, namespace: str = NAMESPACE) -> tuple[Plot, ...]:
    """The plots of what a log has, in rows of two; curves of topics that it lacks are left out."""
    wrench, contact, cog = "estimated_external_wrench", "skylimb/contact_wrench", "uav/cog/odom"
    forces = (*_xyz(wrench, "wrench.force"), *_xyz(contact, "wrench.force"))
    torques = (*_xyz(wrench, "wrench.torque"), *_xyz(contact, "wrench.torque"))
    places = (*_xyz(cog, "pose.pose.position"), *_xyz("skylimb/cog_reference", "point"))
    thrusts = tuple(Curve(THRUSTS, f"base_thrust[{i}]") for i in range(shown.rotors))
    angles = tuple(Curve(JOINT_STATES, f"position[{i}]", name) for i, name in enumerate(shown.joints))
    chosen = (
        Plot("Force: estimate and truth (N)", forces),
        Plot("Torque: estimate and truth (N m)", torques),
        Plot("Centre of gravity and reference (m)", places),
        Plot("Its velocity (m/s)", _xyz(cog, "twist.twist.linear")),
        Plot("Thrusts (N)", thrusts),
        Plot("Joints and gimbals (rad)", angles),
    )
    found = []
    for title, curves in chosen:
        whole = (curve._replace(topic=f"/{namespace}/{curve.topic}") for curve in curves)
        there = tuple(curve for curve in whole if curve.topic in shown.topics)
        if there:
            found.append(Plot(title, there))
    return tuple(found)


def _xyz(topic: str, field: str) -> tuple[Curve, ...]:
    return tuple(Curve(topic, f"{field}.{axis}") for axis in "xyz")


def foxglove_layout(chosen: Sequence[Plot]) -> str:
    """The layout as Foxglove imports it: plots in a mosaic, two in a row."""
    panels = {
        f"Plot!skylimb{index}": {
            "foxglovePanelTitle": plot.title,
            "paths": [
                {"value": curve.foxglove, "enabled": True, "timestampMethod": "receiveTime", "color": colour}
                for curve, colour in zip(plot.curves, cycle(COLOURS), strict=False)
            ],
            "xAxisVal": "timestamp",
            "showLegend": True,
            "isSynced": True,
        }
        for index, plot in enumerate(chosen)
    }
    names = list(panels)
    pairs = [names[i : i + 2] for i in range(0, len(names), 2)]
    rows: list[object] = [
        {"direction": "row", "first": pair[0], "second": pair[1], "splitPercentage": 50}
        if len(pair) == 2
        else pair[0]
        for pair in pairs
    ]
    return json.dumps(
        {
            "configById": panels,
            "globalVariables": {},
            "userNodes": {},
            "playbackConfig": {"speed": 1},
            "layout": _column(rows),
        },
        indent=1,
    )


def _column(rows: Sequence[object]) -> object:
    """Rows of equal height, one below the other."""
    if len(rows) == 1:
        return rows[0]
    share = 100.0 / len(rows)
    return {"direction": "column", "first": rows[0], "second": _column(rows[1:]), "splitPercentage": share}


def plotjuggler_layout(chosen: Sequence[Plot]) -> str:
    """The layout as PlotJuggler loads it."""
    root = ElementTree.Element("root")
    tabs = ElementTree.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    tab = ElementTree.SubElement(tabs, "Tab", {"tab_name": "skylimb", "containers": "1"})
    container = ElementTree.SubElement(tab, "Container")
    rows = [chosen[i : i + 2] for i in range(0, len(chosen), 2)]
    down = _splitter(container, "-", len(rows))
    for row in rows:
        across = _splitter(down, "|", len(row))
        for plot in row:
            area = ElementTree.SubElement(across, "DockArea", {"name": plot.title})
            shown = ElementTree.SubElement(area, "plot", {"mode": "TimeSeries", "style": "Lines"})
            for curve, colour in zip(plot.curves, cycle(COLOURS), strict=False):
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
        chosen = plots(shown_of(messages, namespace), namespace)
    written = []
    for ending, text in (
        (".foxglove.json", foxglove_layout(chosen)),
        (".plotjuggler.xml", plotjuggler_layout(chosen)),
    ):
        path = Path(log).with_suffix(ending)
        with new_file(path) as aside:
            aside.write_text(text, encoding="utf-8")
        written.append(path)
    return written
