"""The native driver flies what the Python driver flies, alone and in company."""

import copy
import ctypes
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from skylimb.simulation.flight import CHECK_INTERVAL, Flight
from skylimb.simulation.native import NativeJob, compile_native, fly_native
from skylimb.simulation.native import fly as fly_module
from skylimb.simulation.native.library import control_callback

MakeJob = Callable[..., NativeJob]
FlySlowly = Callable[[NativeJob], Flight]

SLIPPERY = {
    "surface.friction_map.patches.spot.center": [0.03, 0.0],
    "surface.friction_map.patches.spot.size": [0.04, 0.2],
    "surface.friction_map.patches.spot.friction": 0.1,
    "surface.friction_map.patches.spot.adhesion": 0.3,
    "surface.static_ratio": 1.5,
}
MOVING = {
    "surface.sway_amplitude": 0.02,
    "surface.sway_frequency": 1.0,
    "surface.advance_distance": 0.02,
    "surface.advance_start": 1.0,
}
SHORT = {
    "phases.hover": 0.4,
    "phases.tare": 0.3,
    "phases.settle": 0.3,
    "phases.hover_end": 0.1,
    "approach.speed": 0.2,
    "approach.retreat_speed": 0.3,
    "trajectory.radius": 0.1,
    "trajectory.period": 3.0,
}
PUSHED = {
    "disturbance.force": [0.0, 0.5, -0.3],
    "disturbance.torque": [0.02, 0.0, 0.05],
    "disturbance.start": 1.5,
    "disturbance.duration": 0.7,
}
CHANGED = {
    "gain_changes": [
        {"time": 1.0, "key": "translation.force", "value": 1.6},
        {"time": 1.2, "key": "attitude.damping_ratio", "value": [1.0, 1.0, 1.0], "blend": 0.2},
        {"time": 1.3, "key": "translation.force", "value": 0.8, "blend": 0.0},
    ]
}
LEAVING = {"surface.advance_distance": -0.05, "surface.advance_speed": 0.05, "surface.advance_start": 2.0}
FLIGHTS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "pid": ("paper", "pid", {}),
    "impedance": ("paper", "impedance", {}),
    "admittance": ("paper", "admittance", {}),
    "hybrid": ("paper", "hybrid", {}),
    "free flight": ("free_flight", "hybrid", {"posture.hold": 0.1}),
    "push": ("push", "hybrid", {"disturbance.start": 3.0, "trajectory.duration": 5.0}),
    "moving board": ("paper", "hybrid", MOVING),
    "friction of the place": ("paper", "hybrid", SLIPPERY),
    "all at once": ("paper", "pid", {**MOVING, **SLIPPERY, **PUSHED}),
    "curved surface": ("paper", "hybrid", {"surface.kind": "sine", "surface.slope": 0.0}),
    "one step a tick": ("paper", "hybrid", {**MOVING, **SLIPPERY, "plant.physics_step": 0.005}),
    "another robot than described": (
        "paper",
        "hybrid",
        {
            "plant.mass_scale": 1.03,
            "plant.cog_offset": [0.01, 0.0, 0.0],
            "plant.rotor_scale": [1.0, 0.97, 1.02, 1.0],
            "sensors.attitude_misalignment": [0.01, -0.02, 0.0],
        },
    ),
    "following": ("paper", "following", {}),
    "following on a cylinder": ("cylinder_convex", "following", SHORT),
    "following over patches": ("friction_patches", "following", SHORT),
    "following a board that leaves": ("paper", "following", LEAVING),
    "gains that change": ("paper", "following", CHANGED),
    "no lift": ("paper", "pid", {"plant.thrust_scale": 0.5}),
    "pushed away": ("push", "pid", {"disturbance.force": [0.0, 9.0, 0.0], "disturbance.start": 2.0}),
}
LOST = {"no lift": "hit the floor", "pushed away": "lost position"}


def assert_same(found: Flight, wanted: Flight) -> None:
    assert (found.ticks, found.cause) == (wanted.ticks, wanted.cause)
    np.testing.assert_allclose(
        found.signals[: found.ticks], wanted.signals[: wanted.ticks], rtol=0.0, atol=1e-9
    )


@pytest.mark.parametrize("name", FLIGHTS)
def test_both_drivers_fly_the_same(name: str, make_job: MakeJob, fly_slowly: FlySlowly) -> None:
    job = make_job(*FLIGHTS[name])
    [found] = fly_native([job])
    assert_same(found, fly_slowly(job))
    assert LOST.get(name, "") in found.cause
    assert bool(found.cause) == (name in LOST)
    if FLIGHTS[name][0] not in ("free_flight", "push") and not found.cause:
        assert found.signal("contact_duty").max() > 0.0


@pytest.fixture(scope="module")
def company(make_job: MakeJob) -> list[NativeJob]:
    """Flights of every kind: other scenes, controllers, lengths, some lost, two that share a plant."""
    jobs = [make_job(*flight, seed=seed) for seed, flight in enumerate(FLIGHTS.values())]
    patchy = make_job(*FLIGHTS["friction of the place"], seed=50)
    return [*jobs, patchy, dataclasses.replace(patchy, rows=make_job("paper", "hybrid", SLIPPERY, 51).rows)]


