"""The allocation within limits: a million problems a robot, its speed, and what it buys in flight.

    python benchmarks/allocation.py [--draws 1000000] [--flights 200] [--part problems|speed|flights]

Problems: wrenches within and far out of reach of a quad, a hexarotor and an octorotor. Each answer is
certified by its duality gap: the cost of a convex problem is above its least one by no more than the
gradient can gain in the box, and |A (x - x_best)|^2 is below that gap too. A few hundred are held against a
reference solver and a linear programme besides.

Flights: the hovering quad is pushed harder than its rotors can bear, the same pushes with the paper's
allocation and with this one.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import linprog, lsq_linear

import skylimb
from skylimb.control.allocation.laws.bounded import Weights
from skylimb.control.box_least_squares import nearest_in_box
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.flight.drivers.machine_code import machine_code
from skylimb.flight.drivers.native import fly_native, native_available
from skylimb.flight.takeoff import take_off

_BLOCK = 10_000
_LIMITS = (1.0, 30.0)  # N
_LOST_AFTER = 4.0  # m


def ring(n: int, tilt: float = 0.35, radius: float = 0.39, drag: float = 0.021) -> np.ndarray:
    """Allocation matrix (6, n) of a flat ring whose rotors tilt about their arms to either side in turn."""
    columns = []
    for k, angle in enumerate(2.0 * np.pi * np.arange(n) / n):
        arm, sign = np.array([np.cos(angle), np.sin(angle), 0.0]), (-1.0) ** k
        axis = np.array([0.0, 0.0, np.cos(tilt)]) + sign * np.sin(tilt) * np.cross(arm, [0.0, 0.0, 1.0])
        columns.append([*axis, *(np.cross(radius * arm, axis) + sign * drag * axis)])
    return np.array(columns).T


def quad() -> np.ndarray:
    """That of hydrus_xi_quad in its nominal posture."""
    robot = skylimb.load_robot("hydrus_xi_quad")
    posture = robot.description.posture
    theta = posture.theta_nominal
    angles = vectoring_table(robot).angles(theta)
    return robot.at(posture.offset + posture.slope * theta, angles).allocation_C


ROBOTS: dict[str, Callable[[], np.ndarray]] = {
    "hydrus_xi_quad, 4 rotors": quad,
    "ring of 6 tilted rotors": lambda: ring(6),
    "ring of 8 tilted rotors": lambda: ring(8),
}


def weighted(Q: np.ndarray) -> np.ndarray:
    w = Weights()
    rows = [w.sideways, w.sideways, w.lift, w.roll_pitch, w.roll_pitch, w.yaw]
    return np.array(rows)[:, None] * Q


def random_wanted(A: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Thrusts (n, count): a quarter reachable by others, the rest a little to far out of reach, N."""
    n, (low, high) = A.shape[1], _LIMITS
    inside = rng.uniform(low, high, (n, count))
    away = rng.normal(size=(n, count)) * rng.choice([2.0, 10.0, 50.0], count)
    unseen = np.eye(n) - np.linalg.pinv(A) @ A
    wanted = inside + away
    quarter = count // 4
    wanted[:, :quarter] = inside[:, :quarter] + unseen @ away[:, :quarter]
    return wanted


