"""The native driver flies what the compiled driver flies, alone and in company."""

import copy
import ctypes
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from skylimb.control.loop.flight import Flight
from skylimb.control.loop.loop import CHECK_INTERVAL
from skylimb.control.missions.clock import entries
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference
from skylimb.flight.drivers import machine_code
from skylimb.flight.drivers.native import compile_native, fly_native
from skylimb.flight.drivers.native import fly as fly_module
from skylimb.flight.drivers.native.library import control_callback
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation import compiling
from skylimb.simulation.plant import Plant

Make = Callable[..., Takeoff]

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
CHANGED = {
    "events": [
        {"kind": "gain", "time": 1.0, "key": "translation.force", "value": 1.6},
        {
            "kind": "gain",
            "time": 1.2,
            "key": "attitude.damping_ratio",
            "value": [1.0, 1.0, 1.0],
            "duration": 0.2,
        },
        {"kind": "gain", "time": 1.3, "key": "translation.force", "value": 0.8, "duration": 0.0},
    ]
}
PUSH = {
    "kind": "push",
    "time": 1.5,
    "duration": 0.7,
    "force": [0.0, 0.5, -0.3],
    "torque": [0.02, 0.0, 0.05],
}
POKES = [
    {"kind": "push", "time": 1.0, "duration": 0.5, "force": [0.4, 0.0, -0.2]},
    {
        "kind": "push",
        "time": 1.2,
        "duration": 0.6,
        "force": [0.0, 0.5, 0.3],
        "link": "link4",
        "point": [0.3, 0.02, 0.0],
    },
    {"kind": "push", "time": 1.4, "duration": 0.1, "torque": [0.0, 0.0, 0.1], "link": "link2"},
]
LEAVING = {"surface.advance_distance": -0.05, "surface.advance_speed": 0.05, "surface.advance_start": 2.0}
FLIGHTS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "pid": ("paper", "pid", {}),
    "impedance": ("paper", "impedance", {}),
    "admittance": ("paper", "admittance", {}),
    "hybrid": ("paper", "hybrid", {}),
    "free flight": ("free_flight", "hybrid", {"posture.hold": 0.1}),
    "push": ("push", "hybrid", {"events.0.time": 3.0, "trajectory.duration": 5.0}),
    "pushes on links": ("free_flight", "hybrid", {"events": POKES, "posture.hold": 0.1}),
    "moving board": ("paper", "hybrid", MOVING),
    "friction of the place": ("paper", "hybrid", SLIPPERY),
    "all at once": ("paper", "pid", {**MOVING, **SLIPPERY, "events": [PUSH, *POKES]}),
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
    "pushed away": ("push", "pid", {"events.0.force": [0.0, 20.0, 0.0], "events.0.time": 2.0}),
}
LOST = {"no lift": "hit the floor", "pushed away": "lost position"}


def assert_same(found: Flight, wanted: Flight) -> None:
    assert (found.ticks, found.cause) == (wanted.ticks, wanted.cause)
    np.testing.assert_allclose(
        found.signals[: found.ticks], wanted.signals[: wanted.ticks], rtol=0.0, atol=1e-9
    )


@pytest.fixture(scope="module")
def company(make_takeoff: Make) -> list[Takeoff]:
    """Flights of every kind: other scenes, controllers, lengths, some lost, two that share a plant."""
    takeoffs = [make_takeoff(*flight, seed=seed) for seed, flight in enumerate(FLIGHTS.values())]
    patchy = make_takeoff(*FLIGHTS["friction of the place"], seed=50)
    seeded = make_takeoff("paper", "hybrid", SLIPPERY, 51)
    return [*takeoffs, patchy, patchy.changed(seeded.experiment)]


@pytest.fixture(scope="module")
def flown(company: list[Takeoff]) -> list[Flight]:
    """That company in the native driver, in one thread."""
    return fly_native(company, 1)


@pytest.mark.parametrize("name", [*FLIGHTS, "a plant", "the same plant"])
def test_both_drivers_fly_the_same(name: str, company: list[Takeoff], flown: list[Flight]) -> None:
    """In company; alone it is flown by every other test here."""
    place = [*FLIGHTS, "a plant", "the same plant"].index(name)
    found, takeoff = flown[place], company[place]
    assert_same(found, fly_here(takeoff))
    assert LOST.get(name, "") in found.cause
    assert bool(found.cause) == (name in LOST)
    if takeoff.experiment.name not in ("free_flight", "push") and not found.cause:
        assert found.signal("contact_duty").max() > 0.0


