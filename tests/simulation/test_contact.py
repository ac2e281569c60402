"""The contact recipe: what it writes, and that its force is the true one."""

import math

import casadi as ca
import mujoco
import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.simulation.contact import (
    ContactReading,
    add_contact_pair,
    add_contact_sensor,
    effective_mass,
    set_contact_options,
    tune_contact_pair,
)
from skylimb.simulation.contact_keys import ContactParameters

SUBSTEPS = 5
RADIUS = 0.01


def sliding_tip(parameters, timestep=1e-3, samples=SUBSTEPS, mass=2.0):
    """A 2 kg ball with an arm of its own inertia that is pushed along and into a floor."""
    spec = mujoco.MjSpec()
    set_contact_options(spec, timestep)
    spec.option.gravity = (0, 0, 0)
    spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=0, conaffinity=0
    )
    body = spec.worldbody.add_body(name="tip", pos=[0, 0, RADIUS])
    body.add_freejoint()
    body.add_geom(
        name="ball",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[RADIUS, 0, 0],
        mass=mass,
        contype=0,
        conaffinity=0,
    )
    add_contact_pair(spec, "ball", "floor", parameters)
    add_contact_sensor(spec, "ball", "floor", samples)
    model = spec.compile()
    tune_contact_pair(model, parameters)
    return model, mujoco.MjData(model)


def summed_contact_force(model, data, tip):
    total = np.zeros(3)
    for i in range(data.ncon):
        contact = data.contact[i]
        if contact.efc_address < 0:
            continue
        wrench = np.zeros(6)
        mujoco.mj_contactForce(model, data, i, wrench)
        sign = 1.0 if contact.geom[1] == tip else -1.0
        total += sign * contact.frame.reshape(3, 3).T @ wrench[:3]
    return total


def test_tick_average_equals_summed_contact_forces():
    model, data = sliding_tip(ContactParameters(friction=0.5))
    twin = mujoco.MjData(model)
    reading = ContactReading.of(model)
    tip = model.geom("ball").id
    push = np.array([0.6, 0.3, -1.5])
    seen = dict.fromkeys(("loaded in part", "an overlap without force", "unequal forces"), 0)
    for tick in range(60):
        # Press, let go, press again, so that ticks with partial touch occur.
        push[2] = -1.5 if tick % 16 < 12 else 1.5
        for each in (data, twin):
            each.xfrc_applied[1, :3] = push
        mujoco.mj_step(model, data, nstep=SUBSTEPS)
        forces, touching, points = [], [], []
        for _ in range(SUBSTEPS):
            mujoco.mj_step(model, twin)
            forces.append(summed_contact_force(model, twin, tip))
            touching.append(twin.ncon > 0)
            points.append(twin.contact[0].pos.copy() if twin.ncon else np.full(3, np.nan))
        weights = np.linalg.norm(forces, axis=1)
        average = reading.average(data.history)
        np.testing.assert_allclose(average.force, np.mean(forces, axis=0), atol=1e-12)
        np.testing.assert_allclose(data.history[reading.force], forces, atol=1e-12)
        assert average.duty == pytest.approx(np.mean(touching), rel=1e-15)
        acting = weights > 0.0
        if not np.any(acting):
            assert np.all(np.isnan(average.position))
            continue
        centre = np.average(np.array(points)[acting], axis=0, weights=weights[acting])
        np.testing.assert_allclose(average.position, centre, atol=1e-12)
        seen["loaded in part"] += int(not np.all(acting))
        seen["an overlap without force"] += int(np.any(np.array(touching) & ~acting))
        seen["unequal forces"] += int(np.ptp(weights[acting]) > 0.1 * np.max(weights))
    assert min(seen.values()) > 0, f"not every kind of tick was tried: {seen}"


def test_the_mean_force_at_the_mean_point_has_the_mean_torque():
    model, data = sliding_tip(ContactParameters(friction=0.0))
    reading = ContactReading.of(model)
    data.qvel[:3] = (0.4, -0.2, -0.1)
    turned = 0.0
    for tick in range(20):
        data.xfrc_applied[1, 2] = -1.5 if tick % 8 < 4 else 1.5
        mujoco.mj_step(model, data, nstep=SUBSTEPS)
        torques = np.cross(data.history[reading.position], data.history[reading.force])
        average = reading.average(data.history)
        if np.any(average.force):
            mean = np.cross(average.position, average.force)
            np.testing.assert_allclose(mean, np.mean(torques, axis=0), rtol=0, atol=1e-12)
            turned = max(turned, float(np.linalg.norm(mean)))
    assert turned > 0.01


def test_average_is_the_same_in_casadi():
    model, data = sliding_tip(ContactParameters(friction=0.5))
    reading = ContactReading.of(model)
    history = ca.SX.sym("history", len(data.history))
    symbolic = reading.average(history)
    function = ca.Function("average", [history], [symbolic.force, symbolic.duty, symbolic.position])
    data.qvel[2], data.xfrc_applied[1, 0] = -0.1, 0.5
    for _ in range(12):
        mujoco.mj_step(model, data, nstep=SUBSTEPS)
        plain = reading.average(data.history)
        force, duty, position = function(data.history)
        np.testing.assert_allclose(force.full().ravel(), plain.force, rtol=0, atol=1e-15)
        np.testing.assert_allclose(position.full().ravel(), plain.position, rtol=0, atol=1e-15)
        assert float(duty) == plain.duty


