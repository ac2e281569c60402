"""Is the attitude's loop slow enough for rotors that work against their own change of speed?

Where it is not, lift and torque have a zero in the right half plane that the loop is too near to
(`skylimb.robots.reaction` computes it, docs/rotors.md says what it does).
"""

from __future__ import annotations

import warnings

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout
from skylimb.control.cascade import Cascade
from skylimb.control.controller import Controller
from skylimb.control.needs import needs_of
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.flight.experiments.experiment import Experiment
from skylimb.robots.model import Robot
from skylimb.robots.reaction import DOUBTFUL_ZERO, reaction_zeros, slowest_unstable_zero
from skylimb.simulation.plant_config import turning

REFUSED_ZERO = 1.5
"""Times the attitude's bandwidth: with a slower zero flights lose attitude, or contact again and again."""


def require_slow_enough(experiment: Experiment, robot: Robot, controller: Controller) -> None:
    """Hold the attitude's bandwidth against the zero of the rotors' reaction, where the rotors have a speed.

    Raises:
        ConfigError: where the zero is so slow that flights are lost, unless `approach.doubtful` is "fly".
    """
    stiffness = attitude_stiffness(controller)
    if not turning(robot.description, experiment.plant) or stiffness <= 0.0:
        return
    inertia = experiment.plant.rotor_inertia
    zeros = reaction_zeros(
        robot, *nominal_posture(robot, needs_of(controller).vectoring), None if inertia < 0.0 else inertia
    )
    zero, bandwidth = slowest_unstable_zero(zeros), float(np.sqrt(stiffness))
    if zero > DOUBTFUL_ZERO * bandwidth:
        return
    refused = zero < REFUSED_ZERO * bandwidth
    words = (
        f"{robot.name}'s rotors work against their own change of speed: lift and torque have a zero at "
        f"+{zero:.3g} rad/s, for which {controller.name}'s attitude, {bandwidth:.3g} rad/s fast, is "
        f"{'too fast' if refused else 'doubtful'}; {zero / DOUBTFUL_ZERO:.2g} rad/s would be safe "
        f"(attitude.normalized_stiffness of at most {(zero / DOUBTFUL_ZERO) ** 2:.0f})"
    )
    if not refused or experiment.approach.doubtful == "fly":
        warnings.warn(words, UserWarning, stacklevel=2)
        return
    raise ConfigError(f'{words}. approach.doubtful = "fly" flies it all the same')


def attitude_stiffness(controller: Controller) -> float:
    """The greatest stiffness of the attitude's loop, 1/s^2; 0 of a controller that does not say it."""
    if not isinstance(controller, Cascade):
        return 0.0
    layout = Layout(controller.gains())
    found = layout.pack(controller.gains())[layout.slices.get("attitude.normalized_stiffness", slice(0))]
    return float(found.max(initial=0.0))
