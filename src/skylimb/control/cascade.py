"""The cascade of the paper's block diagram, composed from the laws that a preset names.

One `step` is the whole controller: measured angles -> model -> body state -> observer -> translation law ->
attitude target -> attitude law -> allocation -> thrusts, and beside it contact force -> shape law -> posture
-> joint and vectoring commands. It is a pure function of records, so it runs on NumPy numbers (slowly, for a
test or a debugger) and on CasADi symbols (once, to be compiled into the tick).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from skylimb.control.allocation import allocate, rotor_wrench
from skylimb.control.attitude.target import attitude_target
from skylimb.control.leak import LeakState, follow_leak, initial_leak_state, without_leak
from skylimb.control.preset import Preset
from skylimb.control.records import Command, LawInput, Reference
from skylimb.estimation.body_state import (
    AngleRateState,
    angle_rates,
    body_state,
    initial_angle_rate_state,
    measured_angles,
)
from skylimb.estimation.force_filter import ForceFilterState, filter_force
from skylimb.estimation.momentum_observer import (
    ObserverState,
    initial_observer_state,
    observe,
    with_known_wrench,
)
from skylimb.estimation.records import Measurement
from skylimb.estimation.tare import TareState, initial_tare_state, tare
from skylimb.packing import numeric
from skylimb.planning.posture import ReachFamily, posture_family
from skylimb.planning.vectoring import VectoringTable, vectoring_table
from skylimb.robots.model import Robot
from skylimb.spatial import dot, rpy_from_rotation

Signals = dict[str, Any]


class CascadeGains(NamedTuple):
    """Every number of a preset that may change without rebuilding the compiled tick."""

    observer: Any
    force_filter: Any
    translation: Any
    attitude: Any
    shape: Any
    leak: Any


class CascadeState(NamedTuple):
    """What the controller remembers from tick to tick."""

    rates: AngleRateState
    observer: ObserverState
    tare: TareState
    force_filter: ForceFilterState
    translation: Any
    attitude: Any
    shape: Any
    leak: LeakState


@dataclass(frozen=True)
class Cascade:
    """A preset made ready to fly one robot.

    Attributes:
        robot: the controller's model of the robot; the plant may differ.
        preset: the laws and their gains.
        family: reach and joint angles of the one-parameter posture.
        vectoring: vectoring angles over the posture.
    """

    robot: Robot
    preset: Preset
    family: ReachFamily
    vectoring: VectoringTable

    symbolic = True
    """The step may be traced with CasADi symbols and compiled."""

    @property
    def paced(self) -> bool:
        """Whether it sets the pace of the mission, by a signal "pace"."""
        return False

    @property
    def name(self) -> str:
        """The preset's name."""
        return self.preset.name

    def gains(self) -> CascadeGains:
        """The preset's gains as arrays."""
        preset = self.preset
        record = CascadeGains(
            preset.observer,
            preset.force_filter,
            preset.translation.gains,
            preset.attitude.gains,
            preset.shape.gains,
            preset.leak,
        )
        return numeric(record)

    def initial_state(self) -> CascadeState:
        """The state before the first tick, the arm at its nominal reach."""
        preset = self.preset
        record = CascadeState(
            initial_angle_rate_state(self.robot),
            initial_observer_state(),
            initial_tare_state(),
            ForceFilterState(0.0),
            preset.translation.law.initial_state(preset.translation.gains),
            preset.attitude.law.initial_state(preset.attitude.gains),
            preset.shape.law.initial_state(preset.shape.gains, self.family.reach_nominal),
            initial_leak_state(),
        )
        return numeric(record)

    def step(
        self,
        gains: CascadeGains,
        state: CascadeState,
        measurement: Measurement,
        reference: Reference,
        dt: float,
    ) -> tuple[CascadeState, Command, Signals]:
        """One control tick.

        Args:
            gains: from `gains`, or symbols in their place.
            state: of the last tick.
            measurement: of this tick.
            reference: of this tick.
            dt: control period, s.

        Returns:
            The new state, the command, and every inner signal by its public name.
        """
        preset = self.preset
        rates, angle_rate = angle_rates(state.rates, measured_angles(measurement), dt)
        body = body_state(self.robot, measurement, angle_rate)
        rpy = rpy_from_rotation(body.R_WC)

        observer, raw = observe(gains.observer, state.observer, body, dt)
        tare_state, wrench = tare(state.tare, raw, rpy[2], reference.tare)
        wrench = wrench if preset.tare else raw
        force_along_axis = dot(wrench.force, reference.contact_axis)
        force_filter, contact_force = filter_force(
            gains.force_filter.cutoff, state.force_filter, force_along_axis, dt
        )
        inputs = LawInput(body, reference, wrench, contact_force, dt)

        translation, force = preset.translation.law.step(gains.translation, state.translation, inputs)
        force = without_leak(gains.leak, state.leak, force)
        heading = self._heading(body.model.tip_heading, reference)
        target, R_target = attitude_target(force, rpy[2], heading)
        attitude, torque = preset.attitude.law.step(gains.attitude, state.attitude, inputs, R_target)

        rotors = self.robot.description.rotors
        thrust_min = np.array([rotor.thrust_min for rotor in rotors])
        thrust_max = np.array([rotor.thrust_max for rotor in rotors])
        thrusts = allocate(body.model, body.R_WC, force, torque, thrust_min, thrust_max)
        rotor_force, rotor_torque = rotor_wrench(body.model, body.R_WC, thrusts.total)
        observer = with_known_wrench(observer, body, rotor_force, rotor_torque)
        leak_force, _ = rotor_wrench(body.model, body.R_WC, thrusts.rotation)
        leak = follow_leak(gains.leak, state.leak, leak_force, dt)

        shape, reach = preset.shape.law.step(
            gains.shape, state.shape, inputs, (self.family.reach_min, self.family.reach_max)
        )
        joint_angles, vectoring_angles, theta = self._posture(reach, reference)
        command = Command(thrusts.total, joint_angles, vectoring_angles)

        new_state = CascadeState(
            rates, observer, tare_state, force_filter, translation, attitude, shape, leak
        )
        return (
            new_state,
            command,
            {
                "cog_position_estimate": body.position,
                "cog_velocity_estimate": body.velocity,
                "angular_velocity_estimate": body.angular_velocity,
                "attitude_estimate": rpy,
                "attitude_target": target,
                "external_force_estimate": wrench.force,
                "external_torque_estimate": wrench.torque,
                "external_force_filtered": contact_force,
                "external_force_bias": raw.force - wrench.force,
                "external_torque_bias": raw.torque - wrench.torque,
                "force_command": force,
                "torque_command": torque,
                "reach_command": reach,
                "shape_angle_command": theta,
            },
        )

    def _heading(self, tip_heading: Any, reference: Reference) -> Any:
        """The heading of {C}, rad, that puts the tip link on its own, as the joints turn."""
        nominal = self.robot.model(reference.joint_angles, reference.vectoring_angles).tip_heading
        return reference.heading - nominal - reference.align * (tip_heading - nominal)

    def _posture(self, reach: Any, reference: Reference) -> tuple[Any, Any, Any]:
        """Joint, vectoring and shape angles of a reach: the nominal posture moved along the family."""
        theta, nominal = self.family.shape_angle(reach), self.family.shape_angle(reference.reach)
        joint_angles = (
            reference.joint_angles + self.family.joint_angles(theta) - self.family.joint_angles(nominal)
        )
        moved = self.vectoring.angles(theta) - self.vectoring.angles(nominal)
        return joint_angles, reference.vectoring_angles + moved, theta


def build_cascade(robot: Robot, preset: Preset) -> Cascade:
    """A cascade with the robot's posture family and vectoring table."""
    return Cascade(robot, preset, posture_family(robot), vectoring_table(robot))