def problems(draws: int) -> Table:
    """A million a robot, certified."""
    table = Table(title=f"{draws} random wrenches a robot")
    for column in (
        "robot",
        "outside of bounds, N",
        "greatest distance from the best wrench",
        "from the reference",
        "feasible, by linear programme",
        "residual there",
        "iterations: mean",
        "most",
    ):
        table.add_column(column)
    for name, matrix in ROBOTS.items():
        A, rng = weighted(matrix()), np.random.default_rng(1)
        n = A.shape[1]
        low, high = (np.full((n, 1), limit) for limit in _LIMITS)
        solve = nearest_in_box(6, n).map(_BLOCK)
        outside = distance = most = total = against = residual = 0.0
        feasible = checked = 0
        for _ in range(max(1, draws // _BLOCK)):
            wanted = random_wanted(A, _BLOCK, rng)
            found, iterations = solve(np.tile(A, _BLOCK), wanted, np.tile(low, _BLOCK), np.tile(high, _BLOCK))
            x = found.full()
            outside = max(outside, float((low - x).max()), float((x - high).max()))
            pull = A.T @ (A @ (x - wanted))
            gap = np.maximum(pull * (x - low), pull * (x - high)).sum(axis=0)
            distance = max(distance, float(np.sqrt(np.maximum(gap, 0.0)).max()))
            most, total = max(most, float(ca.mmax(iterations))), total + float(ca.sum2(iterations))
            for k in range(0, _BLOCK, _BLOCK // 4):
                checked += 1
                bounds = (low.ravel(), high.ravel())
                best = lsq_linear(A, A @ wanted[:, k], bounds, method="bvls", tol=1e-14, max_iter=500).x
                against = max(against, float(np.abs(A @ (x[:, k] - best)).max()))
                plan = linprog(np.zeros(n), A_eq=A, b_eq=A @ wanted[:, k], bounds=[_LIMITS] * n)
                if plan.status == 0:
                    feasible += 1
                    residual = max(residual, float(np.abs(A @ (x[:, k] - wanted[:, k])).max()))
        table.add_row(
            name,
            f"{max(outside, 0.0):.0e}",
            f"{distance:.0e}",
            f"{against:.0e}",
            f"{feasible} of {checked}",
            f"{residual:.0e}",
            f"{total / (max(1, draws // _BLOCK) * _BLOCK):.1f}",
            f"{most:.0f}",
        )
    return table


def call_time(function: ca.Function, inputs: Sequence[np.ndarray], wanted: np.ndarray) -> np.ndarray:
    """Microseconds of each call from Python through CasADi's buffers, as the compiled driver calls a tick."""
    buffer, evaluate = function.buffer()
    arrays = [np.ascontiguousarray(array.ravel(order="F")) for array in inputs]
    results = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
    for i, array in enumerate(arrays):
        buffer.set_arg(i, memoryview(array))  # pyright: ignore
    for i, array in enumerate(results):
        buffer.set_res(i, memoryview(array))  # pyright: ignore
    times = np.full(wanted.shape[1], np.inf)
    for _ in range(5):  # the best of five: what slows a call down from outside has no part in it
        for k in range(wanted.shape[1]):
            arrays[1][:] = wanted[:, k]
            begin = time.perf_counter()
            evaluate()
            times[k] = min(times[k], time.perf_counter() - begin)
    return 1e6 * times


def speed() -> Table:
    """Microseconds a call, by machine code as in flight, and by CasADi's virtual machine."""
    table = Table(title="microseconds a call from Python")
    for column in ("robot", "by", "within limits", "beyond: median", "99 %", "most"):
        table.add_column(column)
    for name, matrix in ROBOTS.items():
        A, rng = weighted(matrix()), np.random.default_rng(2)
        n = A.shape[1]
        low, high = (np.full(n, limit) for limit in _LIMITS)
        inside = rng.uniform(*_LIMITS, (n, 2000))
        beyond = inside + rng.normal(size=inside.shape) * 10.0
        beyond = beyond[:, ((beyond < _LIMITS[0]) | (beyond > _LIMITS[1])).any(axis=0)]
        functions = {"CasADi's virtual machine": nearest_in_box(6, n)}
        if native_available():
            functions["machine code"] = machine_code(nearest_in_box(6, n))
        for by, function in functions.items():
            within, out = (
                call_time(function, (A, inside[:, 0], low, high), wanted) for wanted in (inside, beyond)
            )
            high_end = np.quantile(out, [0.5, 0.99, 1.0])
            table.add_row(name, by, f"{np.median(within):.1f}", *(f"{value:.1f}" for value in high_end))
    return table


def random_push(kind: str, rng: np.random.Generator) -> dict[str, Any]:
    """Half a second of a push harder than the rotors may bear."""
    values: dict[str, Any] = {
        "phases.hover": 0.5,
        "phases.tare": 0.5,
        "phases.hover_end": 0.0,
        "trajectory.duration": 5.0,
        "terminations.distance": _LOST_AFTER,
    }
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    if kind == "a torque at the centre of gravity":
        torque = way * np.array([3.0, 6.0, 8.0]) * rng.uniform(0.5, 1.0)
        push = {"torque": torque.tolist()}
    else:
        force = way * rng.uniform(3.0, 10.0)
        push = {"force": force.tolist(), "link": "link4", "point": [0.3, 0.0, 0.0]}
    return {**values, "events": [{"kind": "push", "time": 1.0, "duration": 0.5, **push}]}


def flights(count: int) -> Table:
    """The same pushes with both allocations."""
    table = Table(title=f"half a second of push on the hovering hydrus_xi_quad, {count} draws")
    columns = (
        "push",
        "controller",
        "allocation",
        "lost",
        "tilt: median, deg",
        "90 %",
        "way off: median, m",
        "90 %",
    )
    for column in columns:
        table.add_column(column)
    for kind in ("a torque at the centre of gravity", "a force on the last link"):
        for preset in ("pid", "hybrid"):
            for law in ("pseudoinverse", "bounded"):
                rng = np.random.default_rng(3)
                with tempfile.TemporaryDirectory() as folder:
                    file = preset_with(preset, law, Path(folder))
                    sets = [random_push(kind, rng) for _ in range(count)]
                    takeoffs = [take_off("push", (file,), seed, s)[0] for seed, s in enumerate(sets)]
                flown = [f for k in range(0, count, 20) for f in fly_native(takeoffs[k : k + 20])]
                lost = np.array([bool(flight.cause) for flight in flown])
                tilt = [np.abs(np.degrees(f.signal("attitude_estimate")[:, :2])).max() for f in flown]
                way = [np.ptp(f.signal("cog_position_estimate"), axis=0).max() for f in flown]
                table.add_row(
                    kind,
                    preset,
                    law,
                    f"{lost.sum()}",
                    *(f"{np.quantile(tilt, share):.0f}" for share in (0.5, 0.9)),
                    *(f"{np.quantile(way, share):.2f}" for share in (0.5, 0.9)),
                )
    return table


def preset_with(preset: str, law: str, folder: Path) -> str:
    """A shipped preset with another allocation law, as a file."""
    shipped = Path(skylimb.__file__).parent / "control" / "presets" / f"{preset}.toml"
    text = shipped.read_text(encoding="utf-8").replace('law = "pseudoinverse"', f'law = "{law}"')
    path = folder / f"{preset}_{law}.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--draws", type=int, default=1_000_000)
    parser.add_argument("--flights", type=int, default=200)
    parser.add_argument("--part", choices=("problems", "speed", "flights"), action="append")
    given = parser.parse_args()
    parts = {
        "problems": lambda: problems(given.draws),
        "speed": speed,
        "flights": lambda: flights(given.flights),
    }
    console = Console(width=160)
    for name in given.part or parts:
        console.print(parts[name]())


if __name__ == "__main__":
    main()
