"""Steps of RotorPy's own environments to learn in; runs in RotorPy's environment and prints JSON."""

# pyright: reportMissingImports=false

import json
import os
import sys
import time

import numpy as np
import torch
from rotorpy.learning.quadrotor_environments import QuadrotorEnv
from rotorpy.vehicles.crazyflie_params import quad_params

RATE, SECONDS = 100, 2.0


def rates(count: int, repeats: int) -> tuple[float, float]:
    """Physics steps a second of its batch of vehicles alone, and of environments that step it at 100 Hz."""
    zeros = torch.zeros(count, 3).double()
    start_state = {
        "x": zeros,
        "v": zeros.clone(),
        "q": torch.tensor([0, 0, 0, 1]).repeat(count, 1).double(),
        "w": zeros.clone(),
        "wind": zeros.clone(),
        "rotor_speeds": torch.full((count, 4), 1788.53).double(),
    }
    env = QuadrotorEnv(count, start_state, "cmd_motor_speeds", quad_params=quad_params, sim_rate=RATE)
    moves = round(SECONDS * RATE)
    actions = np.random.default_rng(0).uniform(-0.2, 0.2, (moves, count, 4)).astype(np.float32)
    hover = {"cmd_motor_speeds": torch.full((count, 4), 1788.53).double()}

    def alone() -> float:
        state = {name: value.clone() for name, value in start_state.items()}
        start = time.perf_counter()
        for _ in range(moves):
            state = env.quadrotors.step(state, hover, 1.0 / RATE)
        return time.perf_counter() - start

    def learning() -> float:
        start = time.perf_counter()
        env.reset(seed=0)
        for action in actions:
            env.step(action)
        return time.perf_counter() - start

    steps = count * moves
    both = [(alone(), learning()) for _ in range(repeats)]
    return steps / min(one for one, _ in both), steps / min(one for _, one in both)


def main() -> None:
    """Measure, on one core."""
    options = json.loads(sys.argv[1])
    os.sched_setaffinity(0, {0})
    torch.set_num_threads(1)
    raw, own = rates(options["environments"], options["repeats"])
    print(json.dumps({"raw": raw, "own": own}))


if __name__ == "__main__":
    main()
