"""What the paper's equations do as they are printed; the corrected forms are what everything else tests.

See docs/errata.md. The printed forms themselves are in `skylimb.studies.reproduction.printed_forms` alone.
"""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

import skylimb
from skylimb.control.allocation.thrusts import allocate
from skylimb.control.controller import cascade_from_tables, load_controller
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.estimation.records import BodyState
from skylimb.control.laws.preset import preset_mapping
from skylimb.control.laws.slots import Slot
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.records import Allocated, Command, Demand, LawInput
from skylimb.studies.reproduction.printed_forms import (
    admittance_as_printed,
    difference_as_printed,
    hybrid_with,
    impedance_with_mass_times_force,
    leak_matrix,
)

HOVER_ONLY = {"phases.hover": 2.0, "phases.tare": 0.5, "phases.settle": 0.0, "phases.hover_end": 0.0,
              "approach.contact": False, "trajectory.shape": "hold", "trajectory.duration": 1.0,
              "events": []}  # fmt: skip


def robot() -> skylimb.Robot:
    return skylimb.load_robot("hydrus_xi_quad")


def test_mass_times_the_force_diverges_within_a_second() -> None:
    """eq:thrust translation 2 with m f_cmd: the lift is four times the weight."""

    run = skylimb.run("push", controller=impedance_with_mass_times_force(robot()), set=HOVER_ONLY)
    log = run.log
    away = np.linalg.norm((log["cog_position"] - log["cog_position_reference"]).values, axis=1)
    assert away[log["time"].values <= 0.6].max() > 0.25
    assert run.status == "FAILED"
    assert run.metrics["error_v_median"] is None


def test_the_printed_admittance_reaches_into_the_board() -> None:
    """eq:admittance control with e = r_ref - r on the left: a push (f < 0) makes the arm longer."""

    right = skylimb.run("paper", controller="hybrid")
    wrong = skylimb.run("paper", controller=hybrid_with(admittance_as_printed, robot()))
    in_contact = {
        name: run.log.where(run.log["phase"] == 3, drop=True) for name, run in (("r", right), ("w", wrong))
    }
    nominal = float(right.log["reach_reference"][0])
    assert float(in_contact["r"]["reach_command"].mean()) < nominal - 0.02
    assert float(in_contact["w"]["reach_command"].mean()) > nominal + 0.02
    assert float(in_contact["w"]["contact_force_normal"].mean()) > 1.3 * float(
        in_contact["r"]["contact_force_normal"].mean()
    )


def test_the_printed_difference_equation_has_an_unstable_pole() -> None:
    """eq:difference method1: r'' = (f - k_a (r_ref - r) + c_a r') / m_a: spring and damper drive."""
    gains = load_controller("hybrid", robot()).gains().shape
    poles = np.roots([gains.mass, -gains.damping, -gains.stiffness])
    np.testing.assert_allclose(sorted(poles), [-0.25, 1.62], atol=0.01)

    printed = hybrid_with(difference_as_printed, robot())
    run = skylimb.run("paper", controller=printed)
    family = printed.family
    reach = run.log["reach_command"].values
    at_the_stop = (np.abs(reach - family.reach_min) < 1e-9) | (np.abs(reach - family.reach_max) < 1e-9)
    # Only the arm's own limits hold it: it runs to a stop and stays there.
    assert run.status == "FAILED" or at_the_stop[-400:].all()


def test_rotational_thrusts_do_push_sideways() -> None:
    """The sentence before eq:thrust rotation 1 takes Q_t pinv(Q_r) to be zero."""
    theta = np.pi / 6
    leak = leak_matrix(robot(), theta)
    assert np.abs(leak[:2]).max() > 0.5
    assert np.linalg.norm(leak[:, 2]) > 0.5
    state = robot().at([np.pi / 2 - theta, 2 * theta, -theta], vectoring_table(robot()).angles(theta))
    Q = state.allocation_C
    body = BodyState(np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3), state)
    pushed = rotor_wrench(body, np.linalg.pinv(Q[3:]) @ np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(pushed.torque, [0.0, 0.0, 1.0], atol=1e-9)
    assert np.linalg.norm(pushed.force) > 0.5


def test_an_observer_fed_with_thrusts_before_saturation_is_biased() -> None:
    """f_cmd of eq:external wrench estimation is what the rotors really get, after saturation."""
    weak = {**HOVER_ONLY, "phases.hover": 4.0}
    cascade = cascade_from_tables(*preset_mapping("impedance"), robot())
    hover = robot().at([np.pi / 3, np.pi / 3, -np.pi / 6], cascade.vectoring.angles(np.pi / 6)).hover_thrusts
    limits = np.zeros(4), np.full(4, float(hover.max()) - 0.3)
    none = -1e3 * np.ones(4), 1e3 * np.ones(4)

    def flown(known: tuple[np.ndarray, np.ndarray]) -> skylimb.Run:
        """Rotors that saturate, and an estimation that knows the thrusts within the limits `known`."""

        def step(gains: Any, state: Any, inputs: LawInput, demand: Demand) -> Any:
            body = inputs.estimate.body
            real, believed = (allocate(body, demand.force, demand.torque, at).total for at in (limits, known))
            command = Command(real, demand.joint_angles, demand.vectoring_angles)
            return state, Allocated(command, rotor_wrench(body, believed)), {}

        slot = cascade.preset.slots.allocation
        law = SimpleNamespace(aim=slot.law.aim, initial_state=slot.law.initial_state, step=step)
        preset = cascade.preset.with_slot("allocation", Slot("weak", law, slot.gains))
        return skylimb.run("push", controller=replace(cascade, preset=preset), set=weak)

    def bias(run: skylimb.Run) -> float:
        log = run.log
        raw = log["external_force_estimate"] + log["external_force_bias"]
        seen = raw.where((log["time"] > 1.0) & (log["time"] < 2.0), drop=True).mean("time")
        return float(np.linalg.norm(seen.values))

    fair, biased = bias(flown(limits)), bias(flown(none))
    assert biased > 3.0 * fair
    assert biased > 0.15
