"""The motion that is there to be measured."""

import numpy as np
import pytest

from skylimb.control.missions.excitation import FADE, ExcitationConfig, excitation
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.plan import mission_of
from skylimb.robots.loader import load_robot

SINES = ExcitationConfig(
    x=((0.05, 0.3, 0.2),), y=((0.02, 0.5, 0.0), (0.01, 1.1, 1.0)), z=(), heading=((0.5, 0.1, 0.0),)
)
LENGTH = 20.0


def test_rates_are_derivatives() -> None:
    t, step = np.linspace(-1.0, LENGTH + 1.0, 4001), 1e-5
    here, before, after = (excitation(SINES, t + shift, LENGTH) for shift in (0.0, -step, step))
    assert np.allclose(here.velocity, (after.position - before.position) / (2.0 * step), atol=1e-7)
    assert np.allclose(here.acceleration, (after.velocity - before.velocity) / (2.0 * step), atol=1e-5)


def test_it_is_the_sines_in_the_middle_and_nothing_outside() -> None:
    t = np.array([-0.5, 0.0, 0.5 * FADE, 7.0, LENGTH, LENGTH + 0.5])
    found = excitation(SINES, t, LENGTH)
    assert found.position[3, 0] == pytest.approx(0.05 * np.sin(2 * np.pi * 0.3 * 7.0 + 0.2))
    assert found.position[2, 0] == pytest.approx(0.5 * 0.05 * np.sin(2 * np.pi * 0.3 * 0.5 * FADE + 0.2))
    for part in found:
        assert not part[[0, 1, 4, 5]].any()
    assert not found.position[:, 2].any()


def test_a_mission_sends_it_with_its_acceleration() -> None:
    changes = {"excitation.x": [[0.05, 0.3, 0.0]], "excitation.heading": [[0.2, 0.2, 0.0]]}
    robot = load_robot("hydrus_xi_quad")
    plain, moved = (
        mission_of(load_experiment("calibration", {"posture.waypoints": [], **others}), robot)
        for others in (
            {"excitation.x": [], "excitation.y": [], "excitation.z": [], "excitation.heading": []},
            {"excitation.y": [], "excitation.z": [], **changes},
        )
    )
    extra = moved.reference.position - plain.reference.position
    assert np.abs(extra[:, 0]).max() == pytest.approx(0.05, rel=0.02)
    assert not extra[:, 1:].any()
    assert np.allclose(extra, moved.reference.tip_position - plain.reference.tip_position, atol=1e-12)
    rates = np.gradient(moved.reference.velocity[:, 0], moved.times)
    assert np.allclose(rates[2:-2], moved.reference.acceleration[2:-2, 0], atol=2e-3)
    turned = moved.reference.heading - plain.reference.heading
    assert np.abs(turned).max() == pytest.approx(0.2, rel=0.02)
    assert not moved.in_phase("slide")[np.abs(extra[:, 0]) == 0.0].all()
