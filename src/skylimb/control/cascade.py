"""The cascade of the paper's block diagram: six slots in a row, each filled with a law.

    measurement -> estimation -> contact -> shape -> translation -> attitude -> allocation -> command

One `step` is the whole controller. It is a pure function of records, so it runs on NumPy numbers (slowly,
for a test or a debugger) and on CasADi symbols (once, to be compiled into the tick).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Table
from skylimb.base.packing import numeric, structure
from skylimb.base.rotations import rpy_from_rotation
from skylimb.base.signals import Signal
from skylimb.base.split_function import Asked
from skylimb.control.attitude.target import attitude_target
from skylimb.control.corrections import (
    CALIBRATION,
    Corrections,
    correction_table,
    for_rotors,
    turned_back,
)
from skylimb.control.estimation.estimate import wrench_signals
from skylimb.control.estimation.records import Measurement, Sensed, Signals, Start
from skylimb.control.laws.fields import require_fit
from skylimb.control.laws.monitor import LawMonitor
from skylimb.control.laws.prepared_gains import handed, settled
from skylimb.control.laws.preset import Preset
from skylimb.control.laws.preset_keys import preset_tables, with_gains
from skylimb.control.laws.python_laws import OpenLaw
from skylimb.control.laws.slots import SLOTS, LiveGains, Slots, traced_functions
from skylimb.control.laws.trial import tried
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import Needs
from skylimb.control.planning.posture import ReachFamily, posture_family, standing
from skylimb.control.planning.vectoring import VectoringTable, vectoring_table
from skylimb.control.posture import heading_of, posture_of
from skylimb.control.press import own_force, wanted_force
from skylimb.control.records import NOTHING, Command, Demand, LawInput
from skylimb.control.terms import without_terms
from skylimb.control.thrust_and_angle import from_pairs, without_angles
from skylimb.robots.model import Robot


@dataclass(frozen=True)
class Cascade:
    """A preset made ready to fly one robot.

    Attributes:
        robot: the controller's model of the robot; the plant may differ. Its laws fly `robot.pairs`.
        preset: the laws and their gains.
        family: reach and joint angles of the one-parameter posture.
        vectoring: vectoring angles over the posture.
        corrections: what a calibration found; `robot` is then the robot that it believes in.
        tells: whether its signals have what its laws add up (`skylimb.control.terms`).
    """

    robot: Robot
    preset: Preset
    family: ReachFamily
    vectoring: VectoringTable
    corrections: Corrections | None = None
    tells: bool = False

    def step(
        self,
        gains: LiveGains,
        state: Slots,
        measurement: Measurement,
        reference: Reference,
        dt: float,
        monitor: LawMonitor | None = None,
    ) -> tuple[Slots, Command, Signals]:
        """One control tick.

        Args:
            gains: of each slot, from `gains`, or symbols in their place.
            state: of each slot, of the last tick.
            measurement: of this tick.
            reference: of this tick.
            dt: control period, s.
            monitor: records what the laws read and give, and holds them to what they declare.

        Returns:
            The new state, the command, and every inner signal by its public name.
        """
        laws, monitor = self.preset.laws, monitor or LawMonitor(self.preset.slots)
        robot = self.robot.pairs
        gains = handed(self.preset, robot, gains, self.gains())
        if self.corrections is not None:
            measurement = turned_back(self.corrections, measurement)
        measurement, reference = (
            without_angles(self.robot, measurement),
            without_angles(self.robot, reference),
        )

        # 1. What is known of body and external wrench.
        sensed = Sensed(robot, measurement, reference, dt)
        estimation, known, of_estimation = laws.estimation.step(gains.estimation, state.estimation, sensed)
        monitor.gave("estimation", known)
        missing = monitor.residual(state.allocation)
        inputs = LawInput(robot, measurement, reference, dt, known, residual=missing)
        inputs = inputs._replace(force=wanted_force(reference.force, own_force(gains.translation)))
        body, bias = known.body, known.bias or NOTHING
        scale = 1.0 if known.scale is None else known.scale

        # 2. Whether there is contact, and where its surface leads.
        contact, view, of_contact = laws.contact.step(
            gains.contact, state.contact, monitor.inputs("contact", inputs)
        )
        monitor.gave("contact", view)
        inputs = inputs._replace(contact=view)

        # 3. How far the arm reaches.
        limits = (self.family.reach_min, self.family.reach_max)
        shape, arm, of_shape = laws.shape.step(
            gains.shape, state.shape, monitor.inputs("shape", inputs), limits
        )
        monitor.gave("shape", arm)
        posture = posture_of(self.family, self.vectoring, arm.reach, reference)
        inputs = inputs._replace(arm=arm)

        # 4. The wanted force on the centre of gravity.
        translation, wanted, of_translation = laws.translation.step(
            gains.translation, state.translation, monitor.inputs("translation", inputs)
        )
        force = (wanted - bias.force) / scale

        # 5. The attitude that points the thrust along it, and the torque that gets there.
        to_allocate = monitor.inputs("allocation", inputs)
        aimed = laws.allocation.aim(gains.allocation, state.allocation, to_allocate, force)
        rpy, heading = rpy_from_rotation(body.R_WC), heading_of(robot, body.model.tip_heading, reference)
        target, R_target = attitude_target(aimed, rpy[2], heading)
        attitude, turning, of_attitude = laws.attitude.step(
            gains.attitude, state.attitude, monitor.inputs("attitude", inputs), R_target
        )
        torque = (turning - bias.torque) / scale

        # 6. Thrusts and vectoring angles. The estimation has to know what they really do.
        demand = Demand(force, aimed, torque, posture.joint_angles, posture.vectoring_angles)
        allocation, given, of_allocation = laws.allocation.step(
            gains.allocation, state.allocation, to_allocate, demand
        )
        estimation = laws.estimation.commanded(gains.estimation, estimation, known, given.wrench, dt)

        signals = {
            "cog_position_estimate": body.position,
            "cog_velocity_estimate": body.velocity,
            "angular_velocity_estimate": body.angular_velocity,
            "attitude_estimate": rpy,
            "attitude_target": target,
            **wrench_signals(known),
            "force_command": aimed,
            "torque_command": torque,
            "reach_command": arm.reach,
            "shape_angle_command": posture.shape_angle,
        }
        signals_of_laws = of_estimation, of_contact, of_shape, of_translation, of_attitude, of_allocation
        for slot, recorded in zip(SLOTS, signals_of_laws, strict=True):
            monitor.recorded(slot, recorded, signals)
            signals |= recorded if self.tells else without_terms(recorded)
        new = Slots(estimation, contact, shape, translation, attitude, allocation)
        command = from_pairs(self.robot, given.command)
        if self.corrections is not None:
            command = for_rotors(self.corrections, command)
        return new, command, signals

    def gains(self) -> LiveGains:
        """The preset's gains as arrays: every number that may change without a new trace."""
        return self._gains

    @cached_property
    def _gains(self) -> LiveGains:
        gains = LiveGains(*numeric(Slots(*(slot.gains for slot in self.preset.slots))), {})
        return settled(self.preset, self.robot.pairs, gains)

    @property
    def in_python(self) -> dict[str, str]:
        """Laws of its users' that fly in Python, each with the reason why it cannot be compiled."""
        return self.preset.in_python

    def opened(self) -> tuple[Cascade, list[Asked]]:
        """The cascade to be traced, and a list that then gets what the trace asks of Python."""
        asked: list[Asked] = []
        preset = self.preset
        for name, slot in zip(SLOTS, preset.slots, strict=True):
            if slot.python:
                preset = preset.with_slot(name, replace(slot, law=OpenLaw(slot, self.robot.pairs, asked)))
        return replace(self, preset=preset), asked

    def initial_state(self) -> Slots:
        """The state before the first tick, hovering in the nominal posture."""
        return self._initial_state

    @cached_property
    def _initial_state(self) -> Slots:
        theta = self.family.theta_nominal
        robot = self.robot.pairs
        hover = robot.at(self.family.joint_angles(theta), self.vectoring.angles(theta)).hover_thrusts
        start = Start(robot, self.family.reach_nominal, hover)
        return numeric(Slots(*(slot.law.initial_state(slot.gains, start) for slot in self.preset.slots)))

    @property
    def name(self) -> str:
        """The preset's name."""
        return self.preset.name

    @property
    def needs(self) -> Needs:
        """What its laws need of the loop, together."""
        return self.preset.needs

    @property
    def signals(self) -> dict[str, Signal]:
        """Unit, frame and meaning of the signals that laws in a user's file declare."""
        return self.preset.signals

    def require(self, dt: float) -> None:
        """Raise a `ConfigError` where a law cannot work at a control period of `dt` s."""
        for slot in self.preset.slots:
            slot.require(dt)

    def with_gains(self, changes: Mapping[str, Any]) -> Cascade:
        """The same with other values of some gains, by dotted key; the laws stay.

        Raises:
            ConfigError: naming the gain that is unknown or cannot have its value, or the field that it needs.
        """
        return tried(replace(self, preset=with_gains(self.preset, changes, f"controller {self.name}")))

    def check_gain(self, key: str, value: Any, where: str, dt: float) -> None:
        """Raise a `ConfigError` that begins with `where` unless the gain of this key may have this value.

        Args:
            key: of the gain.
            value: that it is to get.
            where: who asks.
            dt: control period at which its law has to work with it, s.
        """
        slots = self.preset.with_gain(key, value, where).slots
        require_fit(slots, where)
        try:
            getattr(slots, key.partition(".")[0]).require(dt)
        except ConfigError as error:
            raise ConfigError(f"{where}: {error}") from None

    def force_with(self, key: str, value: Any) -> float:
        """The normal force that the law of a gain commands once the gain of this key has this value, N."""
        # A live flight asks for all its changes at each of them.
        at = key, repr(value)
        if at not in self._forces:
            changed = self.preset.with_gain(key, value, f"controller {self.name}")
            self._forces[at] = getattr(changed.slots, key.partition(".")[0]).needs.force
        return self._forces[at]

    @cached_property
    def _forces(self) -> dict[tuple[str, str], float]:
        return {}

    def key_tables(self) -> Iterator[Table]:
        """Every key that it was made from, with value, unit, range and meaning."""
        return preset_tables(self.preset)

    def tables(self) -> dict[str, Any]:
        """The preset as plain tables, and the calibration where there is one."""
        calibration = {} if self.corrections is None else {CALIBRATION: correction_table(self.corrections)}
        return {**self.preset.tables(), **calibration}

    def structure(self) -> Hashable:
        """Everything that ends up in the traced function rather than in its arguments."""
        return self._structure

    @cached_property
    def _structure(self) -> Hashable:
        # Functions are compared by identity, so that a law that was loaded anew is traced anew.
        functions = tuple(
            getattr(slot.law, function)
            for name, slot in zip(SLOTS, self.preset.slots, strict=True)
            for function in traced_functions(name)
        )
        family, table = self.family, self.vectoring
        return (
            type(self),
            self.tells,
            self.robot,
            self.corrections and (self.corrections.attitude_misalignment, self.corrections.rotor_scale),
            functions,
            structure(self.gains()),
            structure(self.initial_state()),
            (family.theta_min, family.theta_max, family.theta_nominal, family.described, family.coefficients),
            (table.theta_min, table.theta_max, table.digest, table.coefficients.tobytes()),
        )


def build_cascade(robot: Robot, preset: Preset) -> Cascade:
    """A cascade with the robot's posture family and vectoring table.

    Laws of the user's own are tried, which shows what they read and give.

    Raises:
        ConfigError: naming the laws that do not fit, and the field.
    """
    purpose = preset.needs.vectoring
    family = posture_family(standing(robot.pairs, purpose))
    return tried(Cascade(robot, preset, family, vectoring_table(robot.pairs, purpose)))
