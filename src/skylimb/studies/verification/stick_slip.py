"""Friction that falls when the tip starts to move: a block on a spring on a belt sticks and slips in turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from skylimb.simulation.surfaces import Board, PairFriction
from skylimb.simulation.surfaces.friction_map import static_excess
from skylimb.studies.verification.drawing import lines
from skylimb.studies.verification.rig import Bench
from skylimb.studies.verification.row import Evidence, evidence

_TICK = 0.005  # s between two writes of the friction


@dataclass(frozen=True)
class Belt:
    """A block of `mass` (kg) on a spring (N/m), pressed (N) on a belt that runs at `speed` (m/s)."""

    mass: float = 2.0
    spring: float = 40.0
    press: float = 4.0
    speed: float = 0.02
    friction: float = 0.3
    static_ratio: float = 1.5
    static_speed: float = 0.005

    def solve(self, duration: float) -> tuple[np.ndarray, np.ndarray]:
        """Time (s) and place (m) of the block by Coulomb's equations, from one event to the next."""
        limit = self.friction * self.static_ratio * self.press
        times, places = [0.0], [0.0]
        t, x = 0.0, 0.0

        def slipping(_: float, state: np.ndarray) -> list[float]:
            slip = max(self.speed - state[1], 0.0)
            mu = self.friction * static_excess(np.square(slip), self.static_ratio, self.static_speed)
            return [state[1], (-self.spring * state[0] + float(mu) * self.press) / self.mass]

        def caught(_: float, state: np.ndarray) -> float:
            return state[1] - self.speed

        caught.terminal, caught.direction = True, 1.0  # type: ignore[attr-defined]
        while t < duration:
            stuck = (limit / self.spring - x) / self.speed
            t, x = t + stuck, limit / self.spring
            times.append(t)
            places.append(x)
            # A hair slower than the belt, so that the event that ends the slip is not the one that begins it.
            run = solve_ivp(
                slipping,
                (t, t + 20.0),
                [x, self.speed - 1e-9],
                events=caught,
                rtol=1e-10,
                atol=1e-12,
                max_step=0.01,
            )
            times += run.t[1:].tolist()
            places += run.y[0][1:].tolist()
            t, x = times[-1], places[-1]
        return np.array(times), np.array(places)

    def simulate(self, duration: float) -> tuple[np.ndarray, np.ndarray]:
        """Time and place of the block in the physics."""
        board = Board(
            friction=self.friction,
            static_ratio=self.static_ratio,
            static_speed=self.static_speed,
            damping_ratio=1.0,
            advance_distance=1.0,
            motion_direction=(0.0, 1.0, 0.0),
            size=(4.0, 4.0),
        )
        bench = Bench(board, mass=self.mass, gap=-self.press / board.stiffness)
        bench.model.jnt_stiffness[bench.model.joint("u").id] = self.spring
        writer = PairFriction(bench.model, board)
        bench.drive(push_w=self.press)
        bench.launch(u=self.speed)
        times, places = [], []
        belt = bench.data.joint(bench.slide)
        velocity = np.zeros(3)
        for _ in range(round(duration / _TICK)):
            belt.qpos, belt.qvel = self.speed * bench.data.time, self.speed
            velocity[1] = bench.data.joint("u").qvel[0]
            writer.update(bench.data.site("tip").xpos, velocity, 0.0, self.speed)
            trace = bench.run(_TICK)
            times += trace.time.tolist()
            places += trace.position[:, 1].tolist()
        return np.array(times), np.array(places)


def _period_and_swing(time: np.ndarray, place: np.ndarray) -> tuple[float, float]:
    """Mean time between two slips, s, and distance from the farthest to the nearest place, m."""
    middle = 0.5 * (place.max() + place[time > 5.0].min())
    falling = np.flatnonzero((place[:-1] > middle) & (place[1:] <= middle))
    crossing = (
        time[falling]
        + (place[falling] - middle) / (place[falling] - place[falling + 1]) * np.diff(time)[falling]
    )
    settled = place[time > crossing[0]]
    return float(np.diff(crossing).mean()), float(settled.max() - settled.min())


def stick_slip() -> Evidence:
    """Period and swing of stick-slip are those of the equations."""
    belts = [Belt(), Belt(static_ratio=1.25), Belt(speed=0.03), Belt(spring=80.0, static_ratio=2.0)]
    runs = [(belt.simulate(14.0), belt.solve(14.0)) for belt in belts]
    swings = np.array([[_period_and_swing(*run) for run in both] for both in runs])
    (time, place), (solved_time, solved_place) = runs[0]
    drawn = [(solved_time, 1e3 * solved_place, "k--", "theory"), (time, 1e3 * place, "-", "physics")]
    return evidence(
        "stick_slip",
        "A block on a spring on a belt sticks and slips with the period and swing of its equations.",
        100.0 * swings[:, 0] / swings[:, 1],
        100.0,
        2.0,
        "% of theory",
        lines(drawn, "time (s)", "place of the block (mm)", xlim=(0.0, 12.0)),
    )
