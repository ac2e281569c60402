"""What must not matter (time step, placement, which of the two moves), and that momentum balances."""

from __future__ import annotations

import mujoco
import numpy as np

from skylimb.simulation.surfaces import (
    Board,
    Corrugated,
    Cylinder,
    HeightMap,
    Pipe,
    Ramp,
    Ridge,
    SineWall,
    Sphere,
    Step,
)
from skylimb.simulation.surfaces.surface import Surface
from skylimb.studies.verification.drawing import family, lines
from skylimb.studies.verification.rig import RADIUS, Bench
from skylimb.studies.verification.row import Evidence, evidence, sweep
from skylimb.studies.verification.sliding import slide, split

_POINTS = 100  # on each surface


def impulse_balance() -> Evidence:
    """Contact force times time is the change of momentum, in every step."""
    push, drawn = np.array([1.0, 0.6, -0.2]), []
    for name, surface in _surfaces().items():
        bench = Bench(surface, gap=1e-4)
        bench.drive(push_w=push[0], push_u=push[1], push_v=push[2])
        bench.launch(w=0.1, u=0.1)
        trace = bench.run(1.0)
        gained = bench.mass * np.diff(trace.velocity, axis=0)
        given = (trace.force[:-1] + push) * np.diff(trace.time)[:, None]
        # A logarithmic axis has no zero.
        drawn.append((trace.time[1:], np.maximum(np.abs(gained - given).max(axis=1), 1e-18), "-", name))
    return evidence(
        "impulse_balance",
        "The recorded contact force times time is the change of momentum.",
        [residual.max() for _, residual, *_ in drawn],
        0.0,
        1e-10,
        "N s",
        lines(drawn, "time (s)", "momentum less impulse (N s)", limit=1e-10, yscale="log"),
    )


def convergence() -> Evidence:
    """A time step of 2 ms gives the motion and the force of 0.25 ms."""
    steps, drawn, off = np.array([2.0, 1.0, 0.5, 0.25]) * 1e-3, [], []
    for name, surface in _surfaces().items():
        traces = [slide(surface, 0.13, timestep=float(step), duration=2.0) for step in steps]
        depths = [1e6 * _gap(surface, trace.position) for trace in traces]
        place = [
            np.abs(depth - np.interp(trace.time, traces[-1].time, depths[-1])).max()
            for trace, depth in zip(traces, depths, strict=True)
        ]
        means = np.array([split(surface, trace)[0].mean() for trace in traces])
        force = 100.0 * np.abs(means / means[-1] - 1.0)
        drawn += family(1e3 * steps, [place, force], [f"{name}: depth", f"{name}: mean force"])
        # Both bounds in one number: the mean force counts as 5 µm for its 1 %.
        off.append(np.maximum(place, 5.0 * force))
    return evidence(
        "convergence",
        "A time step of 2 ms gives the depth of 0.25 ms within 5 µm (and the mean force within 1 %).",
        off,
        5.0,
        0.0,
        "µm (5 µm for 1 %)",
        lines(drawn, "time step (ms)", "against 0.25 ms (µm, %)"),
        bound="below",
    )


def _surfaces() -> dict[str, Surface]:
    return {"plane": Board(), "sine": SineWall(), "hollow cylinder": _hollow()}


def _gap(surface: Surface, local: np.ndarray) -> np.ndarray:
    foot, normal = surface.local_closest(local)
    return np.sum((local - foot) * normal, axis=1) - RADIUS


def _hollow() -> Cylinder:
    return Cylinder(concave=True, size=(1.6, 2.0))


def moving_wall() -> Evidence:
    """Friction sees the speed of the tip against the wall, whichever of the two moves."""
    speeds, mu = np.array([-0.2, -0.1, 0.0, 0.1, 0.2]), 0.4

    def ratio(wall: float, tip: float) -> float:
        board = Board(friction=mu, advance_distance=1.0, motion_direction=(0.0, 1.0, 0.0))
        bench = Bench(board, gap=-1.0 / board.stiffness, servos="uv")
        bench.drive(push_w=1.0, speed_u=tip)
        bench.launch(u=tip)
        bench.data.joint(bench.slide).qvel = wall
        trace = bench.run(0.6).after(0.4)
        return float(trace.force[:, 1].mean() / trace.pressing.mean())

    found, slip = sweep(ratio, speeds, speeds), speeds[:, None] - speeds
    drawn = [
        (slip.ravel(), found.ravel(), "o", "measured"),
        ([-0.4, 0, 0, 0.4], [-mu, -mu, mu, mu], "k-", "theory"),
    ]
    return evidence(
        "moving_wall",
        "Friction comes from the speed against the wall, whichever of the two moves.",
        found,
        mu * np.sign(slip),
        0.002,
        "-",
        lines(drawn, "wall's speed less tip's (m/s)", "T/N on the tip"),
    )


