"""Every signal that a run records: dimensions, unit, frame, meaning, and whether it is truth or belief."""

from __future__ import annotations

from typing import Literal, NamedTuple

Kind = Literal["truth", "estimate", "reference", "command", "measurement"]


class SignalInfo(NamedTuple):
    """What a signal is.

    Attributes:
        dims: dimensions besides time.
        units: SI, empty for a pure number.
        frame: "W", "C", "root", "imu", or empty.
        long_name: a few words.
        kind: truth, estimate, reference, command or measurement.
    """

    dims: tuple[str, ...]
    units: str
    frame: str
    long_name: str
    kind: Kind


PLACE_TERMS = ("place_proportional", "place_integral", "place_derivative")
"""What a translation law adds up."""
TURN_TERMS = ("turn_proportional", "turn_integral", "turn_derivative")
"""What an attitude law adds up."""

_AXIS, _SCALAR = ("axis",), ()
_QUATERNION, _ROTOR, _JOINT, _VECTORING = ("quaternion",), ("rotor",), ("joint",), ("vectoring",)

SIGNALS: dict[str, SignalInfo] = {
    "cog_position": SignalInfo(_AXIS, "m", "W", "centre of gravity", "truth"),
    "cog_velocity": SignalInfo(_AXIS, "m/s", "W", "velocity of the centre of gravity", "truth"),
    "cog_position_estimate": SignalInfo(
        _AXIS, "m", "W", "centre of gravity, as the controller knows it", "estimate"
    ),
    "cog_velocity_estimate": SignalInfo(
        _AXIS, "m/s", "W", "its velocity, as the controller knows it", "estimate"
    ),
    "cog_position_reference": SignalInfo(
        _AXIS, "m", "W", "the mission's reference of the centre of gravity", "reference"
    ),
    "cog_position_target": SignalInfo(
        _AXIS, "m", "W", "where the control law wants the centre of gravity", "command"
    ),
    "cog_velocity_reference": SignalInfo(_AXIS, "m/s", "W", "reference velocity that was sent", "reference"),
    "cog_acceleration_reference": SignalInfo(
        _AXIS, "m/s^2", "W", "reference acceleration that was sent", "reference"
    ),
    "tip_position_reference": SignalInfo(_AXIS, "m", "W", "tip on the nominal surface", "reference"),
    "attitude": SignalInfo(_AXIS, "rad", "W", "roll, pitch, yaw of the hovering frame", "truth"),
    "attitude_estimate": SignalInfo(
        _AXIS, "rad", "W", "roll, pitch, yaw, as the controller knows them", "estimate"
    ),
    "attitude_target": SignalInfo(_AXIS, "rad", "W", "target roll, pitch, yaw", "command"),
    "angular_velocity_estimate": SignalInfo(_AXIS, "rad/s", "C", "angular velocity", "estimate"),
    "tilt": SignalInfo(
        _SCALAR, "rad", "W", "angle between the hovering frame's z axis and the vertical", "truth"
    ),
    "root_position": SignalInfo(_AXIS, "m", "W", "origin of the root link", "truth"),
    "root_quaternion": SignalInfo(_QUATERNION, "", "W", "attitude of the root link", "truth"),
    "root_position_measured": SignalInfo(_AXIS, "m", "W", "origin of the root link, measured", "measurement"),
    "root_quaternion_measured": SignalInfo(
        _QUATERNION, "", "W", "attitude of the root link, measured", "measurement"
    ),
    "root_velocity_measured": SignalInfo(_AXIS, "m/s", "W", "its velocity, measured", "measurement"),
    "root_angular_velocity_measured": SignalInfo(
        _AXIS, "rad/s", "root", "angular velocity of the root link, measured", "measurement"
    ),
    "capture_age": SignalInfo(
        _SCALAR, "s", "", "age of the motion capture's frame seen now, as its stamp says", "measurement"
    ),
    "imu_angular_velocity_measured": SignalInfo(
        _AXIS, "rad/s", "imu", "angular velocity of the IMU's link, measured", "measurement"
    ),
    "imu_specific_force_measured": SignalInfo(
        _AXIS, "m/s^2", "imu", "acceleration without gravity's share, mean since the last tick", "measurement"
    ),
    "gyro_bias_estimate": SignalInfo(_AXIS, "rad/s", "imu", "bias of the IMU's rates", "estimate"),
    "accelerometer_bias_estimate": SignalInfo(
        _AXIS, "m/s^2", "imu", "bias of the IMU's specific force", "estimate"
    ),
    "external_force_estimate": SignalInfo(_AXIS, "N", "W", "external force, estimated and tared", "estimate"),
    "external_torque_estimate": SignalInfo(
        _AXIS, "N m", "C", "external torque, estimated and tared", "estimate"
    ),
    "external_force_filtered": SignalInfo(
        _SCALAR, "N", "W", "filtered force along the contact axis", "estimate"
    ),
    "thrust_scale_estimate": SignalInfo(
        _SCALAR, "", "", "given over commanded thrust of all rotors", "estimate"
    ),
    "external_force_bias": SignalInfo(_AXIS, "N", "W", "bias of the force estimate taken off", "estimate"),
    "external_torque_bias": SignalInfo(
        _AXIS, "N m", "C", "bias of the torque estimate taken off", "estimate"
    ),
    "contact_force": SignalInfo(
        _AXIS, "N", "W", "contact force on the robot, mean since the last tick", "truth"
    ),
    "contact_force_normal": SignalInfo(_SCALAR, "N", "W", "its part along the surface's normal", "truth"),
    "contact_force_tangential": SignalInfo(_AXIS, "N", "W", "the rest of it, along the surface", "truth"),
    "contact_normal": SignalInfo(_AXIS, "", "W", "outward normal of the surface nearest to the tip", "truth"),
    "contact_trace": SignalInfo(
        ("unrolled",), "m", "", "touch on the unrolled surface; NaN without", "truth"
    ),
    "friction_work": SignalInfo(_SCALAR, "J", "", "energy that friction has taken so far", "truth"),
    "contact_torque": SignalInfo(_AXIS, "N m", "W", "its torque about the centre of gravity", "truth"),
    "contact": SignalInfo(_SCALAR, "", "", "1 when the tip touched since the last tick", "truth"),
    "contact_duty": SignalInfo(
        _SCALAR, "", "", "fraction of physics steps touching since the last tick", "truth"
    ),
    "contact_point": SignalInfo(
        _AXIS, "m", "W", "centre of the contact force since the last tick; NaN without force", "truth"
    ),
    "contact_couple": SignalInfo(
        _AXIS, "N m", "W", "torque about contact_point, of a foot's or peg's several touches", "truth"
    ),
    "slip_speed": SignalInfo(
        _SCALAR, "m/s", "W", "speed of the tip along the surface while touching", "truth"
    ),
    "surface_gap": SignalInfo(
        _SCALAR, "m", "", "gap between tip and surface; negative when pressed in", "truth"
    ),
    "valve_angle": SignalInfo(_SCALAR, "rad", "", "turn of a valve from its first stop", "truth"),
    "peg_depth": SignalInfo(_SCALAR, "m", "", "how far the end of a peg is below the hole's face", "truth"),
    "foot_angle": SignalInfo(_SCALAR, "rad", "", "angle between a foot and the surface below it", "truth"),
    "surface_position": SignalInfo(
        _AXIS, "m", "W", "origin of a surface that was changed in flight", "truth"
    ),
    "surface_quaternion": SignalInfo(
        _QUATERNION, "", "W", "attitude of the axes of a surface that was changed in flight", "truth"
    ),
    "surface_friction": SignalInfo(_SCALAR, "", "", "Coulomb coefficient of a surface that changes", "truth"),
    "surface_stiffness": SignalInfo(
        _SCALAR, "N/m", "", "stiffness of a surface that was changed in flight", "truth"
    ),
    "surface_present": SignalInfo(_SCALAR, "", "", "0 while the surface was taken away", "truth"),
    "tip_position": SignalInfo(_AXIS, "m", "W", "tip", "truth"),
    "tip_velocity": SignalInfo(_AXIS, "m/s", "W", "velocity of the tip", "truth"),
    "reach": SignalInfo(_SCALAR, "m", "", "centre of gravity to tip along the contact axis", "truth"),
    "reach_command": SignalInfo(_SCALAR, "m", "", "commanded reach", "command"),
    "reach_reference": SignalInfo(_SCALAR, "m", "", "nominal reach", "reference"),
    "shape_angle_command": SignalInfo(_SCALAR, "rad", "", "commanded shape angle", "command"),
    "joint_angles": SignalInfo(_JOINT, "rad", "root", "shape joints", "truth"),
    "joint_angles_measured": SignalInfo(_JOINT, "rad", "root", "shape joints, measured", "measurement"),
    "joint_angles_command": SignalInfo(_JOINT, "rad", "root", "shape joints, commanded", "command"),
    "vectoring_angles": SignalInfo(_VECTORING, "rad", "root", "vectoring joints", "truth"),
    "vectoring_angles_measured": SignalInfo(
        _VECTORING, "rad", "root", "vectoring joints, measured", "measurement"
    ),
    "vectoring_angles_command": SignalInfo(
        _VECTORING, "rad", "root", "vectoring joints, commanded", "command"
    ),
    "thrusts": SignalInfo(_ROTOR, "N", "", "rotor thrusts", "truth"),
    "thrusts_command": SignalInfo(_ROTOR, "N", "", "rotor thrusts, commanded", "command"),
    "rotor_speeds": SignalInfo(_ROTOR, "rad/s", "", "speeds of the rotors", "truth"),
    "motor_torques": SignalInfo(_ROTOR, "N m", "", "torques of the rotors' motors", "truth"),
    "force_command": SignalInfo(_AXIS, "N", "W", "wanted force", "command"),
    "torque_command": SignalInfo(_AXIS, "N m", "C", "wanted torque", "command"),
    "place_proportional": SignalInfo(
        _AXIS, "m/s^2", "W", "what the translation law adds up: of the place's error", "command"
    ),
    "place_integral": SignalInfo(_AXIS, "m/s^2", "W", "of an error's integral", "command"),
    "place_derivative": SignalInfo(_AXIS, "m/s^2", "W", "of the velocity's error", "command"),
    "turn_proportional": SignalInfo(
        _AXIS, "rad/s^2", "C", "what the attitude law adds up: of the attitude's error", "command"
    ),
    "turn_integral": SignalInfo(_AXIS, "rad/s^2", "C", "of an error's integral", "command"),
    "turn_derivative": SignalInfo(_AXIS, "rad/s^2", "C", "of the angular velocity's error", "command"),
    "allocation_residual_force": SignalInfo(
        _AXIS, "N", "W", "force that the rotors fall short of: wanted less given", "command"
    ),
    "allocation_residual_torque": SignalInfo(
        _AXIS, "N m", "C", "torque that the rotors fall short of: wanted less given", "command"
    ),
    "vectoring_move": SignalInfo(
        _VECTORING,
        "rad",
        "root",
        "move of the vectoring joints for a side force with the body level",
        "command",
    ),
    "vectoring_margin": SignalInfo(
        _SCALAR,
        "N m",
        "",
        "what planned vectoring angles leave of torque",
        "command",
    ),
    "mission_time": SignalInfo(_SCALAR, "s", "", "time on the mission's own clock", "reference"),
    "pace": SignalInfo(_SCALAR, "", "", "speed of the mission's clock", "command"),
    "contact_state": SignalInfo(_SCALAR, "", "", "state of the contact's state machine", "estimate"),
    "contact_reason": SignalInfo(_SCALAR, "", "", "reason of its last transition", "estimate"),
    "normal_force_estimate": SignalInfo(_SCALAR, "N", "", "estimated normal force", "estimate"),
    "contact_force_commanded": SignalInfo(
        _SCALAR, "N", "", "normal force that the experiment commands; NaN where none", "reference"
    ),
    "contact_force_reference": SignalInfo(
        _SCALAR, "N", "", "normal force that the law commands", "reference"
    ),
    "contact_force_target": SignalInfo(
        _SCALAR, "N", "", "normal force that the law presses with at the moment, after easing", "command"
    ),
    "contact_force_integral": SignalInfo(_SCALAR, "N", "", "integral of the force error, as used", "command"),
    "planned_moves": SignalInfo(
        _AXIS, "m/s^2", "task", "accelerations that a plan asks for now: contact axis, u, v", "command"
    ),
    "plan_age": SignalInfo(_SCALAR, "s", "", "since the plan that is flown was made", "command"),
    "press_reason": SignalInfo(_SCALAR, "", "", "why the law presses as it does", "command"),
    "surface_slope_estimate": SignalInfo(
        _AXIS, "", "W", "estimated rise of the surface along the contact axis a metre of path", "estimate"
    ),
    "surface_gone": SignalInfo(
        _SCALAR, "", "", "how sure it is that the surface has gone from under the tip, 0 to 1", "estimate"
    ),
    "tip_position_estimate": SignalInfo(_AXIS, "m", "W", "tip, as the controller knows it", "estimate"),
    "tip_force_estimate": SignalInfo(
        _AXIS, "N", "task", "estimated force on the robot at its tip: contact axis, u, v", "estimate"
    ),
    "tip_torque_estimate": SignalInfo(
        _AXIS, "N m", "task", "estimated torque on the robot at its tip: contact axis, u, v", "estimate"
    ),
    "tip_move": SignalInfo(_AXIS, "m", "task", "way of the tip's target from its reference", "command"),
    "tip_turn": SignalInfo(_AXIS, "rad", "task", "turn of the tip's target from its reference", "command"),
    "tick_late": SignalInfo(_SCALAR, "s", "", "how late the tick began on the wall clock", "measurement"),
    "tick_latency": SignalInfo(
        _SCALAR, "s", "", "from when the tick was due until its command was ready", "measurement"
    ),
    "tick_held": SignalInfo(
        _SCALAR, "", "", "1 where the command of the tick before was held", "measurement"
    ),
    "loop_delay": SignalInfo(
        _SCALAR,
        "s",
        "",
        "from a measurement until the command that answers it came, as the robot says; 0 where it does not",
        "measurement",
    ),
    "supervisor_mode": SignalInfo(
        _SCALAR, "", "", "mode, by its number in the supervisor's table", "estimate"
    ),
    "rotor_shares_estimate": SignalInfo(
        _ROTOR, "", "", "share of its thrust that each rotor has", "estimate"
    ),
    "lateness_estimate": SignalInfo(
        _SCALAR, "s", "", "how much later than assumed measurements are", "estimate"
    ),
    "rotor_slowness_estimate": SignalInfo(
        _SCALAR, "s", "", "by how much more than assumed the rotors lag", "estimate"
    ),
    "supervisor_bits": SignalInfo(
        _SCALAR, "", "", "bits of the supervisor's table as a number, the first one lowest", "estimate"
    ),
    "retreating": SignalInfo(_SCALAR, "", "", "1 once the flight was broken off", "measurement"),
    "phase": SignalInfo(_SCALAR, "", "", "phase of the mission", "reference"),
    "configuration": SignalInfo(("qpos",), "", "W", "positions of the scene's joints, for viewers", "truth"),
    "skeleton": SignalInfo(("node", "axis"), "m", "W", "points along the chain, root to tip", "truth"),
}
