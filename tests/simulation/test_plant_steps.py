"""A simulator of a user's own in the engine's place: the same flight, and named mistakes."""

import dataclasses
import functools
import runpy
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.control.needs import needs_of
from skylimb.flight.flying import fly_here
from skylimb.flight.stepped import SteppedFlight
from skylimb.flight.takeoff import take_off
from skylimb.simulation.user_plant import UserPlant

EXAMPLE = Path(__file__).parents[2] / "examples" / "user_plant.py"
Stranger: Any = runpy.run_path(str(EXAMPLE))["Stranger"]

FAULTS = (
    {"kind": "push", "time": 0.1, "duration": 0.1, "force": (1.0, -2.0, 0.5)},
    {
        "kind": "push",
        "time": 0.15,
        "duration": 0.1,
        "link": "link4",
        "point": (0.1, 0.0, 0.0),
        "torque": (0, 0, 0.3),
    },
    {"kind": "rotor", "time": 0.2, "rotor": "rotor2", "effectiveness": 0.9},
    {"kind": "joint", "time": 0.1, "joint": "joint3", "strength": 0.5},
    {"kind": "tick", "time": 0.3, "duration": 0.02},
    {"kind": "sensor", "time": 0.1, "duration": 0.3, "late": 0.02},
)


def rms(one: skylimb.Run, other: skylimb.Run, signal: str) -> float:
    away = one.log[signal].values - other.log[signal].values
    return float(np.sqrt(np.mean(np.sum(away**2, axis=1))))


def test_a_touch_is_that_of_the_engine() -> None:
    own, engine = (
        skylimb.run("paper", controller="hybrid", set=HOLD, plant=plant) for plant in (Stranger(), None)
    )
    assert own.status == engine.status == "OK", own.cause
    assert own.metrics["contact_force_normal_mean"] > 0.5
    assert rms(own, engine, "cog_position") < 1e-4
    assert rms(own, engine, "tip_position") < 1e-4
    assert rms(own, engine, "contact_force") < 0.05
    assert "plant 'stranger' flew in place of MuJoCo" in own.log.attrs["notes"]


@functools.cache
def calm() -> skylimb.Run:
    """The same flight without any fault."""
    return skylimb.run("free_flight", "pid", set={"stop_at": 0.6})


@pytest.mark.parametrize("event", FAULTS, ids=lambda event: event["kind"])
def test_pushes_and_faults_do_the_same(event: dict[str, Any]) -> None:
    short = {"events": [event], "stop_at": 0.6}
    own, engine = (skylimb.run("free_flight", "pid", set=short, plant=plant) for plant in (Stranger(), None))
    assert rms(own, engine, "cog_position") < 2e-5
    assert rms(own, engine, "thrusts") < 0.03 * rms(calm(), engine, "thrusts")


def test_a_controller_in_python_flies_it_as_the_compiled_one_does() -> None:
    """Both drivers advance the same plant."""

    class Untraceable:
        def __init__(self, inner: skylimb.Controller) -> None:
            self.name, self.step = inner.name, inner.step
            self.gains, self.initial_state, self.needs = inner.gains, inner.initial_state, needs_of(inner)

    (takeoff,) = take_off("free_flight", ("pid",), set={"stop_at": 0.1}, plant=Stranger())
    hidden = dataclasses.replace(takeoff, controller=Untraceable(takeoff.controller), own_plant=Stranger())
    compiled, slow = fly_here(takeoff), fly_here(hidden)
    assert not takeoff.compiled
    np.testing.assert_allclose(slow.signal("configuration"), compiled.signal("configuration"), atol=1e-12)


class Wrong:
    """A plant whose truth is spoilt from some step on."""

    def __init__(self, spoil: Callable[[dict[str, Any]], Any], at: int) -> None:
        self._own, self._spoil, self._left = Stranger(), spoil, at

    def start(self, beginning: skylimb.Beginning) -> Any:
        return self._said(self._own.start(beginning))

    def step(self, drive: skylimb.Drive) -> Any:
        return self._said(self._own.step(drive))

    def _said(self, truth: dict[str, Any]) -> Any:
        self._left -= 1
        return truth if self._left >= 0 else self._spoil(truth)


