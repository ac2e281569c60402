"""A tip that rests: where it slips, how deep it sinks, how fast it creeps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from skylimb.robots.description import GRAVITY
from skylimb.simulation.surfaces import Board
from skylimb.studies.verification.rig import RADIUS, Bench
from skylimb.studies.verification.row import Evidence, Row, worst

_FLOOR = (0.0, 0.0, -1.0)  # contact axis of a floor; u is then the world's y, downhill for a positive slope


def slip_angle() -> Evidence:
    """A block on an incline accelerates from the angle atan(mu) on."""
    frictions = np.array([0.1, 0.3, 0.5, 0.7])
    offsets = np.radians(np.arange(-0.6, 0.61, 0.1))
    accelerations = np.array(
        [[_incline_acceleration(mu, math.atan(mu) + offset) for offset in offsets] for mu in frictions]
    )
    # A block counts as slipping from 1 mm/s^2 on, which is 0.006 degrees above the limit.
    found = [np.interp(1e-3, row, offsets) for row in accelerations]
    theory = np.degrees(np.arctan(frictions))
    measured, expected = worst(theory + np.degrees(found), theory)

    def draw(axes: Any) -> None:
        for mu, row in zip(frictions, accelerations, strict=True):
            axes.plot(np.degrees(offsets), row, "o-", label=f"friction {mu:g}")
        axes.axvspan(-0.2, 0.2, alpha=0.15, color="0.5", lw=0)
        axes.set(xlabel="incline less atan(mu) (deg)", ylabel="acceleration (m/s²)")
        axes.legend()

    claim = "A block on an incline starts to accelerate at atan(mu)."
    return Evidence(Row("slip_angle", claim, measured, expected, 0.2, "deg", cases=len(frictions)), draw)


def _incline_acceleration(mu: float, angle: float) -> float:
    floor = Board(contact_axis=_FLOOR, slope=angle, friction=mu)
    mass = 2.0
    # Starts as deep as its weight presses it in, so that it does not bounce.
    bench = Bench(floor, mass, gap=-mass * GRAVITY * math.cos(angle) / floor.stiffness)
    bench.model.opt.gravity[:] = (0.0, 0.0, -GRAVITY)
    trace = bench.run(0.5).after(0.2)
    return float(np.polyfit(trace.time, trace.velocity[:, 1], 1)[0])


def static_indentation() -> Evidence:
    """A tip at rest sinks in by force over stiffness."""
    stiffnesses = np.array([200.0, 1e3, 5e3, 2e4, 5e4])
    forces = np.array([0.5, 1.0, 5.0])
    ratio = np.empty((2, len(stiffnesses), len(forces)))
    for a, arm in enumerate((0.0, 0.3)):
        for i, stiffness in enumerate(stiffnesses):
            for j, force in enumerate(forces):
                bench = Bench(Board(stiffness=stiffness, damping_ratio=1.0), arm=arm, gap=-force / stiffness)
                bench.drive(push_w=force)
                trace = bench.run(1.0).after(0.9)
                depth = trace.position[:, 0].mean() + RADIUS
                ratio[a, i, j] = depth * stiffness / force
    measured, expected = worst(100.0 * ratio, 100.0)

    def draw(axes: Any) -> None:
        for j, force in enumerate(forces):
            axes.semilogx(stiffnesses, 100.0 * (ratio[0, :, j] - 1.0), "o-", label=f"{force:g} N, block")
            axes.semilogx(stiffnesses, 100.0 * (ratio[1, :, j] - 1.0), "x--", label=f"{force:g} N, arm")
        axes.axhspan(-0.5, 0.5, alpha=0.15, color="0.5", lw=0)
        axes.set(xlabel="stiffness (N/m)", ylabel="indentation against F/k (%)")
        axes.legend(ncols=2)

    claim = "A pressed tip sinks in by F/k, from 200 N/m to 50 kN/m."
    row = Row("static_indentation", claim, measured, expected, 0.5, "% of F/k", cases=ratio.size)
    return Evidence(row, draw)


def creep() -> Evidence:
    """A tip that sticks under 0.8 of its friction creeps by less than 0.02 mm/s."""
    shares = np.array([0.2, 0.4, 0.6, 0.8])
    frictions = np.array([0.2, 0.5, 0.8])
    speed = np.empty((len(frictions), len(shares)))
    for i, mu in enumerate(frictions):
        for j, share in enumerate(shares):
            surface = Board(friction=mu)
            bench = Bench(surface, gap=-1.0 / surface.stiffness)
            bench.drive(push_w=1.0, push_u=share * mu)
            trace = bench.run(2.0).after(1.5)
            speed[i, j] = 1e3 * np.polyfit(trace.time, trace.position[:, 1], 1)[0]
    theory = 1e3 * shares * frictions[:, None] / Board().contact.stick_damping

    def draw(axes: Any) -> None:
        for i, mu in enumerate(frictions):
            line = axes.plot(shares, speed[i], "o", label=f"friction {mu:g}")[0]
            axes.plot(shares, theory[i], "-", color=line.get_color(), lw=0.8)
        axes.axhline(0.02, color="0.5", ls="--")
        axes.set(xlabel="pull over mu N (lines: theory)", ylabel="creep (mm/s)", ylim=(0.0, 0.022))
        axes.legend()

    claim = "Under 0.8 mu N a tip sticks: it creeps by less than 0.02 mm/s."
    row = Row("creep", claim, float(speed.max()), 0.02, 0.0, "mm/s", bound="below", cases=speed.size)
    return Evidence(row, draw)


def adhesion() -> Evidence:
    """A sticky surface lets go when the pull exceeds its adhesion."""
    adhesions = np.array([0.2, 0.5, 2.0])
    rate = 0.05  # of the adhesion a second: the damper holds on for a little longer than the spring
    pulls, traces = [], []
    for force in adhesions:
        bench = Bench(Board(adhesion=force, damping_ratio=1.0), gap=-1e-6)
        steps = []
        for step in range(500):
            pull = force * (0.8 + rate * step * 0.01)
            bench.drive(push_w=-pull)
            trace = bench.run(0.01)
            steps.append((pull, -1e3 * (trace.position[-1, 0] + RADIUS)))
            if not trace.touching[-1]:
                break
        pulls.append(steps[-1][0])
        traces.append(np.array(steps))
    measured, expected = worst(100.0 * np.array(pulls) / adhesions, 100.0)

    def draw(axes: Any) -> None:
        for force, steps in zip(adhesions, traces, strict=True):
            axes.plot(steps[:-1, 0] / force, steps[:-1, 1] * 5000 / force / 1e3, label=f"{force:g} N")
        axes.plot([0, 1], [0, 1], "k:", lw=1, label="theory")
        axes.set(xlabel="pull over adhesion", ylabel="stretch over adhesion / k")
        axes.legend()

    claim = "A sticky surface lets go when the pull reaches its adhesion."
    return Evidence(Row("adhesion", claim, measured, expected, 1.0, "% of it", cases=len(pulls)), draw)
