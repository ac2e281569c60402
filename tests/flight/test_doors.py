"""Every door flies one truth: an event does the same behind each, and what one refuses, all refuse alike."""

from __future__ import annotations

import warnings
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Any

import numpy as np
import pytest
import xarray as xr

import skylimb
from short_flights import HOLD
from skylimb.analysis.recording import Run
from skylimb.apps.ros.grounded import GroundedPlant
from skylimb.apps.studio.flight_setup import FlightSetup
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.base.config import from_mapping
from skylimb.base.errors import SkylimbError
from skylimb.control.records import Command
from skylimb.flight import feasible
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.drivers.world import world
from skylimb.flight.events import PLANT_KINDS
from skylimb.flight.flying import fly_here, simulated_vehicle
from skylimb.flight.loading import plan_flights
from skylimb.flight.realtime.fly_on_clock import fly_on_clock
from skylimb.flight.realtime.fly_robot import fly_robot
from skylimb.flight.realtime.link import Datagram
from skylimb.flight.realtime.messages import Names, encode
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.simulated_robot import SimulatedRobot, serve_plant
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.spec import CampaignSpec
from skylimb.studies.campaign.worker import Job, fly_jobs

GAIN = {"kind": "gain", "time": 0.5, "key": "translation.normalized_stiffness", "value": [4.0, 2.5, 1.4]}
PUSH = {"kind": "push", "time": 0.9, "duration": 0.4, "force": [0.4, 0.2, 0.0]}
SURFACE = {"kind": "surface", "time": 0.3, "present": False}
ROTOR = {"kind": "rotor", "time": 0.5, "latest": 0.8, "rotor": "rotor2", "effectiveness": 0.8}
# Not limp, and speeds but a little wrong: a guard would rightly say that rates and poses do not fit.
JOINT = {"kind": "joint", "time": 0.5, "joint": "joint2", "strength": 0.5, "duration": 0.3}
TICK = {"kind": "tick", "time": 0.6, "duration": 0.05}
WIND = {"kind": "wind", "time": 0.5, "duration": 0.6, "velocity": [0.0, 4.0, 0.0]}
BODY = {"kind": "body", "time": 0.5, "mass": 0.1, "point": [0.2, 0.0, 0.05], "pen": 0.02}
SENSOR = {
    "kind": "sensor",
    "time": 0.8,
    "duration": 0.3,
    "capture": "disordered",
    "late": 0.02,
    "velocity": 0.9,
    "rates": 0.9,
    "joint": "joint2",
    "stuck": "encoder",
}
_EACH = GAIN, PUSH, SURFACE, ROTOR, JOINT, TICK, WIND, BODY, SENSOR
EVENTS: dict[str, dict[str, Any]] = {str(one["kind"]): one for one in _EACH}


class Standing(Pacer):
    """A clock that stands still but for sleeping: every tick is in time."""

    def __init__(self, period: float) -> None:
        self.moment = 0
        super().__init__(period, lambda: self.moment, self._sleep, spin=0.0)

    def _sleep(self, seconds: float) -> None:
        self.moment += round(seconds * 1e9)


class Silent:
    """A link on which nobody answers."""

    def receive(self, most: int) -> tuple[Iterable[Datagram], int]:
        return [], 0

    def send(self, data: bytes) -> None:
        pass

    def answer(self, sender: Hashable) -> None:
        pass


ROTORS = "rotors with a speed"
"""A push on a plant whose rotors turn the robot too, and which has an IMU."""

TOGETHER = "all but a surface that goes"
"""In one flight: each of them changes it, so a door that forgets one flies another."""

FLIGHTS = ["", TOGETHER, "surface", ROTORS]


