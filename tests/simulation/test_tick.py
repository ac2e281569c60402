"""Ticks of the same structure are traced once; anything else is traced on its own."""

import dataclasses
import functools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from skylimb.control.cascade import Cascade
from skylimb.control.translation.laws import pid
from skylimb.flight.takeoff import take_off
from skylimb.simulation import tick
from skylimb.simulation.tick import CompiledTick


def compiled(set: dict[str, Any] | None = None, name: str = "pid", law: Any = None) -> CompiledTick:
    (takeoff,) = take_off("paper", (name,), set=set)
    cascade = takeoff.controller
    assert isinstance(cascade, Cascade)
    if law is not None:
        slot = dataclasses.replace(cascade.preset.slots.translation, law=law)
        cascade = dataclasses.replace(cascade, preset=cascade.preset.with_slot("translation", slot))
    return dataclasses.replace(takeoff, controller=cascade).tick


@pytest.mark.parametrize(
    "change",
    [
        {"sensors.latency": 0.03},
        {"sensors.rate": 50.0},
        {"controller_rate": 100.0},
        {"surface.sway_amplitude": 0.01},
        {"plant.physics_step": 0.0005},
    ],
)
def test_another_structure_is_another_function(change: dict[str, Any]) -> None:
    assert compiled(change).function is not compiled().function


def test_another_law_is_another_function() -> None:
    own = SimpleNamespace(Gains=pid.Gains, initial_state=pid.initial_state, step=functools.partial(pid.step))
    assert compiled(law=own).function is not compiled(law=pid).function
    assert compiled(name="hybrid").function is not compiled().function


def test_numbers_share_a_function_and_keep_to_their_flight() -> None:
    changes = {
        "surface.slope": 0.1,
        "plant.mass_scale": 1.1,
        "sensors.attitude_misalignment": [0.01, 0.0, 0.0],
        "sensors.position_noise": 0.002,
    }
    one, other = compiled(), compiled(changes)
    assert other.function is one.function
    assert not np.array_equal(other.state, one.state)
    tick._traced.clear()
    fresh = compiled(changes)
    assert fresh.function is not one.function
    np.testing.assert_array_equal(other.state, fresh.state)
    np.testing.assert_array_equal(other.gains, fresh.gains)
    values = [
        np.random.default_rng(1).normal(size=one.function.size1_in(i)) for i in range(one.function.n_in())
    ]
    for shared, alone in zip(one.function(*values), fresh.function(*values), strict=True):
        np.testing.assert_array_equal(np.asarray(shared), np.asarray(alone))
