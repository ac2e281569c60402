"""What the paper's equations do as they are printed; the corrected forms are what everything else tests.

See docs/errata.md. The printed forms themselves are in `skylimb.reproduction.printed_forms` and nowhere else.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.control import cascade as cascade_module
from skylimb.control.allocation import Thrusts, allocate, rotor_wrench
from skylimb.control.cascade import Cascade
from skylimb.control.controller import load_controller
from skylimb.planning.vectoring import vectoring_table
from skylimb.reproduction.printed_forms import (
    admittance_as_printed,
    difference_as_printed,
    hybrid_with,
    impedance_with_mass_times_force,
    leak_matrix,
)
from skylimb.simulation.tick import forget_ticks

HOVER_ONLY = {"phases.hover": 2.0, "phases.tare": 0.5, "phases.settle": 0.0, "phases.hover_end": 0.0,
              "approach.contact": False, "trajectory.shape": "hold", "trajectory.duration": 1.0}  # fmt: skip


@pytest.fixture(autouse=True)
def _trace_anew() -> Iterator[None]:
    """Code is exchanged under the tick here, so no tick that was traced before or after may be used."""
    forget_ticks()
    yield
    forget_ticks()


def robot() -> skylimb.Robot:
    return skylimb.load_robot("hydrus_xi_quad")


def test_mass_times_the_force_diverges_within_a_second() -> None:
    """eq:thrust translation 2 with m f_cmd: the lift is four times the weight."""

    run = skylimb.run("push", controller=impedance_with_mass_times_force(robot()), set=HOVER_ONLY)
    log = run.log
    away = np.linalg.norm((log["cog_position"] - log["cog_position_reference"]).values, axis=1)
    assert away[log["time"].values <= 0.6].max() > 0.25
    assert run.status == "FAILED"
    assert run.metrics["error_z_median"] is None


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
    force, torque = rotor_wrench(state, np.eye(3), np.linalg.pinv(Q[3:]) @ np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(torque, [0.0, 0.0, 1.0], atol=1e-9)
    assert np.linalg.norm(force) > 0.5


def test_an_observer_fed_with_the_wish_is_biased(monkeypatch: pytest.MonkeyPatch) -> None:
    """f_cmd of eq:external wrench estimation is what the rotors are told, not the wish before saturation."""
    weak = {**HOVER_ONLY, "phases.hover": 4.0}
    honest = load_controller("impedance", robot())
    assert isinstance(honest, Cascade)
    limit = (
        float(
            robot()
            .at([np.pi / 3, np.pi / 3, -np.pi / 6], honest.vectoring.angles(np.pi / 6))
            .hover_thrusts.max()
        )
        - 0.3
    )

    def clipped(model: Any, R_WC: Any, force: Any, torque: Any, low: Any, high: Any, lift: Any) -> Thrusts:
        return allocate(model, R_WC, force, torque, low, np.full(4, limit), lift)

    monkeypatch.setattr(cascade_module, "allocate", clipped)
    fair = skylimb.run("push", controller="impedance", set=weak)

    def wishing(model: Any, R_WC: Any, thrusts: Any) -> Any:
        return rotor_wrench(model, R_WC, thrusts)

    wishes: list[Any] = []

    def remember(model: Any, R_WC: Any, force: Any, torque: Any, low: Any, high: Any, lift: Any) -> Thrusts:
        wishes.append(allocate(model, R_WC, force, torque, -1e3 * np.ones(4), 1e3 * np.ones(4)).total)
        return clipped(model, R_WC, force, torque, low, high, lift)

    def wished_wrench(model: Any, R_WC: Any, thrusts: Any) -> Any:
        return wishing(model, R_WC, wishes[-1])

    monkeypatch.setattr(cascade_module, "allocate", remember)
    monkeypatch.setattr(cascade_module, "rotor_wrench", wished_wrench)
    forget_ticks()
    biased = skylimb.run("push", controller="impedance", set=weak)

    def bias(run: skylimb.Run) -> float:
        log = run.log
        raw = log["external_force_estimate"] + log["external_force_bias"]
        seen = raw.where((log["time"] > 1.0) & (log["time"] < 2.0), drop=True).mean("time")
        return float(np.linalg.norm(seen.values))

    assert bias(biased) > 3.0 * bias(fair)
    assert bias(biased) > 0.15