def test_either_quaternion_of_an_attitude_is_the_same_truth() -> None:
    """A simulator may change the sign from step to step; sensors interpolate between steps."""

    def other(truth: dict[str, Any]) -> dict[str, Any]:
        nonlocal said
        said += 1
        return truth | {"root_quaternion": truth["root_quaternion"] * (-1.0 if said % 7 < 4 else 1.0)}

    said = 0
    short = {"stop_at": 0.3, "sensors.latency": 0.0125}  # no whole number of ticks
    one, two = (
        skylimb.run("free_flight", "pid", set=short, plant=Wrong(spoil, 0)) for spoil in (dict, other)
    )
    for signal in ("root_quaternion_measured", "root_quaternion", "thrusts_command"):
        np.testing.assert_allclose(two.log[signal].values, one.log[signal].values, rtol=0.0, atol=1e-12)


SPOILT = [
    (
        lambda truth: truth | {"joint_rates": [0.0, 1j, 0.0]},
        "joint_rates = [0.0, 1j, 0.0], which is complex",
    ),
    (
        lambda truth: truth | {"joint_rates": [0.0, np.nan, 0.0]},
        "joint_rates = [ 0. nan  0.], which is not finite",
    ),
    (lambda truth: truth | {"root_velocity": np.zeros(4)}, "root_velocity the shape (4,); it has (3,)"),
    (lambda truth: truth | {"root_pos": 0.0}, "did you mean 'root_position'?"),
    (lambda truth: {name: truth[name] for name in truth if name != "contact_point"}, "no 'contact_point'"),
    (lambda truth: truth | {"root_quaternion": [1.0, 1.0, 0.0, 0.0]}, "the length 1.414; it is 1"),
    (lambda truth: truth | {"joint_angles": "bent"}, "joint_angles"),
    (lambda truth: None, "gives NoneType, no dict"),
    (lambda truth: 1 / 0, "ZeroDivisionError"),
]


@pytest.mark.parametrize(("spoil", "words"), SPOILT)
def test_what_cannot_be_the_truth_ends_the_flight_by_name_and_keeps_its_log(spoil: Any, words: str) -> None:
    with pytest.raises(UserCodeError) as refused:
        skylimb.begin("free_flight", "pid", plant=Wrong(spoil, 0))
    assert "plant 'Wrong'" in str(refused.value)
    assert words in str(refused.value)
    run = skylimb.run("free_flight", "pid", plant=Wrong(spoil, 101))
    assert run.status == "FAILED"
    assert words in run.cause
    assert len(run.log.time) == 20


def test_a_plant_that_begins_elsewhere_is_refused() -> None:
    def aside(truth: dict[str, Any]) -> dict[str, Any]:
        return truth | {"root_position": truth["root_position"] + [0.0, 0.0, 0.2]}

    with pytest.raises(UserCodeError, match=r"begins elsewhere.*root_position is 0.2 off"):
        skylimb.begin("free_flight", "pid", plant=Wrong(aside, 0))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"plant.foot": 0.04}, "not with plant.foot"),
        ({"events": [{"kind": "body", "time": 1.0, "mass": 0.1}]}, "plant 'stranger' cannot apply 'body'"),
        ({"events": [{"kind": "surface", "time": 1.0, "friction": 0.1}]}, "cannot apply 'surface'"),
    ],
)
def test_what_such_a_plant_cannot_be_told_is_refused_before_take_off(
    changes: dict[str, Any], words: str
) -> None:
    with pytest.raises(ConfigError, match=words):
        skylimb.begin("paper", "hybrid", set=changes, plant=Stranger())


def test_a_flight_with_a_plant_of_ones_own_can_be_stepped() -> None:
    plant: UserPlant = Stranger()
    flight: SteppedFlight = skylimb.begin("free_flight", "pid", plant=plant)
    while flight.time < 0.05:
        flight.tick()
    assert flight.signal("configuration").shape == (10, 14)


def test_the_guide_shows_the_examples_own_step() -> None:
    text = EXAMPLE.read_text()
    step = textwrap.dedent(text[text.index("    def step(") : text.index("    def truth(")]).strip()
    # What stands in a class there has a line more between two functions on the page.
    page = (EXAMPLE.parents[1] / "docs" / "your_simulator.md").read_text()
    assert step in page.replace("\n\n\n", "\n\n")


@pytest.mark.parametrize(
    ("plant", "words"),
    [
        ("gazebo", "plant = 'gazebo' has no start and no step; a plant has start(beginning) and step(drive)"),
        (Stranger, "is a class, not one of its objects"),
    ],
)
def test_what_is_no_plant_is_named(plant: Any, words: str) -> None:
    with pytest.raises(ConfigError) as refused:
        skylimb.run("free_flight", "pid", plant=plant)
    assert words in str(refused.value)