def test_impulse_balances_momentum():
    model, data = sliding_tip(ContactParameters(friction=0.5))
    reading = ContactReading.of(model)
    mass, tick = 2.0, SUBSTEPS * model.opt.timestep
    push = np.array([0.9, -0.2, -1.5])
    data.xfrc_applied[1, :3] = push
    data.qvel[:3] = (0.1, 0.05, -0.05)
    force = np.zeros(3)
    for _ in range(80):
        before = data.qvel[:3].copy()
        mujoco.mj_step(model, data, nstep=SUBSTEPS)
        force = reading.average(data.history).force
        np.testing.assert_allclose(mass * (data.qvel[:3] - before), (force + push) * tick, rtol=0, atol=1e-12)
    assert force[2] > 1.0


def test_the_force_is_the_one_on_the_robot():
    model, data = sliding_tip(ContactParameters(friction=0.5))
    data.xfrc_applied[1, :3] = (2.0, 0.0, -1.0)
    mujoco.mj_step(model, data, nstep=500)
    force = ContactReading.of(model).average(data.history).force
    assert force[2] == pytest.approx(1.0, rel=5e-3)  # pushes the ball up, off the floor
    assert force[0] < 0  # and drags against its motion


@pytest.mark.parametrize("stiffness", [200.0, 5000.0, 50000.0])
def test_indentation_under_load_is_force_over_stiffness(stiffness):
    model, data = sliding_tip(ContactParameters(stiffness=stiffness, damping_ratio=1.0))
    data.xfrc_applied[1, 2] = -3.0
    mujoco.mj_step(model, data, nstep=3000)
    assert -data.contact[0].dist * stiffness == pytest.approx(3.0, rel=1e-3)


def test_damping_ratio_and_damping_are_the_same_damper():
    ratio, direct = (
        ContactParameters(damping_ratio=0.3),
        ContactParameters(damping=2 * 0.3 * math.sqrt(5000 * 2.0)),
    )
    first, _ = sliding_tip(ratio)
    second, _ = sliding_tip(direct)
    assert effective_mass(first) == pytest.approx(2.0)
    np.testing.assert_allclose(first.pair_solref, second.pair_solref, rtol=1e-12)


def test_a_tip_that_sticks_creeps_at_force_over_stick_damping():
    parameters = ContactParameters(friction=0.5, stick_damping=2e4)
    model, data = sliding_tip(parameters)
    # Through its centre a ball that touches from the side is not turned.
    model.body_inertia[1] = 1e3
    mujoco.mj_setConst(model, data)
    tune_contact_pair(model, parameters)
    data.xfrc_applied[1, :3] = (0.3, 0.0, -1.5)
    mujoco.mj_step(model, data, nstep=3000)
    assert data.qvel[0] == pytest.approx(0.3 / 2e4, rel=1e-2)


def test_slip_reaches_the_cone_at_the_friction_rate():
    parameters = ContactParameters(friction=0.5, friction_rate=500.0)
    model, _ = sliding_tip(parameters)
    [impedance], [rate] = set(model.pair_solimp[0, :2]), [-model.pair_solreffriction[0, 1]]
    assert model.pair_solreffriction[0, 0] < 0.0
    assert rate / impedance == pytest.approx(500.0)
    # The damper in stick is the impedance's, less what the engine divides by.
    scale = (1.0 - impedance) / effective_mass(model)
    assert rate * model.opt.impratio / scale == pytest.approx(parameters.stick_damping)


def test_a_pull_reaches_as_far_as_the_spring_stretches_under_it():
    parameters = ContactParameters(friction=0.0, adhesion=2.0, stiffness=1000.0, damping_ratio=1.0)
    model, data = sliding_tip(parameters)
    assert model.pair_gap[0] == pytest.approx(2.0 / 1000.0)
    data.xfrc_applied[1, 2] = 0.9
    mujoco.mj_step(model, data, nstep=2000)
    assert data.qpos[2] - RADIUS == pytest.approx(0.9 / 1000.0, rel=1e-2)
    data.xfrc_applied[1, 2] = 2.1
    mujoco.mj_step(model, data, nstep=2000)
    assert data.qpos[2] - RADIUS > 0.05


def test_effective_mass_counts_a_surface_that_can_move():
    spec = mujoco.MjSpec()
    for name, mass in (("wall", 3.0), ("tip", 6.0)):
        body = spec.worldbody.add_body(name=name)
        body.add_freejoint()
        body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0], mass=mass)
    add_contact_pair(spec, "tip", "wall", ContactParameters())
    assert effective_mass(spec.compile()) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"friction": -0.1}, ["friction = -0.1 is outside of 0 .. 10"]),
        ({"friction": math.nan}, ["friction", "nan"]),
        ({"stiffness": 10.0}, ["stiffness", "10 N/m", "50"]),
        ({"stiffness": 1e7}, ["stiffness", "50 .. 1e+06 N/m"]),
        ({"damping": -1.0}, ["damping", "-1"]),
        ({"damping_ratio": -1.0}, ["damping_ratio", "-1"]),
    ],
)
def test_bad_parameters_are_named(keys, words):
    with pytest.raises(ConfigError) as caught:
        ContactParameters(**keys)
    for word in words:
        assert word in str(caught.value)


def test_a_stiffness_the_time_step_cannot_carry_is_refused():
    with pytest.raises(ConfigError, match=r"too stiff for a time step of 0\.005 s"):
        sliding_tip(ContactParameters(stiffness=5e4), timestep=5e-3)


def test_a_damping_the_time_step_cannot_carry_is_refused():
    sliding_tip(ContactParameters(damping=2.0 / 1e-3))
    with pytest.raises(ConfigError, match=r"damping = 2001 N s/m is too much .* at most 2000 N s/m"):
        sliding_tip(ContactParameters(damping=2001.0))


def test_a_reading_may_have_one_sample():
    model, _ = sliding_tip(ContactParameters(), samples=1)
    assert ContactReading.of(model).samples == 1
