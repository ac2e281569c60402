"""A tip that hits: how fast it leaves, and that it leaves with no more energy than it came with."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from skylimb.simulation.surfaces import Board
from skylimb.studies.verification.drawing import family, lines
from skylimb.studies.verification.rig import RADIUS, Bench, released, scene
from skylimb.studies.verification.row import Evidence, evidence, sweep


def spring_damper_restitution(damping_ratio: float) -> float:
    """Speed after over speed before of a mass that hits a spring and damper which cannot pull.

    They let go when k x + c x' = 0, before the spring is relaxed (Schwager, Poeschel, Granular Matter 9,
    2007).
    """
    zeta = damping_ratio
    root = math.sqrt(abs(1.0 - zeta**2))
    if root == 0.0:
        return math.exp(-2.0)
    if zeta < 1.0:
        return math.exp(-zeta / root * math.atan2(2.0 * zeta * root, 2.0 * zeta**2 - 1.0))
    return math.exp(-zeta / root * math.log((zeta + root) / (zeta - root)))


def restitution() -> Evidence:
    """A tip leaves as the spring-damper's own solution says, off a wall at rest or moving."""
    ratios, stiffnesses = np.array([0.05, 0.1, 0.2, 0.3, 0.5, 0.7]), np.array([500.0, 5e3])
    measured = sweep(_rebound, stiffnesses, (0.0, 0.2), ratios)
    grid, names = np.linspace(0.02, 0.8, 60), [f"{stiffness:g} N/m" for stiffness in stiffnesses]
    drawn = [
        (grid, list(map(spring_damper_restitution, grid)), "k-", "theory"),
        *family(ratios, measured[:, 0], names, "o"),
        *family(ratios, measured[:, 1], [f"{name}, moving wall" for name in names], "+"),
    ]
    return evidence(
        "restitution",
        "A tip leaves a wall, at rest or moving, as the spring and damper's own solution says.",
        measured,
        list(map(spring_damper_restitution, ratios)),
        0.03,
        "-",
        lines(drawn, "damping ratio", "restitution"),
    )


def _rebound(stiffness: float, wall_speed: float, zeta: float) -> float:
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
    angles, gains = np.array([_oblique(rng) for _ in range(150)]).T
    drawn = lines(
        [(np.degrees(angles), gains, "o", "")],
        "angle of incidence (deg)",
        "energy after over before",
        limit=1.0,
        ylim=(0.0, 1.05),
    )
    claim = "150 oblique impacts of a free, turning body create no energy."
    return evidence("energy", claim, gains, 1.0, 0.0, "of the energy before", drawn, bound="below")


def _oblique(rng: np.random.Generator) -> tuple[float, float]:
    """Angle of incidence (rad) of a free body with an arm, and kinetic energy after over before."""
    angle = rng.uniform(0.0, math.radians(80.0))
    board = Board(
        friction=rng.uniform(0.1, 0.8), stiffness=rng.uniform(1e3, 2e4), damping_ratio=rng.uniform(0.05, 0.6)
    )
    arm = np.array([0.15, 0.0, 0.0]) + rng.uniform(-0.15, 0.15, 3)
    at = np.array(board.position) - [RADIUS + 1e-6, 0.0, 0.0] - arm
    spec, body, parts = scene(board, 4.0, [0.3, 0.25, 0.4], at, arm)
    body.add_freejoint()
    model, data = released(spec, board, parts)
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
    return angle, (_kinetic_energy(model, data) + 0.5 * board.stiffness * depth**2) / before


def _kinetic_energy(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    mujoco.mj_forward(model, data)
    mujoco.mj_energyVel(model, data)
    return float(data.energy[1])
