"""What a pen that slides on a plane says of a motion capture that is turned.

    python benchmarks/contact_teaches.py [--draws 24] [--shape circle]

While the pen touches, the measured link, its attitude and the encoders put the tip on one plane, whose place
and slope nobody knows. With the measured attitude R, the tip t(q) in the link's axes and a small turn e
between the two,

    n . (p + R t + R [t] e) = d,

which is least squares in n, d and e, with the prior of the draws for e (uniform in +-1 degree) and the noise
that the fit itself leaves. The draws are those of benchmarks/following.py, flown by `following`; printed is
the error about each axis of the link before and after, and how much of the prior is left.
"""

from __future__ import annotations

import argparse

import numpy as np
from following import CHUNK, draws  # beside this file

from skylimb.analysis.recording.run import Run
from skylimb.base.rotations import hat, rotation_from_quaternion
from skylimb.control.contact.machine import SLIDE
from skylimb.control.controller import load_controller
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.loader import load_robot
from skylimb.robots.model import Robot

PRIOR = np.radians(1.0) / np.sqrt(3.0)
EVERY, ROUNDS = 8, 6


def turned(run: Run, robot: Robot, latency: float) -> tuple[np.ndarray, np.ndarray]:
    """e, rad, (3,), and its standard deviation over that of the prior, (3,); `latency` is the true one, s."""
    log = run.log
    sliding = np.flatnonzero(log.contact_state.values == SLIDE)[200::EVERY]
    late = round(latency * 200.0)
    place, quaternion = (
        log[name].values[sliding] for name in ("root_position_measured", "root_quaternion_measured")
    )
    joints = log.joint_angles_measured.values[sliding - late]
    vectoring = log.vectoring_angles_measured.values[sliding - late]
    attitude = np.array([rotation_from_quaternion(one) for one in quaternion])
    arm = np.array([robot.at(q, psi).tip_root for q, psi in zip(joints, vectoring, strict=True)])
    tip = place + np.einsum("kij,kj->ki", attitude, arm)
    lever = np.array([R @ hat(t) for R, t in zip(attitude, arm, strict=True)])
    # n = (1, a, b): the contact axis is x.
    found = np.zeros(6)
    left = np.eye(6)
    for _ in range(ROUNDS):
        normal = np.array([1.0, *found[:2]])
        moved = tip + lever @ found[3:]
        rows = np.column_stack([moved[:, 1:], -np.ones(len(tip)), np.einsum("i,kij->kj", normal, lever)])
        residual = moved @ normal - found[2]
        noise = max(float(np.std(residual)), 1e-5)
        prior = np.diag([0.0, 0.0, 0.0, *[PRIOR**-2] * 3])
        information = rows.T @ rows / noise**2 + prior
        slope = rows.T @ residual / noise**2 + prior @ found
        found = found - np.linalg.solve(information, slope)
        left = np.linalg.inv(information)
    return found[3:], np.sqrt(np.diag(left)[3:]) / PRIOR


def main() -> None:
    """Fly, fit, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=24)
    parser.add_argument("--shape", default="circle", help="path on the board: circle, line")
    options = parser.parse_args()
    robot = load_robot("hydrus_xi_quad")
    controller = load_controller("following", robot)
    experiments = [
        load_experiment("paper", {**drawn, "trajectory.shape": options.shape})
        for drawn in draws("paper", options.draws)
    ]
    error, left = [], []
    for begin in range(0, len(experiments), CHUNK):
        ready = [prepare(one, robot, controller) for one in experiments[begin : begin + CHUNK]]
        for takeoff, flight in zip(ready, fly_native(ready), strict=True):
            sensors = takeoff.experiment.sensors
            found, share = turned(scored_run(takeoff, flight), robot, sensors.latency)
            truth = np.asarray(sensors.attitude_misalignment)
            error.append([truth, found - truth])
            left.append(share)
    size = np.degrees(np.sqrt(np.mean(np.square(error), axis=0)))
    print(f"{options.shape}, {len(left)} draws, rms over the draws, degrees about x, y, z of the link")
    print("before", np.round(size[0], 3), "after", np.round(size[1], 3))
    print("share of the prior's deviation that the fit believes is left", np.round(np.mean(left, axis=0), 3))


if __name__ == "__main__":
    main()
