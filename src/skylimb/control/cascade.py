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

from skylimb.config import to_mapping
from skylimb.control.allocation import allocate, rotor_wrench
from skylimb.control.attitude.target import attitude_target
from skylimb.control.lateral import lateral_move
from skylimb.control.leak import LeakState, follow_leak, initial_leak_state, without_leak
from skylimb.control.needs import Needs
from skylimb.control.preset import PARTS, SLOTS, Preset
from skylimb.control.records import Command, LawInput
from skylimb.estimation.body_state import (
    AngleRateState,
    angle_rates,
    body_state,
    initial_angle_rate_state,
    measured_angles,
)
from skylimb.estimation.calibration import calibrated, fed_bias, follow_bias, initial_correction
from skylimb.estimation.delay import (
    delayed_wrench,
    initial_delay_state,
    known_wrench,
    lead_thrusts,
    predict,
    remember,
    require_history,
)
from skylimb.estimation.force_filter import ForceFilterState, filter_force
from skylimb.estimation.momentum_observer import (
    ObserverState,
    initial_observer_state,
    observe,
    with_known_wrench,
)
from skylimb.estimation.records import BodyState, Measurement, Wrench
from skylimb.estimation.tare import TareState, initial_tare_state, tare
from skylimb.missions.reference import Reference
from skylimb.packing import numeric
from skylimb.planning.posture import ReachFamily, posture_family
from skylimb.planning.vectoring import VectoringTable, vectoring_table
from skylimb.robots.model import Robot
from skylimb.spatial import dot, rpy_from_rotation
from skylimb.symbolic import right_inverse, stack

Signals = dict[str, Any]


class CascadeGains(NamedTuple):
    """Every number of a preset that may change without rebuilding the compiled tick."""

    angle_rates: Any
    observer: Any
    force_filter: Any
    calibration: Any
    delay: Any
    contact: Any
    translation: Any
    attitude: Any
    shape: Any
    leak: Any
    vectoring: Any


class ReachMotion(NamedTuple):
    """Reach that was commanded at the last tick, m, and its rate, m/s."""

    reach: Any
    rate: Any