def placement() -> Evidence:
    """A slide is the same, in the surface's own axes, wherever the surface stands."""
    rng = np.random.default_rng(7)
    axes_tried = [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
    axes_tried += [tuple((a / np.linalg.norm(a)).tolist()) for a in rng.normal(size=(6, 3))]
    traces = []
    for axis in axes_tried:
        slope, pitch, roll = rng.uniform(-0.6, 0.6, 3) if traces else np.zeros(3)
        position = tuple(rng.uniform(-2.0, 2.0, 3).tolist()) if traces else (1.0, 0.0, 1.0)
        surface = SineWall(
            contact_axis=axis, slope=slope, pitch=pitch, roll=roll, position=position, friction=0.5
        )
        traces.append(slide(surface, 0.13, arm=0.3, duration=1.5))
    forces = np.array([np.abs(trace.force - traces[0].force).max() for trace in traces[1:]])
    places = np.array([np.abs(trace.position - traces[0].position).max() for trace in traces[1:]])
    number = np.arange(1, len(traces))
    drawn = [
        (number, np.maximum(forces, 1e-16), "o", "force (N)"),
        (number, np.maximum(places, 1e-16), "x", "position (m)"),
    ]
    return evidence(
        "placement",
        "A slide over a sine is the same on a wall, a ceiling, a floor and at random placements.",
        forces,
        0.0,
        1e-6,
        "N",
        lines(drawn, "placement", "against the first placement", yscale="log"),
    )


def geometry() -> Evidence:
    """The physics touches the surface that the analysis knows."""
    rng = np.random.default_rng(11)
    relief = tuple(tuple(float(np.sin(0.9 * i) * np.cos(0.7 * j)) for j in range(12)) for i in range(12))
    surfaces: list[Surface] = [
        Board(slope=0.3, pitch=0.1),
        Cylinder(),
        _hollow(),
        Pipe(),
        Sphere(),
        SineWall(),
        SineWall(wavelength=0.8, roll=0.4),
        Corrugated(),
        Step(),
        Ridge(),
        Ramp(),
        HeightMap(heights=relief, size=(1.2, 1.2), relief=0.03),
    ]
    deviation = np.array([_largest_deviation(surface, rng) for surface in surfaces])
    kinds = [f"{index + 1} {surface.kind}" for index, surface in enumerate(surfaces)]
    drawn = [(np.maximum(deviation, 1e-16), np.arange(len(kinds)), "o", "")]
    return evidence(
        "geometry",
        "At random points the physics has one touch, where the analysis has the surface.",
        deviation,
        0.0,
        1.0,
        "mm",
        lines(
            drawn,
            "distance in the physics less in the analysis (mm)",
            "",
            xscale="log",
            yticks=np.arange(len(kinds)),
            yticklabels=kinds,
        ),
        cases=_POINTS * len(surfaces),
    )


def _largest_deviation(surface: Surface, rng: np.random.Generator) -> float:
    """Of the engine's distance from the analysis', mm; NaN where there is not one touch."""
    model, data = (bench := Bench(surface)).model, bench.data
    half, found = 0.45 * np.minimum(surface.size, 1.5 * getattr(surface, "radius", np.inf)), []
    for u, v in rng.uniform(-half, half, (_POINTS, 2)):
        foot = np.array([float(surface.height(u, v)), u, v])
        _, normal = surface.local_closest(foot)
        tip = foot + rng.uniform(0.2, 0.95) * RADIUS * normal
        # The joints of the bench are the surface's own axes, counted from where the tip's centre starts.
        data.qpos[-3:] = tip + np.array([RADIUS, 0.0, 0.0])
        mujoco.mj_forward(model, data)
        distance = data.contact[0].dist if data.ncon == 1 else np.nan
        found.append(1e3 * abs(distance - _gap(surface, tip[None])[0]))
    return float(np.max(found))
