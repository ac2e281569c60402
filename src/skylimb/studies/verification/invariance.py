"""What must not matter (time step, placement, which of the two moves), and that momentum balances."""

from __future__ import annotations

from typing import Any

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
from skylimb.studies.verification.rig import RADIUS, Bench
from skylimb.studies.verification.row import Evidence, Row, worst
from skylimb.studies.verification.sliding import slide, split


def impulse_balance() -> Evidence:
    """Contact force times time is the change of momentum, in every step."""
    residuals = {}
    push = np.array([1.0, 0.6, -0.2])
    for name, surface in {"plane": Board(), "sine": SineWall(), "hollow cylinder": _hollow()}.items():
        bench = Bench(surface, gap=1e-4)
        bench.drive(push_w=push[0], push_u=push[1], push_v=push[2])
        bench.launch(w=0.1, u=0.1)
        trace = bench.run(1.0)
        gained = bench.mass * np.diff(trace.velocity, axis=0)
        given = (trace.force[:-1] + push) * np.diff(trace.time)[:, None]
        residuals[name] = trace.time[1:], np.abs(gained - given).max(axis=1)
    largest = max(float(residual.max()) for _, residual in residuals.values())

    def draw(axes: Any) -> None:
        for name, (time, residual) in residuals.items():
            axes.semilogy(time, np.maximum(residual, 1e-18), lw=0.7, label=name)
        axes.axhline(1e-10, color="0.5", ls="--")
        axes.set(xlabel="time (s)", ylabel="momentum less impulse (N s)")
        axes.legend()

    claim = "The recorded contact force times time is the change of momentum."
    row = Row("impulse_balance", claim, largest, 0.0, 1e-10, "N s", cases=3)
    return Evidence(row, draw)


def convergence() -> Evidence:
    """A time step of 2 ms gives the motion and the force of 0.25 ms."""
    steps = np.array([2.0, 1.0, 0.5, 0.25]) * 1e-3
    surfaces: dict[str, Surface] = {"plane": Board(), "sine": SineWall(), "hollow cylinder": _hollow()}
    place = np.empty((len(surfaces), len(steps)))
    force = np.empty_like(place)
    for i, surface in enumerate(surfaces.values()):
        finest = slide(surface, 0.13, timestep=float(steps[-1]), duration=2.0)
        reference = split(surface, finest)[0].mean()
        for j, timestep in enumerate(steps):
            trace = slide(surface, 0.13, timestep=float(timestep), duration=2.0)
            depth = np.interp(trace.time, finest.time, _gap(surface, finest.position))
            place[i, j] = 1e6 * np.abs(_gap(surface, trace.position) - depth).max()
            force[i, j] = 100.0 * abs(split(surface, trace)[0].mean() / reference - 1.0)

    def draw(axes: Any) -> None:
        for i, name in enumerate(surfaces):
            line = axes.plot(1e3 * steps, place[i], "o-", label=f"{name}: depth")[0]
            axes.plot(1e3 * steps, force[i], "x--", color=line.get_color(), label=f"{name}: mean force")
        axes.set(xlabel="time step (ms)", ylabel="against 0.25 ms (µm, %)")
        axes.legend()

    claim = "A time step of 2 ms gives the depth of 0.25 ms within 5 µm (and the mean force within 1 %)."
    # Both bounds in one number: the mean force counts as 5 µm for its 1 %.
    both = max(float(place.max()), 5.0 * float(force.max()))
    row = Row("convergence", claim, both, 5.0, 0.0, "µm (5 µm for 1 %)", bound="below", cases=place.size)
    return Evidence(row, draw)


def _gap(surface: Surface, local: np.ndarray) -> np.ndarray:
    foot, normal = surface.local_closest(local)
    return np.sum((local - foot) * normal, axis=1) - RADIUS


def _hollow() -> Cylinder:
    return Cylinder(concave=True, size=(1.6, 2.0))


