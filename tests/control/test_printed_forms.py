"""What the paper's equations do as they are printed; the corrected forms are what everything else tests.

See docs/errata.md. Each printed form lives here and nowhere else.
"""

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.control import cascade as cascade_module
from skylimb.control.allocation import Thrusts, allocate, rotor_wrench
from skylimb.control.cascade import Cascade
from skylimb.control.controller import load_controller
from skylimb.control.preset import Slot
from skylimb.control.shape import admittance
from skylimb.planning.vectoring import vectoring_table
from skylimb.simulation.tick import forget_ticks
from skylimb.symbolic import clip

HOVER_ONLY = {"phases.hover": 2.0, "phases.tare": 0.5, "phases.settle": 0.0, "phases.hover_end": 0.0,
              "approach.contact": False, "trajectory.shape": "hold", "trajectory.duration": 1.0}  # fmt: skip


@pytest.fixture(autouse=True)
def _trace_anew() -> Iterator[None]:
    """Code is exchanged under the tick here, so no tick that was traced before or after may be used."""
    forget_ticks()
    yield
    forget_ticks()


def with_shape_law(law: Any) -> Cascade:
    """The hybrid preset with another shape law."""
    controller = load_controller("hybrid", skylimb.load_robot("hydrus_xi_quad"))
    assert isinstance(controller, Cascade)
    slot = Slot("printed", law, controller.preset.shape.gains)
    return replace(controller, preset=replace(controller.preset, shape=slot))


def shape_law(acceleration: Any) -> Any:
    """The admittance with its acceleration replaced by a printed form of (gains, push, extension, rate)."""

    def step(gains: Any, state: admittance.State, inputs: Any, reach_limits: tuple[float, float]) -> Any:
        push = (inputs.contact_force - gains.force_reference) * inputs.reference.adapt
        rate = (
            state.rate
            + acceleration(gains, push, inputs.reference.reach - state.reach, state.rate) * inputs.dt
        )
        reach = clip(state.reach + rate * inputs.dt, *reach_limits)
        return admittance.State(reach, rate), reach

    return SimpleNamespace(Gains=admittance.Gains, initial_state=admittance.initial_state, step=step)


def test_mass_times_the_force_diverges_within_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    """eq:thrust translation 2 with m f_cmd: the lift is four times the weight."""

    def printed(model: Any, R_WC: Any, force: Any, torque: Any, low: Any, high: Any) -> Thrusts:
        return allocate(model, R_WC, force * model.mass, torque, low, high)

    monkeypatch.setattr(cascade_module, "allocate", printed)
    run = skylimb.run("push", controller="impedance", set=HOVER_ONLY)
    log = run.log
    away = np.linalg.norm((log["cog_position"] - log["cog_position_reference"]).values, axis=1)
    assert away[log["time"].values <= 0.6].max() > 0.25
    assert run.status == "FAILED"
    assert run.metrics["error_z_median"] is None


def test_the_printed_admittance_reaches_into_the_board() -> None:
    """eq:admittance control with e = r_ref - r on the left: a push (f < 0) makes the arm longer."""

    def printed(gains: Any, push: Any, extension: Any, rate: Any) -> Any:
        # m_a (0 - r'') + c_a (0 - r') + k_a (r_ref - r) = f  solved for r''
        return (gains.stiffness * extension - gains.damping * rate - push) / gains.mass

    right = skylimb.run("paper", controller="hybrid")
    wrong = skylimb.run("paper", controller=with_shape_law(shape_law(printed)))
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
    gains = load_controller("hybrid", skylimb.load_robot("hydrus_xi_quad")).gains().shape
    poles = np.roots([gains.mass, -gains.damping, -gains.stiffness])
    np.testing.assert_allclose(sorted(poles), [-0.25, 1.62], atol=0.01)

    def printed(gains: Any, push: Any, extension: Any, rate: Any) -> Any:
        return (push - gains.stiffness * extension + gains.damping * rate) / gains.mass

    run = skylimb.run("paper", controller=with_shape_law(shape_law(printed)))
    family = with_shape_law(shape_law(printed)).family
    reach = run.log["reach_command"].values
    at_the_stop = (np.abs(reach - family.reach_min) < 1e-9) | (np.abs(reach - family.reach_max) < 1e-9)
    # Only the arm's own limits hold it: it runs to a stop and stays there.
    assert run.status == "FAILED" or at_the_stop[-400:].all()


def test_rotational_thrusts_do_push_sideways() -> None:
    """The sentence before eq:thrust rotation 1 takes Q_t pinv(Q_r) to be zero."""
    robot = skylimb.load_robot("hydrus_xi_quad")
    theta = np.pi / 6
    state = robot.at([np.pi / 2 - theta, 2 * theta, -theta], vectoring_table(robot).angles(theta))
    Q = state.allocation_C
    leak = Q[:3] @ np.linalg.pinv(Q[3:])
    assert np.abs(leak[:2]).max() > 0.5
    assert np.linalg.norm(leak[:, 2]) > 0.5
    force, torque = rotor_wrench(state, np.eye(3), np.linalg.pinv(Q[3:]) @ np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(torque, [0.0, 0.0, 1.0], atol=1e-9)
    assert np.linalg.norm(force) > 0.5


def test_an_observer_fed_with_the_wish_is_biased(monkeypatch: pytest.MonkeyPatch) -> None:
    """f_cmd of eq:external wrench estimation is what the rotors are told, not the wish before saturation."""
    weak = {**HOVER_ONLY, "phases.hover": 4.0}
    robot = skylimb.load_robot("hydrus_xi_quad")
    honest = load_controller("impedance", robot)
    assert isinstance(honest, Cascade)
    limit = (
        float(
            robot.at(
                [np.pi / 3, np.pi / 3, -np.pi / 6], honest.vectoring.angles(np.pi / 6)
            ).hover_thrusts.max()
        )
        - 0.3
    )

    def clipped(model: Any, R_WC: Any, force: Any, torque: Any, low: Any, high: Any) -> Thrusts:
        return allocate(model, R_WC, force, torque, low, np.full(4, limit))

    monkeypatch.setattr(cascade_module, "allocate", clipped)
    fair = skylimb.run("push", controller="impedance", set=weak)

    def wishing(model: Any, R_WC: Any, thrusts: Any) -> Any:
        return rotor_wrench(model, R_WC, thrusts)

    wishes: list[Any] = []

    def remember(model: Any, R_WC: Any, force: Any, torque: Any, low: Any, high: Any) -> Thrusts:
        wishes.append(allocate(model, R_WC, force, torque, -1e3 * np.ones(4), 1e3 * np.ones(4)).total)
        return clipped(model, R_WC, force, torque, low, high)

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
