"""A tip that slides: friction, depth, and that it keeps touching."""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.simulation.surfaces import (
    Board,
    Cylinder,
    FrictionMap,
    HeightMap,
    PairFriction,
    Patch,
    Ramp,
    SineWall,
    Sphere,
)
from skylimb.simulation.surfaces.surface import Surface
from skylimb.studies.verification.drawing import family, lines
from skylimb.studies.verification.rig import RADIUS, Bench, Trace
from skylimb.studies.verification.row import Evidence, evidence, sweep

_SPEED = 0.13  # m/s: the paper's circle of 0.30 m in 14 s
_TICK = 0.005  # s between two writes of a friction that varies


def slide(surface: Surface, speed: float, arm: float = 0.0, duration: float = 1.5, **bench: Any) -> Trace:
    """The trace of a tip pressed with 1 N that is drawn along +u at `speed` (m/s), settled."""
    mass = 4.0 if arm else 2.0
    rig = Bench(surface, mass=mass, arm=arm, gap=-1.0 / surface.stiffness, servos="uv", **bench)
    rig.drive(push_w=1.0, speed_u=speed)
    # Along the surface, so that a slope is not hit.
    normal = surface.local_closest(np.zeros(3))[1]
    rig.launch(u=speed, w=-speed * normal[1] / normal[0])
    return rig.run(duration).after(0.5)


def split(surface: Surface, trace: Trace) -> tuple[np.ndarray, np.ndarray]:
    """Normal force (n,) and tangential force (n, 3), in the surface's axes, on a surface of any shape, N."""
    _, normal = surface.local_closest(trace.position)
    pressing = np.sum(trace.force * normal, axis=1)
    return pressing, trace.force - pressing[:, None] * normal


def kinetic_friction() -> Evidence:
    """Drag over normal force is mu."""
    frictions, speeds = np.array([0.1, 0.3, 0.5, 0.8]), np.array([0.05, 0.1, 0.2, 0.3])
    ratio = 100.0 * sweep(_drag, (0.0, 0.3), frictions, speeds)
    drawn = family(speeds, ratio[0] - 100.0, [f"friction {mu:g}" for mu in frictions])
    return evidence(
        "kinetic_friction",
        "Sliding at 0.05 to 0.3 m/s, drag over normal force is mu.",
        ratio,
        100.0,
        0.5,
        "% of mu",
        lines(drawn, "speed (m/s)", "T/N against mu (%)", band=0.5),
    )


def _drag(arm: float, mu: float, speed: float) -> float:
    """Drag over mu times the normal force."""
    surface = Board(friction=mu)
    normal, tangent = split(surface, slide(surface, speed, arm=arm, duration=1.0))
    return float(np.linalg.norm(tangent.mean(axis=0)) / normal.mean() / mu)


def sliding_indentation() -> Evidence:
    """A sliding tip sinks in by F/k, but for what its friction damper carries."""
    stiffnesses, speeds = np.array([200.0, 1e3, 5e3, 2e4]), np.array([0.05, _SPEED])
    found = 100.0 * sweep(_depth, (0.0, 0.3), speeds, stiffnesses)
    drawn = [
        line
        for rows, body, style in zip(found - 100.0, ("block", "arm"), ("o-", "x--"), strict=True)
        for line in family(stiffnesses, rows, [f"{speed:g} m/s, {body}" for speed in speeds], style)
    ]
    return evidence(
        "sliding_indentation",
        "A tip that slides at 0.13 m/s with 1 N sinks in by F/k.",
        found,
        100.0,
        1.0,
        "% of F/k",
        lines(drawn, "stiffness (N/m)", "indentation against F/k (%)", band=1.0, xscale="log"),
    )


def _depth(arm: float, speed: float, stiffness: float) -> float:
    """Depth over F / k."""
    trace = slide(Board(friction=0.5, stiffness=stiffness, damping_ratio=1.0), speed, arm=arm)
    return float((trace.position[:, 0] + RADIUS).mean() * stiffness / trace.pressing.mean())


def kept_contact() -> Evidence:
    """A tip that slides at 0.13 m/s with 1 N touches in every step, on any surface."""
    hills = tuple(tuple(float(np.sin(0.8 * i) * np.cos(0.6 * j)) for j in range(16)) for i in range(16))
    surfaces: dict[str, Surface] = {
        "plane": Board(),
        "bulging cylinder": Cylinder(),
        "hollow cylinder": Cylinder(concave=True, size=(1.6, 2.0)),
        "sphere": Sphere(),
        "sine": SineWall(),
        "ramp": Ramp(offset=0.15, rise=0.05, edge_radius=0.3, fillet_radius=0.3),
        "height map": HeightMap(heights=hills, size=(1.5, 1.5), relief=0.01),
    }
    duty, drawn = [], []
    for name, surface in surfaces.items():
        block, trace = (slide(surface, _SPEED, arm=arm, duration=5.0) for arm in (0.0, 0.3))
        duty += [100.0 * block.duty, 100.0 * trace.duty]
        drawn.append((trace.time, split(surface, trace)[0], "-", name))
    return evidence(
        "kept_contact",
        "Sliding at 0.13 m/s with 1 N the tip touches in 99.5 % of the steps, on flat and curved surfaces.",
        duty,
        99.5,
        0.0,
        "% of steps",
        lines(drawn, "time (s)", "normal force, arm (N)", ylim=(0.0, None)),
        bound="above",
    )


def friction_map() -> Evidence:
    """Over patches the drag is each patch's own."""
    patches = {
        f"patch {k}": Patch(center=(0.1 * k, 0.0), size=(0.1, 1.0), friction=0.1 * k) for k in range(1, 8)
    }
    surface = Board(friction=0.4, friction_map=FrictionMap(patches=patches), size=(2.0, 2.0))
    bench = Bench(surface, gap=-1.0 / surface.stiffness, servos="uv")
    writer = PairFriction(bench.model, surface)
    bench.drive(push_w=1.0, speed_u=_SPEED)
    bench.launch(u=_SPEED)
    rows = []
    for _ in range(round(0.8 / _SPEED / _TICK)):
        writer.update(bench.data.site("tip").xpos)
        trace = bench.run(_TICK)
        rows.append((trace.position[-1, 1], -trace.force[:, 1].mean() / trace.pressing.mean()))
    u, ratio = np.array(rows[20:]).T
    theory = surface.friction_at(surface.to_world(np.stack([0 * u, u, 0 * u], axis=-1)))[0]
    # One tick of travel on both sides of a border belongs to neither patch.
    inside = np.abs((u + 0.05) % 0.1 - 0.05) < 0.047
    drawn = lines([(u, ratio, ".", "measured"), (u, theory, "k-", "map")], "u (m)", "T/N")
    claim = "Over patches of friction 0.1 to 0.7, drag over normal force is the patch's own."
    return evidence("friction_map", claim, ratio[inside], theory[inside], 0.005, "-", drawn)
