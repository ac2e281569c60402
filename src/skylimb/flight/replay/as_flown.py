"""A controller whose estimator works with the thrusts that were flown, not with those that it commands."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from skylimb.base.split_function import Asked
from skylimb.control.allocation.rotor_lag import Rotors, lagging_thrusts, made_wrench, time_constants
from skylimb.control.cascade import Cascade
from skylimb.control.controller import TraceableController
from skylimb.control.corrections import Corrections, for_rotors
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.estimation.records import Measurement, Signals, Wrench
from skylimb.control.laws.slots import Slot
from skylimb.control.missions.reference import Reference
from skylimb.control.records import Allocated, Demand, LawInput
from skylimb.control.thrust_and_angle import as_pairs, from_pairs
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, where


class AllocationAsFlown:
    """An allocation law on a robot that got other thrusts than the law commands.

    The law commands as ever. The wrench that it reports, and the thrusts that it remembers, are those of the
    thrusts that were flown; where these are its own, nothing changes to the bit.

    Args:
        law: of the allocation slot.
        robot: the controller's model, as it is described.
        flown: thrusts that were commanded in flight, N, (n,), NaN where they are not known.
        corrections: of a calibrated controller, which commands other thrusts than its law wants.
    """

    def __init__(self, law: Any, robot: Robot, flown: Array, corrections: Corrections | None = None) -> None:
        self._law, self._robot, self._flown, self._corrections = law, robot, flown, corrections

    def __getattr__(self, name: str) -> Any:
        """What else the law has: `aim`, what it declares."""
        return getattr(self._law, name)

    def step(
        self, gains: Any, state: Any, inputs: LawInput, demand: Demand
    ) -> tuple[Any, Allocated, Signals]:
        """The law's own step, then the thrusts that were flown in the place of its own."""
        new, given, signals = self._law.step(gains, state, inputs, demand)
        flown, own = self._flown, from_pairs(self._robot, given.command)
        command = own.thrusts
        if self._corrections is not None:
            # What the rotors are believed to have made of the flown command.
            command = for_rotors(self._corrections, own).thrusts
            flown = flown * np.asarray(self._corrections.rotor_scale or (1.0,) * self._robot.n_rotors)
        flown = as_pairs(self._robot, own._replace(thrusts=flown)).thrusts
        lag, known = getattr(gains, "rotor_lag", None), hasattr(new, "rotors")
        end, others = flown, rotor_wrench(inputs.estimate.body, flown)
        if lag is not None and known:
            lags = time_constants(inputs.robot, lag.time_constant)
            led = lagging_thrusts(lag, state.rotors.thrusts, flown, lags, inputs.dt)
            end, others = led.end, made_wrench(lag, state.rotors, led, inputs)
        # Also false for thrusts that are no numbers.
        differ = [abs(self._flown[i] - command[i]) > 0.0 for i in range(self._robot.n_rotors)]
        other: Any = sum(differ, 0.0) > 0.0
        wrench = Wrench(
            where(other, others.force, given.wrench.force), where(other, others.torque, given.wrench.torque)
        )
        if known:
            rotors = Rotors(where(other, end, new.rotors.thrusts), where(other, flown, new.rotors.command))
            new = new._replace(rotors=rotors)
        return new, given._replace(wrench=wrench), signals


class WithFlownThrusts:
    """A controller whose estimator works with the thrusts that were flown, which stand behind its gains.

    Args:
        controller: a cascade; one without slots works with its own thrusts as ever.
    """

    def __init__(self, controller: TraceableController) -> None:
        self._controller = controller
        self.name, self.robot, self.needs = controller.name, controller.robot, controller.needs
        self.require, self.initial_state = controller.require, controller.initial_state

    def gains(self) -> Any:
        """The controller's gains, and the thrusts that were flown."""
        return self._controller.gains(), np.zeros(self.robot.n_rotors)

    def opened(self) -> tuple[WithFlownThrusts, list[Asked]]:
        """The same to be traced; see `Cascade.opened`."""
        controller, asked = self._controller.opened()
        return WithFlownThrusts(controller), asked

    def step(self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float) -> Any:
        """One tick of the controller, which remembers and reports what was flown."""
        own, flown = gains
        controller = self._controller
        if isinstance(controller, Cascade):
            slot = controller.preset.slots.allocation
            law = AllocationAsFlown(slot.law, controller.robot, flown, controller.corrections)
            preset = controller.preset.with_slot("allocation", Slot(slot.name, law, slot.gains))
            controller = dataclasses.replace(controller, preset=preset)
        return controller.step(own, state, measurement, reference, dt)
