"""Layout files with the plots that matter, for Foxglove and for PlotJuggler, of what `write_log` writes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from skylimb.exchange.lab_topics import NAMESPACE
from skylimb.recording.files import new_file

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")


class Plot(NamedTuple):
    """A plot: its title, and a field of a message for every curve, "topic.field.entry"."""

    title: str
    curves: tuple[str, ...]


def plots(namespace: str = NAMESPACE) -> tuple[Plot, ...]:
    """The plots, in rows of two."""
    wrench, contact = "estimated_external_wrench.wrench", "skylimb/contact_wrench.wrench"
    odometry, wanted = "uav/cog/odom.pose.pose.position", "skylimb/cog_reference.point"
    chosen = (
        Plot("Force: estimate and truth (N)", (*_xyz(f"{wrench}.force"), *_xyz(f"{contact}.force"))),
        Plot("Torque: estimate and truth (N m)", (*_xyz(f"{wrench}.torque"), *_xyz(f"{contact}.torque"))),
        Plot("Centre of gravity and reference (m)", (*_xyz(odometry), *_xyz(wanted))),
        Plot("Its velocity (m/s)", tuple(_xyz("uav/cog/odom.twist.twist.linear"))),
        Plot("Thrusts (N)", tuple(f"four_axes/command.base_thrust[{i}]" for i in range(4))),
        Plot("Joints and gimbals (rad)", tuple(f"joint_states.position[{i}]" for i in range(7))),
    )
    return tuple(Plot(title, tuple(f"/{namespace}/{curve}" for curve in curves)) for title, curves in chosen)


def _xyz(field: str) -> Sequence[str]:
    return [f"{field}.{axis}" for axis in "xyz"]


def foxglove_layout(namespace: str = NAMESPACE) -> str:
    """The layout as Foxglove imports it: plots in a mosaic, two in a row."""
    chosen = plots(namespace)
    panels = {
        f"Plot!skylimb{index}": {
            "foxglovePanelTitle": plot.title,
            "paths": [
                {"value": curve, "enabled": True, "timestampMethod": "receiveTime", "color": colour}
                for curve, colour in zip(plot.curves, COLOURS, strict=False)
            ],
            "xAxisVal": "timestamp",
            "showLegend": True,
            "isSynced": True,
        }
        for index, plot in enumerate(chosen)
    }
    names = list(panels)
    rows: list[object] = [
        {"direction": "row", "first": left, "second": right, "splitPercentage": 50}
        for left, right in zip(names[::2], names[1::2], strict=True)
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


def plotjuggler_layout(namespace: str = NAMESPACE) -> str:
    """The layout as PlotJuggler loads it."""
    root = ElementTree.Element("root")
    tabs = ElementTree.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    chosen = plots(namespace)
    tab = ElementTree.SubElement(tabs, "Tab", {"tab_name": "skylimb", "containers": "1"})
    container = ElementTree.SubElement(tab, "Container")
    rows = [chosen[i : i + 2] for i in range(0, len(chosen), 2)]
    down = _splitter(container, "-", len(rows))
    for row in rows:
        across = _splitter(down, "|", len(row))
        for plot in row:
            area = ElementTree.SubElement(across, "DockArea", {"name": plot.title})
            shown = ElementTree.SubElement(area, "plot", {"mode": "TimeSeries", "style": "Lines"})
            for curve, colour in zip(plot.curves, COLOURS, strict=False):
                ElementTree.SubElement(shown, "curve", {"name": _juggled(curve), "color": colour})
    ElementTree.SubElement(tabs, "currentTabIndex", {"index": "0"})
    ElementTree.indent(root)
    return "<?xml version='1.0' encoding='UTF-8'?>\n" + ElementTree.tostring(root, encoding="unicode") + "\n"


def _splitter(parent: ElementTree.Element, orientation: str, count: int) -> ElementTree.Element:
    sizes = ";".join(f"{1.0 / count:g}" for _ in range(count))
    return ElementTree.SubElement(
        parent, "DockSplitter", {"orientation": orientation, "count": str(count), "sizes": sizes}
    )


def _juggled(curve: str) -> str:
    """A field in PlotJuggler's spelling: slashes all along, entries of a list by number."""
    return curve.replace("[", ".").replace("]", "").replace(".", "/")


def write_layouts(log: str | Path, namespace: str = NAMESPACE) -> list[Path]:
    """Write both layouts beside a log: NAME.foxglove.json and NAME.plotjuggler.xml.

    Raises:
        OutputError: if one exists or cannot be written.
    """
    written = []
    for ending, text in (
        (".foxglove.json", foxglove_layout(namespace)),
        (".plotjuggler.xml", plotjuggler_layout(namespace)),
    ):
        path = Path(log).with_suffix(ending)
        with new_file(path) as aside:
            aside.write_text(text, encoding="utf-8")
        written.append(path)
    return written