def test_as_a_user_builds_it_it_flies_the_same_bits(
    company: list[Takeoff], flown: list[Flight], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With optimisation, which the other tests go without."""
    place = [*FLIGHTS].index("all at once")
    monkeypatch.setattr(compiling, "FLAGS", tuple(flag.replace("-O0", "-O2") for flag in compiling.FLAGS))
    monkeypatch.setattr(machine_code, "_loaded", type(machine_code._loaded)())
    (found,) = fly_native([company[place]], 1)
    assert len(machine_code._loaded) == 1
    assert found.ticks == flown[place].ticks
    assert np.array_equal(found.signals[: found.ticks], flown[place].signals[: found.ticks], equal_nan=True)


def test_any_number_of_threads_gives_the_same_bits(company: list[Takeoff], flown: list[Flight]) -> None:
    for a, b in zip(flown, fly_native(company, 8), strict=True):
        assert (a.ticks, a.cause) == (b.ticks, b.cause)
        assert np.array_equal(a.signals[: a.ticks], b.signals[: b.ticks], equal_nan=True)


def test_the_engine_stops_soon_after_a_mission_that_waited(
    make_takeoff: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    takeoff = make_takeoff("paper", "following", {**SHORT, **LEAVING})
    steps, fly = [], fly_module.step_flights

    def counted(batch: Any, flights: Any, ids: list[int], count: int) -> None:
        steps.append(count)
        fly(batch, flights, ids, count)

    monkeypatch.setattr(fly_module, "step_flights", counted)
    (flight,) = fly_native([takeoff])
    assert not flight.cause
    assert flight.ticks > len(takeoff.mission.times)  # it waited for its pen
    assert sum(steps) // takeoff.plant.substeps - flight.ticks < CHECK_INTERVAL


def test_a_flight_leaves_its_takeoff_as_it_was(make_takeoff: Make) -> None:
    takeoff = make_takeoff("paper", "hybrid", {**SLIPPERY, **MOVING})
    state, friction = takeoff.data().qpos.copy(), takeoff.plant.model.pair_friction.copy()
    first, second = fly_native([takeoff])[0], fly_native([takeoff])[0]
    assert np.array_equal(takeoff.data().qpos, state)
    assert np.array_equal(takeoff.plant.model.pair_friction, friction)
    assert np.array_equal(first.signals, second.signals, equal_nan=True)


def until(whole: Mission, ticks: int) -> Mission:
    """The first ticks of a mission."""
    return dataclasses.replace(
        whole,
        times=whole.times[:ticks],
        reference=Reference(*(entry[:ticks] for entry in entries(whole.reference))),
        phase=whole.phase[:ticks],
        tip_path=whole.tip_path[:ticks],
    )


@dataclasses.dataclass(frozen=True)
class Ghost(Takeoff):
    """A flight with the mission and the plant that it is given."""

    given: Any = None

    @property
    def mission(self) -> Mission:
        return self.given[0]

    @property
    def plant(self) -> Plant:
        return self.given[1]


@pytest.mark.parametrize("ticks", [50, 100, 250])
def test_the_engines_warnings_end_a_flight(
    ticks: int, make_takeoff: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # where the engine leaves its log
    takeoff = make_takeoff("paper", "hybrid", MOVING)
    model = copy.copy(takeoff.plant.model)
    wall = model.body("surface").id
    # The engine warns of the board's inertia; as its place is written at every tick, nothing else is amiss.
    model.body_mass[wall], model.body_inertia[wall] = 1e-17, 1e-17
    given = until(takeoff.mission, ticks), dataclasses.replace(takeoff.plant, model=model)
    ghost = Ghost(takeoff.experiment, takeoff.robot, takeoff.controller, given=given)
    wanted = fly_here(ghost)
    assert "the physics engine warned (mjWARN_INERTIA)" in wanted.cause
    assert wanted.ticks == min(ticks, CHECK_INTERVAL)
    first, healthy, last = fly_native([ghost, takeoff, ghost], 1)
    assert_same(first, wanted)
    assert_same(last, wanted)
    assert healthy.cause == ""


def test_gains_seeds_and_the_plants_numbers_share_one_build(make_takeoff: Make) -> None:
    takeoff = make_takeoff("paper", "hybrid")
    other = make_takeoff(
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
    assert other.tick.function is takeoff.tick.function
    address = compile_native(takeoff.tick.function)[1]
    assert compile_native(other.tick.function)[1] == address
    assert compile_native(make_takeoff("paper", "pid").tick.function)[1] != address


def test_gains_are_data(make_takeoff: Make) -> None:
    takeoff = make_takeoff("paper", "hybrid")
    gain = {"controller.translation.normalized_stiffness": [3.2, 3.2, 2.0]}
    stiffer = make_takeoff("paper", "hybrid", gain)
    assert stiffer.tick.function is takeoff.tick.function
    soft, stiff = fly_native([takeoff, stiffer], 2)
    assert_same(stiff, fly_here(stiffer))
    assert np.nanmax(np.abs(stiff.signals - soft.signals)) > 1e-3


def test_without_a_compiler_the_compiled_driver_serves_and_says_so(
    make_takeoff: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fly_module, "unavailable", lambda: "no C compiler found")
    takeoff = make_takeoff("paper", "hybrid")
    with pytest.warns(UserWarning, match="compiled driver: no C compiler found"):
        [found] = fly_native([takeoff], 2)
    assert_same(found, fly_here(takeoff))


def test_progress_reaches_the_end_and_nothing_is_nothing(make_takeoff: Make) -> None:
    takeoffs = [make_takeoff("paper", "pid"), make_takeoff("push", "pid", {"trajectory.duration": 9.0})]
    reported: list[tuple[int, int]] = []
    fly_native(takeoffs, 2, lambda done, total: reported.append((done, total)))
    total = sum(len(takeoff.rows) for takeoff in takeoffs)
    assert reported[-1] == (total, total)
    assert [done for done, _ in reported] == sorted(done for done, _ in reported)
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