def moving_wall() -> Evidence:
    """Friction sees the speed of the tip against the wall, whichever of the two moves."""
    speeds = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
    mu = 0.4
    ratio = np.empty((len(speeds), len(speeds)))
    for i, wall in enumerate(speeds):
        for j, tip in enumerate(speeds):
            board = Board(friction=mu, advance_distance=1.0, motion_direction=(0.0, 1.0, 0.0))
            bench = Bench(board, gap=-1.0 / board.stiffness, servos="uv")
            bench.drive(push_w=1.0, speed_u=tip)
            bench.launch(u=tip)
            bench.data.joint(bench.slide).qvel = wall
            trace = bench.run(0.6).after(0.4)
            ratio[i, j] = trace.force[:, 1].mean() / trace.pressing.mean()
    theory = mu * np.sign(speeds[:, None] - speeds)
    measured, expected = worst(ratio, theory)

    def draw(axes: Any) -> None:
        slip = (speeds[:, None] - speeds).ravel()
        axes.plot(slip, ratio.ravel(), "o", mfc="none", label="measured")
        axes.plot([-0.4, 0, 0, 0.4], [-mu, -mu, mu, mu], "k-", lw=0.8, label="theory")
        axes.set(xlabel="wall's speed less tip's (m/s)", ylabel="T/N on the tip")
        axes.legend()

    claim = "Friction comes from the speed against the wall, whichever of the two moves."
    return Evidence(Row("moving_wall", claim, measured, expected, 0.002, "-", cases=ratio.size), draw)


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
    forces = np.array([np.abs(trace.force - traces[0].force).max() for trace in traces])
    places = np.array([np.abs(trace.position - traces[0].position).max() for trace in traces])

    def draw(axes: Any) -> None:
        axes.semilogy(np.maximum(forces, 1e-16), "o", label="force (N)")
        axes.semilogy(np.maximum(places, 1e-16), "x", label="position (m)")
        axes.set(xlabel="placement", ylabel="against the first placement")
        axes.legend()

    claim = "A slide over a sine is the same on a wall, a ceiling, a floor and at random placements."
    row = Row("placement", claim, float(forces.max()), 0.0, 1e-6, "N", cases=len(traces) - 1)
    return Evidence(row, draw)


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
    deviation = {}
    for index, surface in enumerate(surfaces):
        model, data = (bench := Bench(surface)).model, bench.data
        half = 0.45 * np.minimum(surface.size, 1.5 * getattr(surface, "radius", np.inf))
        worst_here = 0.0
        for u, v in rng.uniform(-half, half, (100, 2)):
            foot = np.array([float(surface.height(u, v)), u, v])
            _, normal = surface.local_closest(foot)
            # The joints of the bench are the surface's own axes, counted from where the tip's centre starts.
            data.qpos[-3:] = foot + rng.uniform(0.2, 0.95) * RADIUS * normal + [RADIUS, 0.0, 0.0]
            mujoco.mj_forward(model, data)
            gap = _gap(surface, (data.qpos[-3:] - [RADIUS, 0.0, 0.0])[None])[0]
            distances = [contact.dist for contact in data.contact] if data.ncon == 1 else [np.nan]
            worst_here = np.fmax(worst_here, abs(distances[0] - gap)) if data.ncon == 1 else np.nan
        deviation[f"{index + 1} {surface.kind}"] = 1e3 * worst_here
    measured, _ = worst(np.array(list(deviation.values())), 0.0)

    def draw(axes: Any) -> None:
        axes.barh(list(deviation), np.maximum(list(deviation.values()), 1e-16), color="C0")
        axes.set(xscale="log", xlabel="distance in the physics less in the analysis (mm)")
        axes.invert_yaxis()

    claim = "At random points the physics has one touch, where the analysis has the surface."
    row = Row("geometry", claim, measured, 0.0, 1.0, "mm", cases=100 * len(surfaces))
    return Evidence(row, draw)