def test_any_number_of_threads_gives_the_same_bits(company: list[NativeJob], fly_slowly: FlySlowly) -> None:
    one, two, eight = (fly_native(company, threads) for threads in (1, 2, 8))
    for job, a, b, c in zip(company, one, two, eight, strict=True):
        assert (a.ticks, a.cause) == (b.ticks, b.cause) == (c.ticks, c.cause)
        assert np.array_equal(a.signals[: a.ticks], b.signals[: b.ticks], equal_nan=True)
        assert np.array_equal(a.signals[: a.ticks], c.signals[: c.ticks], equal_nan=True)
        assert_same(a, fly_slowly(job))


def test_a_flight_leaves_its_job_as_it_was(make_job: MakeJob) -> None:
    job = make_job("paper", "hybrid", {**SLIPPERY, **MOVING})
    state, friction = job.data.qpos.copy(), job.plant.model.pair_friction.copy()
    first, second = fly_native([job])[0], fly_native([job])[0]
    assert np.array_equal(job.data.qpos, state)
    assert np.array_equal(job.plant.model.pair_friction, friction)
    assert np.array_equal(first.signals, second.signals, equal_nan=True)


@pytest.mark.parametrize("ticks", [50, 100, 250])
def test_the_engines_warnings_end_a_flight(
    ticks: int, make_job: MakeJob, fly_slowly: FlySlowly, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # where the engine leaves its log
    job = make_job("paper", "hybrid", MOVING)
    model = copy.copy(job.plant.model)
    wall = model.body("surface").id
    # The engine warns of the board's inertia; as its place is written at every tick, nothing else is amiss.
    model.body_mass[wall], model.body_inertia[wall] = 1e-17, 1e-17
    ghost = dataclasses.replace(
        job, plant=dataclasses.replace(job.plant, model=model), rows=job.rows.until(ticks)
    )
    wanted = fly_slowly(ghost)
    assert "the physics engine warned (mjWARN_INERTIA)" in wanted.cause
    assert wanted.ticks == min(ticks, CHECK_INTERVAL)
    first, healthy, last = fly_native([ghost, job, ghost], 1)
    assert_same(first, wanted)
    assert_same(last, wanted)
    assert healthy.cause == ""


def test_gains_seeds_and_the_plants_numbers_share_one_build(make_job: MakeJob) -> None:
    job = make_job("paper", "hybrid")
    other = make_job(
        "paper",
        "hybrid",
        {
            "surface.slope": -0.1,
            "plant.mass_scale": 1.05,
            "sensors.attitude_misalignment": [0.01, 0.0, 0.0],
            "sensors.position_noise": 0.002,
        },
        seed=9,
    )
    assert other.compiled.function is job.compiled.function
    address = compile_native(job.compiled, job.plant).address
    assert compile_native(other.compiled, other.plant).address == address
    assert compile_native(make_job("paper", "pid").compiled, job.plant).address != address


def test_gains_are_data(make_job: MakeJob, fly_slowly: FlySlowly) -> None:
    job = make_job("paper", "hybrid")
    where = job.compiled.gains_layout.slices["translation.normalized_stiffness"]
    gains = job.compiled.gains.copy()
    gains[where] *= 1.3
    stiffer = dataclasses.replace(job, tick=dataclasses.replace(job.compiled, gains=gains))
    soft, stiff = fly_native([job, stiffer], 2)
    assert_same(stiff, fly_slowly(stiffer))
    assert np.nanmax(np.abs(stiff.signals - soft.signals)) > 1e-3


def test_without_a_compiler_the_python_driver_serves_and_says_so(
    make_job: MakeJob, fly_slowly: FlySlowly, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fly_module, "unavailable", lambda: "no C compiler found")
    job = make_job("paper", "hybrid")
    with pytest.warns(UserWarning, match="Python driver: no C compiler found"):
        [found] = fly_native([job], 2)
    assert_same(found, fly_slowly(job))


def test_progress_reaches_the_end_and_nothing_is_nothing(make_job: MakeJob) -> None:
    jobs = [make_job("paper", "pid"), make_job("push", "pid", {"trajectory.duration": 9.0})]
    told: list[tuple[int, int]] = []
    fly_native(jobs, 2, lambda done, total: told.append((done, total)))
    total = sum(len(job.rows) for job in jobs)
    assert told[-1] == (total, total)
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert fly_native([], 4) == []


def test_a_programs_own_callback_keeps_serving_other_data() -> None:
    calls: list[int] = []
    signature = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
    own = signature(lambda model, data: calls.append(1))
    before = mujoco.get_mjcb_control()
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    data = mujoco.MjData(model)
    mujoco.set_mjcb_control(own)
    try:
        with control_callback(), control_callback():
            mujoco.mj_step(model, data)
        assert len(calls) == 1
        mujoco.mj_step(model, data)
        assert len(calls) == 2
    finally:
        mujoco.set_mjcb_control(before)
