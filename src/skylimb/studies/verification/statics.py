"""A tip that rests: where it slips, how deep it sinks, how fast it creeps."""

from __future__ import annotations

import math

import numpy as np

from skylimb.robots.description import GRAVITY
from skylimb.simulation.surfaces import Board
from skylimb.studies.verification.drawing import family, lines
from skylimb.studies.verification.rig import RADIUS, Bench
from skylimb.studies.verification.row import Evidence, evidence, sweep

_FLOOR = (0.0, 0.0, -1.0)  # contact axis of a floor; u is then the world's y, downhill for a positive slope


def slip_angle() -> Evidence:
    """A block on an incline accelerates from the angle atan(mu) on."""
    frictions, offsets = np.array([0.1, 0.3, 0.5, 0.7]), np.radians(np.arange(-0.6, 0.61, 0.1))
    accelerations = sweep(_incline_acceleration, frictions, offsets)
    # A block counts as slipping from 1 mm/s^2 on, which is 0.006 degrees above the limit.
    found = [np.interp(1e-3, row, offsets) for row in accelerations]
    theory = np.degrees(np.arctan(frictions))
    drawn = family(np.degrees(offsets), accelerations, [f"friction {mu:g}" for mu in frictions])
    return evidence(
        "slip_angle",
        "A block on an incline starts to accelerate at atan(mu).",
        theory + np.degrees(found),
        theory,
        0.2,
        "deg",
        lines(drawn, "incline less atan(mu) (deg)", "acceleration (m/s²)"),
    )


def _incline_acceleration(mu: float, offset: float) -> float:
    """Acceleration, m/s^2, on an incline that is steeper than atan(mu) by `offset`, rad."""
    angle, mass = math.atan(mu) + offset, 2.0
    floor = Board(contact_axis=_FLOOR, slope=angle, friction=mu)
    # Starts as deep as its weight presses it in, so that it does not bounce.
    bench = Bench(floor, mass, gap=-mass * GRAVITY * math.cos(angle) / floor.stiffness)
    bench.model.opt.gravity[:] = (0.0, 0.0, -GRAVITY)
    trace = bench.run(0.5).after(0.2)
    return float(np.polyfit(trace.time, trace.velocity[:, 1], 1)[0])


def static_indentation() -> Evidence:
    """A tip at rest sinks in by force over stiffness."""
    stiffnesses, forces = np.array([200.0, 1e3, 5e3, 2e4, 5e4]), np.array([0.5, 1.0, 5.0])
    found = 100.0 * sweep(_depth_at_rest, (0.0, 0.3), forces, stiffnesses)
    drawn = [
        line
        for rows, body, style in zip(found - 100.0, ("block", "arm"), ("o-", "x--"), strict=True)
        for line in family(stiffnesses, rows, [f"{force:g} N, {body}" for force in forces], style)
    ]
    return evidence(
        "static_indentation",
        "A pressed tip sinks in by F/k, from 200 N/m to 50 kN/m.",
        found,
        100.0,
        0.5,
        "% of F/k",
        lines(drawn, "stiffness (N/m)", "indentation against F/k (%)", band=0.5, xscale="log"),
    )


def _depth_at_rest(arm: float, force: float, stiffness: float) -> float:
    """Depth over F / k."""
    bench = Bench(Board(stiffness=stiffness, damping_ratio=1.0), arm=arm, gap=-force / stiffness)
    bench.drive(push_w=force)
    trace = bench.run(1.0).after(0.9)
    return (trace.position[:, 0].mean() + RADIUS) * stiffness / force


def creep() -> Evidence:
    """A tip that sticks under 0.8 of its friction creeps by less than 0.02 mm/s."""
    frictions, shares = np.array([0.2, 0.5, 0.8]), np.array([0.2, 0.4, 0.6, 0.8])
    speed = sweep(_creep, frictions, shares)
    theory = 1e3 * shares * frictions[:, None] / Board().contact.stick_damping
    names = [f"friction {mu:g}" for mu in frictions]
    drawn = [
        *family(shares, speed, names, "o"),
        *family(shares, theory, [f"{n}: theory" for n in names], "-"),
    ]
    return evidence(
        "creep",
        "Under 0.8 mu N a tip sticks: it creeps by less than 0.02 mm/s.",
        speed,
        0.02,
        0.0,
        "mm/s",
        lines(drawn, "pull over mu N", "creep (mm/s)", limit=0.02, ylim=(0.0, 0.022)),
        bound="below",
    )


def _creep(mu: float, share: float) -> float:
    """Speed, mm/s, of a tip that is drawn along with a share of its friction."""
    surface = Board(friction=mu)
    bench = Bench(surface, gap=-1.0 / surface.stiffness)
    bench.drive(push_w=1.0, push_u=share * mu)
    trace = bench.run(2.0).after(1.5)
    return 1e3 * float(np.polyfit(trace.time, trace.position[:, 1], 1)[0])


def adhesion() -> Evidence:
    """A sticky surface lets go when the pull exceeds its adhesion."""
    adhesions = np.array([0.2, 0.5, 2.0])
    pulls = [_pulled(force) for force in adhesions]
    drawn = [
        (steps[:-1, 0] / force, steps[:-1, 1] * 5.0 / force, "o-", f"{force:g} N")
        for force, steps in zip(adhesions, pulls, strict=True)
    ]
    return evidence(
        "adhesion",
        "A sticky surface lets go when the pull reaches its adhesion.",
        [100.0 * steps[-1, 0] / force for force, steps in zip(adhesions, pulls, strict=True)],
        100.0,
        1.0,
        "% of it",
        lines([*drawn, ([0, 1], [0, 1], "k:", "theory")], "pull over adhesion", "stretch over adhesion / k"),
    )


def _pulled(adhesion: float) -> np.ndarray:
    """Pull (N) and stretch (mm) of a slowly growing pull until the surface lets go, (n, 2)."""
    bench, steps = Bench(Board(adhesion=adhesion, damping_ratio=1.0), gap=-1e-6), []
    for step in range(500):
        # By 5 % of the adhesion a second: the damper holds on for a little longer than the spring.
        pull = adhesion * (0.8 + 0.05 * step * 0.01)
        bench.drive(push_w=-pull)
        trace = bench.run(0.01)
        steps.append((pull, -1e3 * (trace.position[-1, 0] + RADIUS)))
        if not trace.touching[-1]:
            break
    return np.array(steps)
