"""A controller of your own, flown beside one of the paper's.

    python examples/user_controller.py
    skylimb run --controller examples/user_controller.py                  the same from the command line
    skylimb run --controller examples/user_controller.py --set 'controller.velocity=[3, 3, 3]'

The file needs nothing but the function `controller(robot)`, which returns an object with `name`, `gains`,
`initial_state` and `step`. This one uses the operations of `skylimb.symbolic`, so it is compiled and flies as
fast as the controllers that ship.
"""

from typing import Annotated

import skylimb
from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rotation_error, rotation_from_quaternion, rotation_from_rpy
from skylimb.symbolic import arctan2, clip, cross, dot, right_inverse, vector

Vector = tuple[float, float, float]


@configuration
class Gains:
    """What `--set controller.position=...`, campaigns, sweeps and `tune` can change."""

    position: Annotated[Vector, Key("1/s^2", "pull toward the reference", low=0.0, high=100.0)] = (
        3.0,
        3.0,
        4.0,
    )
    velocity: Annotated[Vector, Key("1/s", "damping", low=0.0, high=100.0)] = (2.6, 2.6, 3.0)
    integral: Annotated[Vector, Key("1/s^3", "integral", low=0.0, high=10.0)] = (0.3, 0.3, 0.8)
    attitude: Annotated[Vector, Key("1/s^2", "attitude", low=0.0, high=1000.0)] = (40.0, 40.0, 10.0)
    spin: Annotated[Vector, Key("1/s", "damping of the attitude", low=0.0, high=100.0)] = (13.0, 13.0, 5.0)


class Upright:
    """A PID for the position, a PD for the attitude, and an arm that keeps its posture."""

    name = "upright"

    SIGNALS = {  # noqa: RUF012
        "integral_acceleration": skylimb.Signal("m/s^2", "W", "what the integral adds", "command"),
    }

    def __init__(self, robot: skylimb.Robot) -> None:
        self.robot = robot
        self.most = [rotor.thrust_max for rotor in robot.description.rotors]

    def gains(self) -> Gains:
        return Gains()

    def initial_state(self):
        return vector(0.0, 0.0, 0.0)  # what the integral adds, m/s^2

    def step(self, gains, state, measurement: skylimb.Measurement, reference: skylimb.Reference, dt: float):
        model = self.robot.at(measurement.joint_angles, measurement.vectoring_angles)

        # The motion capture sees link 1; what is to be controlled is the centre of gravity.
        R_WB = rotation_from_quaternion(measurement.quaternion)
        R_WC = R_WB @ model.R_root_C
        spin = model.R_root_C.T @ measurement.angular_velocity
        position = measurement.position + R_WB @ model.cog_root
        velocity = measurement.velocity + R_WB @ cross(measurement.angular_velocity, model.cog_root)

        error = reference.position - position
        integral = clip(state + gains.integral * error * dt, -1.5, 1.5)
        damping = gains.velocity * (reference.velocity - velocity)
        force = model.mass * (gains.position * error + integral + damping + model.gravity)

        # Lean until the thrust points along the wanted force, link 4 toward the surface.
        yaw = reference.heading - model.tip_heading
        level = rotation_from_rpy(0.0, 0.0, yaw).T @ force
        roll = arctan2(-level[1], (level[0] ** 2 + level[2] ** 2) ** 0.5)
        R_wanted = rotation_from_rpy(roll, arctan2(level[0], level[2]), yaw)
        turn = -gains.attitude * rotation_error(R_WC, R_wanted) - gains.spin * spin
        torque = model.inertia_C @ turn + cross(spin, model.inertia_C @ spin)

        # Four rotors, four demands: thrust along z of {C} and the torque.
        demand = vector(dot(force, R_WC[:, 2]), torque[0], torque[1], torque[2])
        thrusts = clip(right_inverse(model.allocation_C[2:, :]) @ demand, 0.0, self.most)
        command = skylimb.Command(thrusts, reference.joint_angles, reference.vectoring_angles)
        signals = {
            "cog_position_estimate": position,
            "force_command": force,
            "integral_acceleration": integral,
        }
        return integral, command, signals


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
