"""One hover with crazyflow, then many at once; runs in crazyflow's own environment and prints JSON."""

# pyright: reportMissingImports=false

import json
import sys
import time

import jax
import numpy as np
from crazyflow.control import Control
from crazyflow.sim import Sim

SECONDS = 5.0
HEIGHT = 0.5


def hover(count: int, repeats: int) -> tuple[float, int]:
    """Wall seconds of its example, a hover under state control, and control ticks a second."""
    sim = Sim(n_worlds=count, n_drones=1, control=Control.state)
    command = np.zeros((count, 1, 16))
    command[..., 12] = 1.0  # quaternion of no rotation
    command[..., 2] = HEIGHT
    steps, ticks = sim.freq // sim.control_freq, round(SECONDS * sim.control_freq)

    def fly() -> float:
        sim.reset()
        start = time.perf_counter()
        for _ in range(ticks):
            sim.state_control(command)
            sim.step(steps)
        jax.block_until_ready(sim.data.states.pos)
        return time.perf_counter() - start

    fly()  # compiles
    took = min(fly() for _ in range(repeats))
    heights = np.asarray(sim.data.states.pos)[..., 2]
    if not np.allclose(heights, HEIGHT, atol=0.2):
        raise SystemExit(f"crazyflow's flight is not near its hover: {heights.min()} .. {heights.max()} m")
    return took, sim.control_freq


def main() -> None:
    """Measure."""
    options = json.loads(sys.argv[1])
    single, rate = hover(1, options["repeats"])
    batches = [
        {"flights": count, "simulated": count * SECONDS, "wall": hover(count, 1)[0]}
        for count in options["batches"]
    ]
    print(json.dumps({"control_rate": rate, "one": {"simulated": SECONDS, "wall": single}, "many": batches}))


if __name__ == "__main__":
    main()
