"""Where the preset `following` is stable in contact, by the linearised closed loop and by flights.

    python benchmarks/stability.py          (three minutes; docs/stability.json, a figure, a section)

Gains are read from the preset. Written anew is the section between the markers of
docs/reports/following_results.md.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
from pathlib import Path
from typing import Any

# Matrices of this size are faster on one thread.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mujoco
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import skylimb
from skylimb.analysis.figures.style import styled
from skylimb.base.errors import ConfigError, UnreachableError
from skylimb.control.cascade import Cascade
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.studies.verification.stability import (
    Mode,
    OperatingPoint,
    at,
    edge,
    flown_growth,
    linearise,
    operating_point,
    stability_map,
)

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS, FIGURE = (
    DOCS / "reports" / "following_results.md",
    DOCS / "stability.json",
    DOCS / "images" / "stability.png",
)
CONTROLLERS = ("following", "impedance", "hybrid")

QUICK: dict[str, Any] = {"phases.hover": 1.0, "phases.tare": 1.0, "sensors.latency": 0.02}
REST = {**QUICK, "surface.friction": 0.0, "trajectory.shape": "hold"}
SLIDE = {
    **QUICK,
    "trajectory.shape": "line",
    "trajectory.length": 0.4,
    "trajectory.speed": 0.07,
    "trajectory.feedforward": "full",
    "approach.standoff": 0.14,
    "surface.position": [1.6, 0.0, 1.2],
}
SLIDES = [
    (slope, way, friction) for slope in (20, -20) for way in (1, -1) for friction in (0.1, 0.4, 0.6, 0.8)
]
CALM: dict[str, Any] = {
    "translation.press_damping": 6.0,
    "translation.press_mass_ratio": 1.0,
    "attitude.normalized_stiffness": [80.0, 80.0, 13.0],
}
"""Gains that slide with little bouncing, to reach a point; the forces there are those of the preset."""

STIFFNESS = np.geomspace(300.0, 50e3, 9)
LATENCY = np.linspace(0.0, 0.1, 11)
PANELS: list[tuple[str, dict[str, np.ndarray]]] = [
    ("latency, 20 ms assumed", {"latency": LATENCY, "stiffness": STIFFNESS}),
    (
        "latency, true and assumed",
        {"latency": LATENCY, "estimation.delay.latency": np.linspace(0.0, 0.075, 11)},
    ),
    ("press damping", {"x translation.press_damping": np.geomspace(0.3, 10.0, 11), "stiffness": STIFFNESS}),
    ("force integral", {"x translation.force_integral": np.geomspace(0.3, 40.0, 11), "stiffness": STIFFNESS}),
]
LABELS = {
    "stiffness": ("stiffness of the surface (N/mm)", 1e-3),
    "latency": ("true latency (ms)", 1e3),
    "estimation.delay.latency": ("assumed latency (ms)", 1e3),
    "x translation.press_damping": ("press damping over the preset's", 1.0),
    "x translation.force_integral": ("force integral over the preset's", 1.0),
}
EDGES = {
    "latency": (0.02, 0.1),
    "x translation.press_damping": (1.0, 30.0),
    "x translation.force_integral": (1.0, 100.0),
}
STICKS = 0.01
"""Speed of the pen below which it sticks, m/s."""

_MARGIN = 0.12
"""How far from an edge flights check it, as a fraction."""


def point_of(name: str, settings: dict[str, Any], reach: dict[str, Any] | None = None) -> OperatingPoint:
    """Where the preset is linearised; `reach` are gains to get there with."""
    experiment = skylimb.load_experiment("paper", settings)
    robot = skylimb.load_robot(experiment.robot)
    own, flying = (skylimb.load_controller(name, robot, changes) for changes in (None, reach))
    assert isinstance(own, Cascade)
    assert isinstance(flying, Cascade)
    point = operating_point(experiment, flying)
    return dataclasses.replace(point, gains=point.tick.gains_layout.pack(own.gains()))


def slide_settings(slope: float, direction: int, friction: float) -> dict[str, Any]:
    return {
        **SLIDE,
        "surface.slope": math.radians(slope),
        "trajectory.direction": direction,
        "surface.friction": friction,
    }


def edges(point: OperatingPoint, axes: dict[str, tuple[float, float]]) -> dict[str, float | None]:
    """The edge along each axis; None where there is none, up to the end of the range."""
    found: dict[str, float | None] = {}
    for axis, (inside, outside) in axes.items():
        try:
            found[axis] = edge(point, axis, inside, outside, steps=12)
        except ConfigError:
            found[axis] = None
    return found


def checked(point: OperatingPoint, found: dict[str, float | None]) -> list[dict[str, Any]]:
    """Flights just inside and just outside of each edge."""
    rows = []
    for axis, value in found.items():
        if value is None:
            continue
        for factor in (1.0 - _MARGIN, 1.0 + _MARGIN):
            there = at(point, axis, value * factor)
            loop = linearise(there)
            mode = max(
                (mode for mode in loop.modes(20) if mode.frequency > 0.05), key=lambda mode: mode.growth
            )
            rows.append(
                {
                    "axis": axis,
                    "value": value * factor,
                    "frequency": mode.frequency,
                    "growth": mode.growth,
                    "flown": flown_growth(there, loop, mode, 1.0),
                }
            )
    return rows


def told(point: OperatingPoint) -> dict[str, Any]:
    """The slowest mode at a point, the swing that dies slowest, and the one that is damped least."""
    loop = linearise(point)
    data = point.data()
    swings = [mode for mode in loop.modes(len(loop.names)) if mode.frequency > 0.1]
    force = -point.plant.surface.stiffness * data.contact[0].dist if data.ncon else 0.0
    slowest = max(swings, key=lambda mode: mode.growth)
    return {
        "force": float(force),
        "speed": tip_speed(point),
        "growth": loop.growth,
        "slowest_swing": as_record(slowest) | {"flown": flown_growth(point, loop, slowest, 0.3)},
        "least_damped_swing": as_record(min(swings, key=lambda mode: mode.damping_ratio)),
    }


def tip_speed(point: OperatingPoint) -> float:
    data, velocity = point.data(), np.zeros(6)
    site = point.plant.model.site(TIP_SITE).id
    mujoco.mj_objectVelocity(point.plant.model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
    return float(np.linalg.norm(velocity[3:]))


def as_record(mode: Mode) -> dict[str, Any]:
    return {
        "frequency": mode.frequency,
        "growth": mode.growth,
        "damping_ratio": mode.damping_ratio,
        "parts": dict(mode.parts[:4]),
    }


@styled
def draw(maps: list[xarray.Dataset], points: list[dict[str, Any]]) -> None:
    figure = Figure(figsize=(7.16, 5.2), layout="constrained")
    axes = figure.subplots(2, 2)
    shown = None
    for (title, axis_values), data, ax in zip(PANELS, maps, axes.flat, strict=True):
        shown = panel(ax, title, list(axis_values), data)
        for row in points:
            if row["axis"] == next(iter(axis_values)) and "stiffness" in axis_values:
                grows = row["flown"] > 0.0
                scale = LABELS[row["axis"]][1]
                ax.plot(row["value"] * scale, 5.0, "x" if grows else "o", color="k", ms=5, mfc="none")
    assert shown is not None
    bar = figure.colorbar(shown, ax=axes, shrink=0.8)
    bar.set_label("growth of the dominant mode (1/s)")
    figure.savefig(FIGURE, dpi=110, metadata={"Software": None})


def panel(ax: Axes, title: str, names: list[str], data: xarray.Dataset) -> Any:
    (x_name, y_name), values = names, data.growth.transpose(*reversed(names)).to_numpy()
    (x_label, x_scale), (y_label, y_scale) = LABELS[x_name], LABELS[y_name]
    x, y = data[x_name].to_numpy() * x_scale, data[y_name].to_numpy() * y_scale
    levels = np.array([-1.0, -0.5, -0.25, -0.1, 0.0, 0.5, 1.0, 2.0, 4.0])
    shown = ax.contourf(x, y, values, levels=levels, cmap="RdBu_r", norm=_norm(levels), extend="both")
    if values.min() < 0.0 < values.max():
        ax.contour(x, y, values, levels=[0.0], colors="k", linewidths=1.2)
    if x_name.startswith("x "):
        ax.set_xscale("log")
    if y_name == "stiffness":
        ax.set_yscale("log")
    ax.set(xlabel=x_label, ylabel=y_label, title=title)
    return shown


def _norm(levels: np.ndarray) -> Any:
    from matplotlib.colors import BoundaryNorm

    return BoundaryNorm(levels, 256, extend="both")


def section(numbers: dict[str, Any]) -> str:
    """The part of the page that says what was found."""
    rest = numbers["rest"]
    lines = [
        "At rest on the paper's slope, without friction, 5 N/mm, 20 ms of latency. An edge is where the",
        "dominant mode neither grows nor dies; - means none within the range (100 ms; 30 and 100 times the",
        "gain).",
        "",
        "| preset | slowest mode (1/s) | least damped swing | edge in true latency "
        "| in press damping | in force integral |",
        "|---|---|---|---|---|---|",
    ]
    for name, row in rest.items():
        found, swing = row["edges"], row["least_damped_swing"]
        latency = found.get("latency")
        cells = [
            f"{row['growth']:.2f}",
            f"{swing['frequency']:.2f} Hz, damping ratio {swing['damping_ratio']:.2f}",
            "-" if latency is None else f"{1e3 * latency:.0f} ms",
            *(
                "-" if found.get(axis) is None else f"{found[axis]:.1f} times the preset's"
                for axis in list(EDGES)[1:]
            ),
        ]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    lines += [
        "",
        "Flights just inside and just outside of those edges, nudged along the mode:",
        "",
        "| parameter | value | mode | growth, linear (1/s) | growth, flown (1/s) |",
        "|---|---|---|---|---|",
    ]
    for row in numbers["flights"]:
        label, scale = LABELS[row["axis"]]
        lines.append(
            f"| {label} | {row['value'] * scale:.3g} | {row['frequency']:.2f} Hz | {row['growth']:.2f} "
            f"| {row['flown']:.2f} |"
        )
    lines += [
        "",
        "On a straight way along y at 0.07 m/s, on boards of both slopes, both ways. Every point is reached",
        "with calmer gains, which push as hard, and linearised with the preset's. A pen that sticks at that",
        "moment says nothing of the slide. The last column is flown for 0.3 s; where it is far from the",
        "linear growth, something changes within that time (a servo that stuck begins to turn), and the",
        "linear loop of that moment says little.",
        "",
        "| slope | way | friction | force (N) | least damped swing | swing that dies slowest | flown (1/s) |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in numbers["slides"]:
        away = row["slope"] * row["direction"] > 0
        head = (
            f"| {row['slope']} degrees | {'board recedes' if away else 'board comes'} | {row['friction']} |"
        )
        if "lost" in row:
            lines.append(f"{head} - | {row['lost']} | | |")
            continue
        if row["speed"] < STICKS:
            lines.append(f"{head} {row['force']:.2f} | the pen sticks | | |")
            continue
        slow, weak = row["slowest_swing"], row["least_damped_swing"]
        lines.append(
            f"{head} {row['force']:.2f} "
            f"| {weak['frequency']:.2f} Hz, damping ratio {weak['damping_ratio']:.2f} "
            f"| {slow['frequency']:.2f} Hz, {slow['growth']:+.2f} 1/s | {slow['flown']:+.2f} |"
        )
    return "\n".join(lines)


def fill(name: str, text: str) -> None:
    """Put a text between the page's markers of that name."""
    page = PAGE.read_text(encoding="utf-8")
    begin, end = f"<!-- begin: {name} -->", f"<!-- end: {name} -->"
    pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    if not pattern.search(page):
        raise ConfigError(f"{PAGE.name} has no markers {begin} ... {end}")
    PAGE.write_text(pattern.sub(lambda _: f"{begin}\n\n{text}\n\n{end}", page), encoding="utf-8")


