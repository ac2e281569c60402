"""The tip's port: an ideal impedance against theory, a late one, and the tip of a flight."""

import dataclasses
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.linalg import expm

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.studies.verification.stability import (
    OperatingPoint,
    TipPort,
    active_bands,
    operating_point,
    real_part,
    tip_port,
)

T, STEPS = 1e-3, 10
LOW = np.geomspace(0.1, 20.0, 60)
REST = {
    "phases.hover": 1.0,
    "phases.tare": 1.0,
    "surface.slope": 0.0,
    "surface.friction": 0.0,
    "trajectory.shape": "hold",
    "trajectory.duration": 4.0,
}


def port(mass: float, damper: float = 0.0, spring: float = 0.0, fed: float = 0.0, late: int = 0) -> TipPort:
    """A mass on a spring and a damper, and a damper that a controller makes, late by so many ticks."""
    whole = np.zeros((3, 3))
    whole[0, 1], whole[1] = 1.0, [-spring / mass, -damper / mass, 1.0 / mass]
    step = expm(whole * T / STEPS)
    A, B = step[:2, :2], step[:2, 2:]
    # The tick's state: velocities of the last ticks, the newest first.
    S_s = np.eye(max(late, 1), k=-1)
    S_x = np.zeros((max(late, 1), 2))
    S_x[0, 1] = 1.0
    K_s = np.zeros((1, max(late, 1)))
    K_x = np.zeros((1, 2))
    if late:
        K_s[0, -1] = -fed
    else:
        K_x[0, 1] = -fed
    place, speed = np.eye(2)[:, None, :]
    return TipPort(A, B, B, place, speed, (K_x, K_s, S_x, S_s), STEPS, T)


def test_an_ideal_impedance_has_its_own_admittance_and_is_passive() -> None:
    ideal = port(2.0, damper=4.0, spring=20.0)
    s = 2.0j * np.pi * LOW
    np.testing.assert_allclose(
        ideal.admittance(LOW)[:, 0, 0], s / (2.0 * s**2 + 4.0 * s + 20.0), rtol=5e-3, atol=1e-3
    )
    everywhere = np.geomspace(0.1, 499.0, 200)
    assert active_bands(everywhere, ideal.admittance(everywhere)) == []
    assert ideal.unstable_springs(np.geomspace(1.0, 1e3, 15)) is None
    assert ideal.growth(0.0) == pytest.approx(-1.0, rel=1e-3)


def test_a_late_damper_is_active_from_a_quarter_of_a_period_on() -> None:
    # Re Y < 0 where cos(w tau) < 0, tau with half a tick of the hold.
    late = port(2.0, fed=10.0, late=50)
    Y = late.admittance(LOW)
    (first, last), *_ = active_bands(LOW, Y)
    assert first == pytest.approx(1.0 / (4.0 * 0.0505), rel=0.1)
    assert last == pytest.approx(3.0 / (4.0 * 0.0505), rel=0.1)
    assert real_part(Y).min() < 0.0


def test_the_least_spring_is_where_the_late_damper_is_in_step_with_it() -> None:
    # m s^2 + d s exp(-s tau) + k = 0 with s = i w: w = pi / (2 tau), k = m w^2 - d w.
    tau = 0.0505
    w = np.pi / (2.0 * tau)
    found = port(2.0, fed=10.0, late=50).unstable_springs(np.geomspace(100.0, 1e4, 20))
    assert found is not None
    assert found[0] == pytest.approx(2.0 * w**2 - 10.0 * w, rel=0.03)


def test_a_damper_beside_the_spring_has_to_take_what_the_late_one_gives() -> None:
    # At most 10 N s/m: where the spring's mode is half a period late.
    late, springs = port(2.0, fed=10.0, late=50), np.geomspace(100.0, 1e4, 12)
    assert late.calming_damper(springs, np.array([2.0, 5.0, 9.0, 11.0, 20.0])) == 11.0
    assert late.calming_damper(springs[:1], np.array([0.0, 11.0])) == 0.0
    assert late.calming_damper(springs, np.array([2.0, 5.0])) is None
    # A damper is one: alone it takes the mass's speed.
    assert port(2.0).growth(0.0, 4.0) == pytest.approx(-2.0, rel=1e-2)


