"""The record of a steered flight: replayed to 1e-9, and its mission scored like a flight of `skylimb run`."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.analysis.recording import Run
from skylimb.analysis.report.controller_replay import differences
from skylimb.apps.ros.live_record import LiveRecord
from skylimb.apps.ros.states import FlightState, Order
from skylimb.control.loop.flight import Flight
from skylimb.flight.simulated_run import scored_run
from steered import Steered

PREVIEW = str(Path(__file__).parents[3] / "examples" / "laws" / "preview.toml")


Flown = tuple[Steered, Run, Flight]
"""A robot that was steered, its whole flight, and the mission on its way."""


@pytest.fixture(
    scope="module",
    params=[*(pytest.param(name, marks=pytest.mark.slow) for name in ("hybrid", "following")), PREVIEW],
)
def flown(request: pytest.FixtureRequest) -> Flown:
    robot = Steered(request.param)
    record = LiveRecord(robot.takeoff, robot.plant.layout, robot.pilot.rehearsed())
    missions: list[Flight] = []

    def tick(*orders: Order, mission: str | None = None) -> None:
        flown = robot.tick(*orders, mission=mission)
        list(record.add(flown, robot.rows[-1]))
        if over := record.mission_flown(flown):
            missions.append(over[1]())

    tick()
    tick(Order.START)
    while robot.state != FlightState.ARM_ON:
        tick()
    tick(Order.TAKEOFF)
    while robot.state != FlightState.HOVER:
        tick()
    tick(mission="paper")
    while not missions:
        tick()
    tick(Order.LAND)
    while robot.state != FlightState.ARM_OFF:
        tick()
    pending = record.finish()
    assert pending is not None
    assert record.finish() is None
    return robot, pending.run(), missions[0]


def test_it_is_replayed_to_the_same_numbers(flown: Flown) -> None:
    robot, run, _ = flown
    takeoff = robot.takeoff
    assert np.isfinite(run.log.thrusts_command).all()
    again = skylimb.replay(run)
    assert not any("ahead" in note for note in again.notes)
    for name in ("thrusts_command", "joint_angles_command", "external_force_estimate"):
        np.testing.assert_allclose(again.log[name], run.log[name], atol=1e-9, rtol=0, err_msg=name)
    assert [one for one in differences(run, again) if not one.same] == []
    if takeoff.window.preview:
        name = "whole_reference_ahead"
        blind = skylimb.replay(dataclasses.replace(run, log=run.log.drop_vars(name)))
        assert run.sources
        assert "no references ahead as this controller wants them: those of later ticks" in blind.notes
        assert np.abs(blind.log.thrusts_command.values - run.log.thrusts_command.values).max() > 1e-3
    other = skylimb.replay(run, controller="pid")
    assert np.abs(other.log.thrusts_command.values - run.log.thrusts_command.values).max() > 0.1


def test_its_mission_has_the_scores_of_run(flown: Flown) -> None:
    robot, _, mission = flown
    run = scored_run(robot.takeoff, mission)
    assert run.status == "OK"
    alone = skylimb.run(robot.takeoff.experiment, robot.takeoff.controller)
    assert run.metrics.keys() == alone.metrics.keys()
    for name in ("contact_time", "force_rms"):
        if name in alone.metrics:
            assert run.metrics[name] == pytest.approx(alone.metrics[name], rel=0.3)