def slide_row(slope: int, direction: int, friction: float) -> dict[str, Any]:
    row: dict[str, Any] = {"slope": slope, "direction": direction, "friction": friction}
    try:
        return row | told(point_of("following", slide_settings(slope, direction, friction), CALM))
    except UnreachableError as error:
        return row | {"lost": str(error)}


def main() -> None:
    rest: dict[str, dict[str, Any]] = {}
    flights: list[dict[str, Any]] = []
    point = None
    for name in CONTROLLERS:
        there = point_of(name, REST)
        own = EDGES if name == "following" else {"latency": EDGES["latency"]}
        rest[name] = told(there) | {"edges": edges(there, own)}
        if name == "following":
            point, flights = there, checked(there, rest[name]["edges"])
    assert point is not None
    maps = [stability_map(point, axes) for _, axes in PANELS]
    numbers = {
        "rest": rest,
        "flights": flights,
        "slides": [slide_row(*case) for case in SLIDES],
        "maps": {title: data.to_dict() for (title, _), data in zip(PANELS, maps, strict=True)},
    }
    rounded = json.loads(json.dumps(numbers), parse_float=lambda text: float(f"{float(text):.4g}"))
    NUMBERS.write_text(json.dumps(rounded) + "\n", encoding="utf-8")
    draw(maps, flights)
    fill("stability", section(numbers))
    print(section(numbers))


if __name__ == "__main__":
    main()