def test_several_axes_are_judged_together() -> None:
    Y = np.array(
        [[[1.0, 0.0], [0.0, 1.0]], [[1.0, 3.0], [-3.0, 1.0]], [[1.0, 3.0], [3.0, 1.0]]], dtype=complex
    )
    np.testing.assert_allclose(real_part(Y), [1.0, 1.0, -2.0])
    assert active_bands(np.array([1.0, 2.0, 3.0]), Y) == [(3.0, 3.0)]


@pytest.fixture(scope="module")
def point() -> OperatingPoint:
    controller: Any = skylimb.load_controller("task_frame", skylimb.load_robot("hydrus_xi_quad"))
    return operating_point(skylimb.load_experiment("paper", REST), controller)


@pytest.fixture(scope="module")
def tip(point: OperatingPoint) -> TipPort:
    return tip_port(point, np.eye(3))


def test_quickly_pushed_a_tip_is_its_mass(point: OperatingPoint, tip: TipPort) -> None:
    model, data = point.plant.model, point.data()
    J, solved = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, J, None, model.site(TIP_SITE).id)
    mujoco.mj_solveM(model, data, solved, J)
    # Upward no servo gives way; along the level axes their dampers add to the mass within a step.
    step = tip.period / tip.substeps
    mobility = tip.place @ tip.push / step**2
    assert mobility[2, 2] == pytest.approx((J @ solved.T)[2, 2], rel=2e-3)
    np.testing.assert_allclose(mobility, mobility.T, atol=1e-3)
    assert (np.diag(mobility) < 1.001 * np.diag(J @ solved.T)).all()


def test_its_force_is_held_when_the_surface_is_taken_away(point: OperatingPoint, tip: TipPort) -> None:
    assert tip.growth(0.0) < 0.0
    assert tip.over_period()[0].shape[0] == len(point.state) + tip.A.shape[0]
    assert tip.along(np.eye(3)[0]).push.shape == (tip.A.shape[0], 1)


def test_the_flying_tip_is_not_passive_along_the_contact_axis(tip: TipPort) -> None:
    Y = tip.along(np.eye(3)[0]).admittance(np.geomspace(0.5, 3.0, 20))
    bands = active_bands(np.geomspace(0.5, 3.0, 20), Y)
    assert len(bands) == 1
    assert bands[0] == pytest.approx((1.17, 1.41), rel=0.05)
    springs = tip.along(np.eye(3)[0]).unstable_springs(np.geomspace(30.0, 300.0, 5))
    assert springs is not None
    assert springs[0] == pytest.approx(148.9, rel=0.02)


def test_a_small_damper_beside_any_spring_keeps_it_from_growing(tip: TipPort) -> None:
    springs, dampers = np.array([120.0, 300.0, 1e3, 1e4, 1e5]), np.array([0.0, 1.0, 3.0, 7.0])
    damper = [tip.along(axis).calming_damper(springs, dampers) for axis in np.eye(3)]
    assert damper == [1.0, 0.0, 7.0]


def test_in_flight_such_a_spring_swings_the_force_and_a_damper_beside_it_calms() -> None:
    swing = []
    for damper in (0.0, 3.0):
        soft = {"surface.stiffness": 250.0, "surface.damping": damper, "trajectory.duration": 9.0}
        log = skylimb.run("paper", "task_frame", set={**REST, **soft}).log
        end = (log.phase == 4) & (log.time > float(log.time[-1]) - 9.0)
        swing.append(float(log.contact_force_normal.where(end, drop=True).std()))
    assert swing[0] > 2.0 * swing[1]


def test_without_touch_there_is_nothing_to_hold(point: OperatingPoint) -> None:
    away = dataclasses.replace(point, qpos=point.qpos - np.eye(len(point.qpos))[0])
    with pytest.raises(ConfigError, match="does not touch"):
        tip_port(away, np.eye(3))