class CascadeState(NamedTuple):
    """What the controller remembers from tick to tick; an empty tuple stands for a part that is off."""

    rates: AngleRateState
    observer: ObserverState
    tare: TareState
    force_filter: ForceFilterState
    correction: Any
    delay: Any
    contact: Any
    translation: Any
    attitude: Any
    shape: Any
    reach: Any
    leak: LeakState
    move: Any


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
        return bool(getattr(self.preset.contact.law, "PACED", False))

    @property
    def name(self) -> str:
        """The preset's name."""
        return self.preset.name

    @property
    def needs(self) -> Needs:
        """What its laws need of the loop."""
        return Needs(paced=self.paced, vectoring=self.preset.vectoring.purpose)

    def require(self, dt: float) -> None:
        """Raise a `ConfigError` when a law cannot be flown with ticks of `dt` seconds."""
        require_history(self.preset.delay, dt)

    def structure(self) -> tuple[Any, ...]:
        """Everything that the traced step depends on besides its arguments."""
        family, table = self.family, self.vectoring
        # Functions are compared by identity, so that a law that was loaded anew is traced anew.
        return (
            type(self),
            self.robot,
            tuple(getattr(self.preset, slot).law.step for slot in SLOTS),
            self.preset.tare,
            (family.theta_min, family.theta_max, family.theta_nominal, family.described, family.coefficients),
            (table.theta_min, table.theta_max, table.digest, np.asarray(table.coefficients).tobytes()),
        )

    def tables(self) -> dict[str, Any]:
        """The preset as plain tables."""
        preset = self.preset
        tables: dict[str, Any] = {"name": preset.name, "description": preset.description, "tare": preset.tare}
        for part in PARTS:
            tables[part] = to_mapping(getattr(preset, part))
        for slot in SLOTS:
            filled = getattr(preset, slot)
            tables[slot] = {"law": filled.name, **to_mapping(filled.gains)}
        return tables

    def gains(self) -> CascadeGains:
        """The preset's gains as arrays."""
        preset = self.preset
        parts = {
            name: getattr(preset, name).gains if name in SLOTS else getattr(preset, name)
            for name in CascadeGains._fields
        }
        return numeric(CascadeGains(**parts))

    def initial_state(self) -> CascadeState:
        """The state before the first tick, the arm at its nominal reach."""
        preset, family = self.preset, self.family
        theta = family.theta_nominal
        hover = self.robot.at(family.joint_angles(theta), self.vectoring.angles(theta)).hover_thrusts
        record = CascadeState(
            initial_angle_rate_state(self.robot),
            initial_observer_state(),
            initial_tare_state(),
            ForceFilterState(0.0),
            initial_correction() if preset.calibration.used else (),
            initial_delay_state(hover) if preset.delay.compensate else (),
            preset.contact.law.initial_state(preset.contact.gains),
            preset.translation.law.initial_state(preset.translation.gains),
            preset.attitude.law.initial_state(preset.attitude.gains),
            preset.shape.law.initial_state(preset.shape.gains, family.reach_nominal),
            ReachMotion(family.reach_nominal, 0.0) if self.paced else (),
            initial_leak_state(),
            np.zeros(self.robot.n_vectoring) if preset.vectoring.move else (),
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
        # What is known: body, external wrench, contact force.
        rates, angle_rate = angle_rates(gains.angle_rates, state.rates, measured_angles(measurement), dt)
        measured = body_state(self.robot, measurement, angle_rate)
        observer, raw = observe(gains.observer, state.observer, measured, dt)
        yaw = rpy_from_rotation(measured.R_WC)[2]
        tare_state, wrench = tare(state.tare, raw, yaw, reference.tare)
        wrench = wrench if preset.tare else raw
        body = predict(gains.delay, state.delay, measured, raw, dt) if preset.delay.compensate else measured
        correction, bias, arm = state.correction, None, body.R_WC @ body.model.tip_C
        if preset.calibration.used:
            bias = fed_bias(gains.calibration, correction, yaw)
            body, arm = calibrated(gains.calibration, correction, body)
            correction = follow_bias(gains.calibration, correction, tare_state, reference.tare, dt)
        rpy = rpy_from_rotation(body.R_WC)
        force_filter, contact_force = filter_force(
            gains.force_filter.cutoff, state.force_filter, dot(wrench.force, reference.contact_axis), dt
        )
        rate = state.reach.rate if self.paced else 0.0
        inputs = LawInput(body, reference, wrench, contact_force, dt, arm, bias, reach_rate=rate)
        contact, view, told = preset.contact.law.step(gains.contact, state.contact, inputs)
        inputs = inputs._replace(contact=view)

        # What is wanted: reach, force, attitude, torque.
        limits = (self.family.reach_min, self.family.reach_max)
        shape, reach = preset.shape.law.step(gains.shape, state.shape, inputs, limits)
        joint_angles, vectoring_angles, theta = self._posture(reach, reference)
        translation, force = preset.translation.law.step(gains.translation, state.translation, inputs)
        wanted = force - bias.force if bias is not None else force
        force = without_leak(gains.leak, state.leak, wanted)
        heading = self._heading(body.model.tip_heading, reference)
        target, R_target = attitude_target(force, rpy[2], heading)
        attitude, torque = preset.attitude.law.step(gains.attitude, state.attitude, inputs, R_target)
        torque = torque - bias.torque if bias is not None else torque

        # What the rotors are told.
        thrust_min, thrust_max = self._thrust_limits
        moved, lift = wanted if preset.vectoring.move else force, preset.vectoring.lift
        thrusts = allocate(body.model, body.R_WC, moved, torque, thrust_min, thrust_max, lift)
        told_thrusts, delay, observer = self._told(gains, state.delay, observer, body, thrusts.total, dt)
        leak_force = self._leak_force(body, thrusts.rotation, wrench, bias)
        lateral = state.move
        if preset.vectoring.move:
            lateral, side = lateral_move(
                self.robot,
                gains.vectoring,
                state.move,
                measurement.joint_angles,
                vectoring_angles,
                body.R_WC.T @ wanted,
                torque,
                dt,
            )
            vectoring_angles, leak_force = vectoring_angles + lateral, body.R_WC @ side
            behind = vectoring_angles - measurement.vectoring_angles
            vectoring_angles = vectoring_angles + (gains.vectoring.lead - 1.0) * behind
        leak = follow_leak(gains.leak, state.leak, leak_force, dt)
        command = Command(told_thrusts, joint_angles, vectoring_angles)

        new_state = CascadeState(
            rates,
            observer,
            tare_state,
            force_filter,
            correction,
            delay,
            contact,
            translation,
            attitude,
            shape,
            ReachMotion(reach, (reach - state.reach.reach) * (1.0 / dt)) if self.paced else (),
            leak,
            lateral,
        )
        if hasattr(preset.translation.law, "cog_target"):
            told["cog_position_target"] = preset.translation.law.cog_target(gains.translation, inputs)
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
                **told,
            },
        )

    def _told(
        self, gains: CascadeGains, delay: Any, observer: ObserverState, body: BodyState, total: Any, dt: float
    ) -> tuple[Any, Any, ObserverState]:
        """Thrusts that the rotors are told, N, and what delay and observer know after them."""
        if not self.preset.delay.compensate:
            rotor_force, rotor_torque = rotor_wrench(body.model, body.R_WC, total)
            return total, delay, with_known_wrench(observer, body, rotor_force, rotor_torque)
        told, acting, after = lead_thrusts(gains.delay, delay, total, *self._thrust_limits, dt)
        wrench_now = rotor_wrench(body.model, body.R_WC, acting)
        delay = remember(delay, after, stack(*known_wrench(*wrench_now, body)))
        known = delayed_wrench(gains.delay, delay, dt)
        return told, delay, observer._replace(known_force=known[0:3], known_torque=known[3:6])

    def _leak_force(self, body: BodyState, rotation: Any, wrench: Wrench, bias: Wrench | None) -> Any:
        """Side force of the thrusts that turn the robot, or that hold its attitude, W, N."""
        if self.preset.leak.steady:
            holding = -wrench.torque - (bias.torque if bias is not None else 0.0)
            rotation = right_inverse(body.model.allocation_C[2:, :]) @ stack(0.0, holding)
        return rotor_wrench(body.model, body.R_WC, rotation)[0]

    @property
    def _thrust_limits(self) -> tuple[np.ndarray, np.ndarray]:
        rotors = self.robot.description.rotors
        return (
            np.array([rotor.thrust_min for rotor in rotors]),
            np.array([rotor.thrust_max for rotor in rotors]),
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
    table = vectoring_table(robot, preset.vectoring.purpose)
    return Cascade(robot, preset, posture_family(robot), table)
