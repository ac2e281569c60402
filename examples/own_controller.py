"""A controller of your own in plain NumPy, flown beside one of the paper's.

    python examples/own_controller.py
    skylimb run --controller examples/own_controller.py       the same from the command line

The file needs nothing but the function `controller(robot)`, which returns an object with `name`, `gains`,
`initial_state` and `step`.
"""

import numpy as np

import skylimb
from skylimb.spatial import rotation_error, rotation_from_quaternion, rotation_from_rpy

GRAVITY = np.array([0.0, 0.0, 9.80665])


class Upright:
    """A PID for the position, a PD for the attitude, and an arm that keeps its posture."""

    name = "upright"

    def __init__(self, robot: skylimb.Robot) -> None:
        self.robot = robot
        self.most = np.array([rotor.thrust_max for rotor in robot.description.rotors])

    def gains(self) -> dict[str, np.ndarray]:
        return {
            "position": np.array([3.0, 3.0, 4.0]),  # 1/s^2
            "velocity": np.array([2.6, 2.6, 3.0]),  # 1/s
            "integral": np.array([0.3, 0.3, 0.8]),  # 1/s^3
            "attitude": np.array([40.0, 40.0, 10.0]),  # 1/s^2
            "spin": np.array([13.0, 13.0, 5.0]),  # 1/s
        }

    def initial_state(self) -> np.ndarray:
        return np.zeros(3)  # what the integral asks for, m/s^2

    def step(self, gains, state, measurement: skylimb.Measurement, reference: skylimb.Reference, dt: float):
        model = self.robot.at(measurement.joint_angles, measurement.vectoring_angles)

        # The motion capture sees link 1; what is to be controlled is the centre of gravity.
        R_WB = rotation_from_quaternion(measurement.quaternion)
        R_WC = R_WB @ model.R_root_C
        spin = model.R_root_C.T @ measurement.angular_velocity
        position = measurement.position + R_WB @ model.cog_root
        velocity = measurement.velocity + R_WB @ np.cross(measurement.angular_velocity, model.cog_root)

        error = reference.position - position
        integral = np.clip(state + gains["integral"] * error * dt, -1.5, 1.5)
        wished = gains["position"] * error + integral + gains["velocity"] * (reference.velocity - velocity)
        force = model.mass * (wished + GRAVITY)

        # Lean until the thrust points along the wanted force, link 4 toward the surface.
        yaw = reference.heading - model.tip_heading
        ahead, aside = (
            np.cos(yaw) * force[0] + np.sin(yaw) * force[1],
            np.cos(yaw) * force[1] - np.sin(yaw) * force[0],
        )
        R_wanted = rotation_from_rpy(
            np.arctan2(-aside, np.hypot(ahead, force[2])), np.arctan2(ahead, force[2]), yaw
        )
        turn = -gains["attitude"] * rotation_error(R_WC, R_wanted) - gains["spin"] * spin
        torque = model.inertia_C @ turn + np.cross(spin, model.inertia_C @ spin)

        # Four rotors, four demands: thrust along z of {C} and the torque.
        thrusts = np.linalg.solve(model.allocation_C[2:], [force @ R_WC[:, 2], *torque])
        thrusts = np.clip(thrusts, 0.0, self.most)
        command = skylimb.Command(thrusts, reference.joint_angles, reference.vectoring_angles)
        return integral, command, {"cog_position_estimate": position, "force_command": force}


def controller(robot: skylimb.Robot) -> Upright:
    """What skylimb calls when this file is named as a controller."""
    return Upright(robot)


def main() -> None:
    runs = skylimb.compare("paper", controllers=("hybrid", __file__))
    for name, run in runs.items():
        error, push = run.metrics["error_u_median"], run.metrics["contact_force_normal_mean"]
        print(f"{name:>8}: {run.status}, median y error {error:.3f} m, mean contact force {push:.2f} N")


if __name__ == "__main__":
    main()
