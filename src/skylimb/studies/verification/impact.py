"""A tip that hits: how fast it leaves, and that it leaves with no more energy than it came with."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
from scipy.optimize import brentq

from skylimb.simulation.contact import add_contact_pair, set_contact_options, tune_contact_pair
from skylimb.simulation.surface_bodies import add_surface
from skylimb.simulation.surfaces import Board
from skylimb.studies.verification.rig import RADIUS, Bench
from skylimb.studies.verification.row import Evidence, Row, worst


def spring_damper_restitution(damping_ratio: float) -> float:
    """Speed after over speed before of a mass that hits a spring and damper which cannot pull.

    They let go when k x + c x' = 0, before the spring is relaxed. Here omega = 1, x(0) = 0 and x'(0) = 1.
    """
    zeta = damping_ratio
    root = math.sqrt(abs(1.0 - zeta**2))

    def motion(t: float) -> tuple[float, float]:
        decay = math.exp(-zeta * t)
        if zeta < 1.0:
            s, c = math.sin(root * t) / root, math.cos(root * t)
        elif zeta > 1.0:
            s, c = math.sinh(root * t) / root, math.cosh(root * t)
        else:
            s, c = t, 1.0
        return decay * s, decay * (c - zeta * s)

    def force(t: float) -> float:
        x, v = motion(t)
        return x + 2.0 * zeta * v

    # The mass turns back before the force ends, so the search starts where the speed changes sign.
    turn = _root(lambda t: motion(t)[1], 1e-9, math.pi / root if zeta < 1.0 else 20.0)
    # An underdamped spring would be relaxed, and its damper pulling, at pi / root.
    end = _root(force, turn, math.pi / root if zeta < 1.0 else turn + 20.0)
    return -motion(end)[1]


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    return float(brentq(function, low, high))  # type: ignore[arg-type]


def restitution() -> Evidence:
    """A tip leaves as the spring-damper's own solution says, off a wall at rest or moving."""
    ratios = np.array([0.05, 0.1, 0.2, 0.3, 0.5, 0.7])
    stiffnesses = np.array([500.0, 5e3])
    theory = np.array([spring_damper_restitution(zeta) for zeta in ratios])
    measured = np.empty((len(stiffnesses), 2, len(ratios)))
    for i, stiffness in enumerate(stiffnesses):
        for j, wall in enumerate((0.0, 0.2)):
            for k, zeta in enumerate(ratios):
                measured[i, j, k] = _rebound(stiffness, float(zeta), wall)
    value, expected = worst(measured, theory)

    def draw(axes: Any) -> None:
        grid = np.linspace(0.02, 0.8, 60)
        axes.plot(grid, list(map(spring_damper_restitution, grid)), "k-", lw=1, label="theory")
        for i, stiffness in enumerate(stiffnesses):
            axes.plot(ratios, measured[i, 0], "o", mfc="none", label=f"{stiffness:g} N/m")
            axes.plot(ratios, measured[i, 1], "+", label=f"{stiffness:g} N/m, moving wall")
        axes.set(xlabel="damping ratio", ylabel="restitution")
        axes.legend()

    claim = "A tip leaves a wall, at rest or moving, as the spring and damper's own solution says."
    return Evidence(Row("restitution", claim, value, expected, 0.03, "-", cases=measured.size), draw)


def _rebound(stiffness: float, zeta: float, wall_speed: float) -> float:
    """Restitution in the wall's frame of a tip that flies at 0.3 m/s into a wall that comes at it."""
    # A distance to advance makes the board one on a slide; its speed is set here.
    board = Board(stiffness=stiffness, damping_ratio=zeta, advance_distance=1.0 if wall_speed else 0.0)
    bench = Bench(board, gap=1e-6)
    bench.launch(w=0.3)
    if bench.slide is not None:
        bench.data.joint(bench.slide).qvel = wall_speed
    trace = bench.run(0.4 if stiffness < 1e3 else 0.2)
    return float(-trace.velocity[-1, 0] - wall_speed) / (0.3 + wall_speed)


def energy() -> Evidence:
    """No oblique impact of a body that can turn leaves more energy than there was."""
    rng = np.random.default_rng(150)
    angles, gains = [], []
    for _ in range(150):
        angle = rng.uniform(0.0, math.radians(80.0))
        before, after = _oblique(rng, angle)
        angles.append(math.degrees(angle))
        gains.append(after / before)

    def draw(axes: Any) -> None:
        axes.plot(angles, gains, "o", ms=3, mfc="none")
        axes.axhline(1.0, color="0.5", ls="--")
        axes.set(xlabel="angle of incidence (deg)", ylabel="energy after over before", ylim=(0.0, 1.05))

    claim = "150 oblique impacts of a free, turning body create no energy."
    row = Row("energy", claim, max(gains), 1.0, 0.0, "of the energy before", bound="below", cases=len(gains))
    return Evidence(row, draw)


def _oblique(rng: np.random.Generator, angle: float) -> tuple[float, float]:
    """Kinetic energy before and after one impact of a free body with an arm, J."""
    board = Board(
        friction=rng.uniform(0.1, 0.8), stiffness=rng.uniform(1e3, 2e4), damping_ratio=rng.uniform(0.05, 0.6)
    )
    spec = mujoco.MjSpec()
    set_contact_options(spec, 1e-3)
    spec.option.gravity = [0.0, 0.0, 0.0]
    parts = add_surface(spec, board)
    arm = np.array([0.15, 0.0, 0.0]) + rng.uniform(-0.15, 0.15, 3)
    body = spec.worldbody.add_body(pos=np.array(board.position) - [RADIUS + 1e-6, 0.0, 0.0] - arm)
    body.add_freejoint()
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = 4.0, [0.3, 0.25, 0.4], [0.0, 0.0, 0.0]
    body.add_geom(
        name="tip",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[RADIUS, 0.0, 0.0],
        pos=arm,
        contype=0,
        conaffinity=0,
    )
    add_contact_pair(spec, "tip", parts.geom, board.contact)
    model = spec.compile()
    tune_contact_pair(model, board.contact)
    data = mujoco.MjData(model)
    speed, around = rng.uniform(0.1, 1.0), rng.uniform(0.0, 2.0 * math.pi)
    sideways = math.sin(angle)
    data.qvel[:3] = speed * np.array(
        [math.cos(angle), sideways * math.cos(around), sideways * math.sin(around)]
    )
    before = _kinetic_energy(model, data)
    mujoco.mj_step(model, data, nstep=100)
    while data.ncon and data.time < 3.0:
        mujoco.mj_step(model, data, nstep=20)
    # A body that leans on the wall still has energy in its spring.
    depth = data.contact[0].dist if data.ncon else 0.0
    return before, _kinetic_energy(model, data) + 0.5 * board.stiffness * depth**2


def _kinetic_energy(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    mujoco.mj_forward(model, data)
    mujoco.mj_energyVel(model, data)
    return float(data.energy[1])
