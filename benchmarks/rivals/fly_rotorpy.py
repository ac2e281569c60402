"""One circle with RotorPy, then many flights at once; runs in RotorPy's own environment and prints JSON."""

# pyright: reportMissingImports=false

import json
import sys
import time

import numpy as np
import torch
from rotorpy.controllers.quadrotor_control import BatchedSE3Control, SE3Control
from rotorpy.environments import Environment
from rotorpy.sensors.imu import BatchedImu
from rotorpy.simulate import simulate_batch
from rotorpy.trajectories.circular_traj import ThreeDCircularTraj
from rotorpy.trajectories.minsnap import BatchedMinSnap, MinSnap
from rotorpy.vehicles.crazyflie_params import quad_params
from rotorpy.vehicles.multirotor import BatchedMultirotor, BatchedMultirotorParams, Multirotor
from rotorpy.wind.default_winds import BatchedNoWind
from rotorpy.world import World

RATE = 100  # its example's; each step is integrated by an adaptive Runge-Kutta of order 5
CPU = torch.device("cpu")
SECONDS, SECONDS_OF_MANY = 5.0, 1.0


def one(repeats: int) -> float:
    """Wall seconds of `Environment.run`, its example's call."""

    def fly() -> float:
        flight = Environment(
            vehicle=Multirotor(quad_params),
            controller=SE3Control(quad_params),
            trajectory=ThreeDCircularTraj(radius=np.array([0.5, 0.5, 0.0])),
            sim_rate=RATE,
        )
        start = time.perf_counter()
        result = flight.run(t_final=SECONDS)
        took = time.perf_counter() - start
        if "TIMEOUT" not in str(result["exit"]):
            raise SystemExit(f"RotorPy's flight ended early: {result['exit']}")
        return took

    return min(fly() for _ in range(repeats))


def many(count: int) -> float:
    """Wall seconds of `simulate_batch`."""
    zeros = torch.zeros(count, 3, device=CPU).double()
    start_state = {
        "x": zeros,
        "v": zeros.clone(),
        "q": torch.tensor([0, 0, 0, 1], device=CPU).repeat(count, 1).double(),
        "w": zeros.clone(),
        "wind": zeros.clone(),
        "rotor_speeds": torch.full((count, 4), 1788.53, device=CPU).double(),
    }
    parameters = BatchedMultirotorParams([quad_params] * count, count, CPU)
    vehicle = BatchedMultirotor(parameters, count, start_state, CPU, integrator="rk4")
    controller = BatchedSE3Control(parameters, count, CPU)
    # Its batched circle cannot be flown in 3.0.0 (it multiplies an array by a tensor): all fly a smooth path
    # through points, as in its own example of many.
    path = MinSnap(points=np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]]), v_avg=0.8)
    start = time.perf_counter()
    simulate_batch(
        World.empty((-3, 3, -3, 3, -3, 3)),
        start_state,
        vehicle,
        controller,
        BatchedMinSnap([path] * count, device=CPU),
        BatchedNoWind(count),
        BatchedImu(count),
        np.full(count, SECONDS_OF_MANY),
        1.0 / RATE,
        0.25,
        terminate=False,
    )
    return time.perf_counter() - start


def main() -> None:
    """Measure."""
    options = json.loads(sys.argv[1])
    torch.set_num_threads(1)  # as its example does
    single = one(options["repeats"])
    batches = [
        {"flights": count, "simulated": count * SECONDS_OF_MANY, "wall": many(count)}
        for count in options["batches"]
    ]
    print(json.dumps({"control_rate": RATE, "one": {"simulated": SECONDS, "wall": single}, "many": batches}))


if __name__ == "__main__":
    main()
