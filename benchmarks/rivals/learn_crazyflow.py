"""Steps of crazyflow's own environments to learn in; runs in crazyflow's environment and prints JSON."""

# pyright: reportMissingImports=false

import json
import os
import sys
import time

import jax
import numpy as np
from crazyflow.envs.reach_pos_env import ReachPosEnv

RATE, SECONDS = 50, 5.0


def rates(count: int, repeats: int) -> tuple[float, float]:
    """Physics steps a second of its simulator alone, and of environments that step it at 50 Hz."""
    env = ReachPosEnv(num_envs=count, freq=RATE)
    moves = round(SECONDS * RATE)
    space = env.single_action_space
    rng = np.random.default_rng(0)
    actions = rng.uniform(space.low, space.high, (moves, count, len(space.low))).astype(np.float32)
    env.reset(seed=0)

    def alone() -> float:
        env.sim.reset()
        start = time.perf_counter()
        for _ in range(moves):
            env.sim.step(env.n_substeps)
        jax.block_until_ready(env.sim.data.states.pos)
        return time.perf_counter() - start

    def learning() -> float:
        start = time.perf_counter()
        env.reset()
        for action in actions:
            env.step(action)
        jax.block_until_ready((env.obs(), env.reward()))
        return time.perf_counter() - start

    alone()
    learning()  # both compile
    steps = count * moves * env.n_substeps
    both = [(alone(), learning()) for _ in range(repeats)]
    return steps / min(one for one, _ in both), steps / min(one for _, one in both)


def main() -> None:
    """Measure, on one core."""
    options = json.loads(sys.argv[1])
    os.sched_setaffinity(0, {0})
    raw, own = rates(options["environments"], options["repeats"])
    print(json.dumps({"raw": raw, "own": own}))


if __name__ == "__main__":
    main()