def settings(*events: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    return {**HOLD, "events": [dict(event) for event in events], **more}


def settings_of(kind: str) -> dict[str, Any]:
    if kind == ROTORS:
        return settings(PUSH, **{"plant.rotors": "speed", "sensors.imu.on": True})
    if kind == TOGETHER:
        return settings(*(event for name, event in EVENTS.items() if name != "surface"))
    return settings(EVENTS[kind]) if kind else settings()


def by_run(experiment: str, controller: str | None, given: dict[str, Any]) -> Run:
    return skylimb.run(experiment, controller, set=given)


def by_begin(experiment: str, controller: str | None, given: dict[str, Any]) -> Run:
    flight = skylimb.begin(experiment, controller, set=given)
    while flight.tick():
        pass
    return flight.finish()


def by_native(experiment: str, controller: str | None, given: dict[str, Any]) -> Run:
    (takeoff,) = take_off(experiment, (controller,), set=given)
    return scored_run(takeoff, fly_native([takeoff])[0])


def by_compiled(experiment: str, controller: str | None, given: dict[str, Any]) -> Run:
    (takeoff,) = take_off(experiment, (controller,), set=given)
    return scored_run(takeoff, fly_here(takeoff))


def by_clock(experiment: str, controller: str | None, given: dict[str, Any]) -> Run:
    return fly_on_clock(experiment, controller, set=given, pacer=Standing).run


def by_studio(experiment: str, controller: str | None, given: dict[str, Any]) -> Run:
    (takeoff,) = FlightSetup(experiment, (controller,), keys=given).takeoffs()
    flight = LiveFlight(takeoff)
    while flight.tick():
        pass
    return scored_run(flight.takeoff, flight.flight())


def by_campaign(experiment: str, controller: str | None, given: dict[str, Any]) -> Run:
    tables = {"experiment": experiment, "controllers": [controller], "draws": 1, "seed": 0, "vary": {}}
    spec = from_mapping(CampaignSpec, {**tables, "set": {**given, "seed": 0}}, "spec")
    [flown] = fly_jobs(freeze(spec).text, [Job(0, log="always")])
    if flown.log is None:
        raise SkylimbError(str(flown.row["cause"]))
    return Run.of_content(flown.log, "log")


APPLY: dict[str, Callable[[str, str | None, dict[str, Any]], Run]] = {
    "begin": by_begin,
    "compiled": by_compiled,
    "native": by_native,
    "clock": by_clock,
    "studio": by_studio,
}
"""Doors behind which every kind of event acts."""


def same_bits(log: xr.Dataset, wanted: xr.Dataset) -> None:
    for name in wanted.data_vars:
        np.testing.assert_array_equal(log[name].values, wanted[name].values, err_msg=str(name))


@pytest.fixture(scope="module")
def flown() -> Callable[[str], Run]:
    known: dict[str, Run] = {}

    def fly(kind: str) -> Run:
        if kind not in known:
            known[kind] = skylimb.run("paper", "hybrid", set=settings_of(kind))
        return known[kind]

    return fly


@pytest.mark.parametrize("kind", EVENTS)
def test_an_event_changes_the_flight(kind: str, flown: Callable[[str], Run]) -> None:
    assert not np.array_equal(flown(kind).log.root_position, flown("").log.root_position)
    if kind == "surface":
        assert not flown(kind).log.contact_duty.values.any()


@pytest.mark.parametrize("kind", FLIGHTS)
@pytest.mark.parametrize("door", APPLY)
def test_behind_every_door_an_event_is_that_of_run(door: str, kind: str, flown: Callable[[str], Run]) -> None:
    same_bits(APPLY[door]("paper", "hybrid", settings_of(kind)).log, flown(kind).log)


@pytest.mark.parametrize("kind", ["", TOGETHER, "surface"])
def test_a_flight_of_a_campaign_is_that_of_run_with_its_seed(kind: str) -> None:
    log = by_campaign("paper", "hybrid", settings_of(kind)).log
    same_bits(log, skylimb.run("paper", "hybrid", int(log.attrs["seed"]), settings_of(kind)).log)


@pytest.mark.parametrize("kind", [TOGETHER, "surface", ROTORS])
def test_a_simulated_robot_behind_a_link_has_the_events_of_its_plant(
    kind: str, flown: Callable[[str], Run]
) -> None:
    (takeoff,) = take_off("paper", ("hybrid",), set=settings_of(kind))
    coming, sent, log = deque[bytes](), deque[bytes](), flown(kind).log

    class Wire:
        def receive(self, most: int) -> tuple[Iterable[Datagram], int]:
            return [Datagram(coming.popleft(), "us") for _ in range(len(coming))], 0

        def send(self, data: bytes) -> None:
            sent.append(data)

        def answer(self, sender: Hashable) -> None:
            """There is one only."""

    robot, names = SimulatedRobot(takeoff, Wire()), Names(takeoff.robot)
    for k in range(log.sizes["time"]):
        np.testing.assert_array_equal(robot.position(), log.root_position.values[k])
        command = Command(*(log[f"{name}_command"].values[k] for name in Command._fields))
        coming.append(encode(names.command_message(k, 0.0, command)))
        robot.act()


def test_what_fails_for_good_has_failed_after_the_mission_too() -> None:
    """A robot that waits flies on with the noise of its mission, and not through its events once more."""
    late = {"kind": "sensor", "time": 0.3, "stamp": 0.5}
    (takeoff,) = take_off("free_flight", ("pid",), set={"stop_at": 0.6, "events": [late]})
    rows, period = len(takeoff.fixed_rows), takeoff.period
    vehicle = simulated_vehicle(takeoff, world(takeoff, period * np.arange(rows + 40)))
    first, ages = takeoff.mission.first, []
    hover = Command(takeoff.start.act[: takeoff.robot.n_rotors], first.joint_angles, first.vectoring_angles)
    for _ in range(rows + 20):
        ages.append(float(vehicle.measure().capture_age))
        vehicle.apply(hover)
    begin = round(0.3 / period)
    assert max(ages[:begin]) < 0.1
    assert min(ages[begin:]) > 0.5


def test_a_robot_behind_a_link_refuses_events_of_a_plant() -> None:
    for kind in sorted(PLANT_KINDS):
        with pytest.raises(SkylimbError, match=f"a robot behind a link cannot apply '{kind}'"):
            fly_robot(Silent(), "paper", "hybrid", settings(EVENTS[kind]), patience=0.0)
    with pytest.raises(SkylimbError, match="no measurement came"):
        fly_robot(Silent(), "paper", "hybrid", settings(GAIN), patience=0.0)


def test_who_does_not_control_refuses_events_of_a_controller() -> None:
    with pytest.raises(SkylimbError, match="a simulated robot behind a link cannot apply 'gain'"):
        serve_plant(Silent(), "paper", settings(GAIN))


@pytest.mark.parametrize("kind", EVENTS)
def test_a_flight_that_its_user_starts_refuses_every_event(kind: str) -> None:
    (takeoff,) = take_off("paper", ("hybrid",), set=settings(EVENTS[kind]))
    with pytest.raises(SkylimbError, match=f"whose take-off its user chooses, cannot apply '{kind}'"):
        GroundedPlant(takeoff)


def test_a_replay_has_the_gains_that_changed(flown: Callable[[str], Run]) -> None:
    replayed = skylimb.replay(flown("gain"))
    np.testing.assert_array_equal(replayed.log.thrusts_command, flown("gain").log.thrusts_command)


REFUSED: dict[str, tuple[str, str, dict[str, Any], str]] = {
    "20 N at the ceiling": ("ceiling", "following", {"controller.translation.force": 20.0}, "20 N"),
    "4.9 N on what is believed a rough surface": (
        "paper",
        "following",
        {"controller.translation.force": 4.9, "approach.believed_friction": [0.8, 0.8]},
        "4.9 N is too much",
    ),
    "a gain that is not there": (
        "paper",
        "hybrid",
        {"events": [{**GAIN, "key": "translation.stifness"}]},
        "normalized_stiffness",
    ),
    "a gain that cannot be": ("paper", "hybrid", {"events": [{**GAIN, "value": [-1.0, 1.0, 1.0]}]}, "-1"),
    "a link that is not there": ("paper", "hybrid", {"events": [{**PUSH, "link": "link9"}]}, "link9"),
    "an event after the end": (
        "paper",
        "hybrid",
        {"events": [{**PUSH, "time": 900.0}]},
        "after the flight's end",
    ),
    "two that contradict": (
        "paper",
        "hybrid",
        {"events": [GAIN, {**GAIN, "value": [3.0, 3.0, 3.0]}]},
        "contradict each other",
    ),
    "a surface in the robot": ("paper", "hybrid", {"surface_error": [0.5, 0.0, 0.0]}, "intersects"),
    "a path beyond the board": ("paper", "hybrid", {"surface.size": [0.1, 0.1]}, "leaves surface"),
    "a rotor too many": ("paper", "hybrid", {"plant.rotor_scale": [1.0] * 5}, "rotor_scale"),
    "a rate that does not fit": ("paper", "hybrid", {"controller_rate": 170.0}, "physics_step"),
    "a posture that cannot hover": ("paper", "hybrid", {"posture.margin": 50.0}, "margin"),
}

BEFORE: dict[str, Callable[[str, str, dict[str, Any]], Any]] = {
    **APPLY,
    "campaign": by_campaign,
    "link": lambda experiment, controller, given: fly_robot(
        Silent(), experiment, controller, given, patience=0.0
    ),
    "ros": lambda experiment, controller, given: plan_flights(experiment, (controller,), set=given),
}


def refusal(fly: Callable[[], Any]) -> str:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(SkylimbError) as told:
            fly()
    return str(told.value)


@pytest.mark.parametrize("case", REFUSED)
def test_what_one_door_refuses_all_refuse_in_the_same_words(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A posture that hovers better is sought elsewhere.
    monkeypatch.setattr(feasible, "nearest_posture", lambda *_: None)
    experiment, controller, given, words = REFUSED[case]
    given = {**(HOLD if experiment == "paper" and "beyond" not in case else {}), **given}
    wanted = refusal(lambda: by_run(experiment, controller, given))
    assert words in wanted
    for door, fly in BEFORE.items():
        if door == "campaign" and "controller." in "".join(given):
            continue  # gains of a campaign are those of its presets' files
        said = refusal(lambda fly=fly: fly(experiment, controller, given))
        assert wanted in said or said in wanted, door
