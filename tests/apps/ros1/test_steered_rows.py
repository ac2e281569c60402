"""The record of a steered flight: replayed to 1e-9, and its mission scored like a flight of `skylimb run`."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.analysis.report.controller_replay import differences
from skylimb.apps.ros1.states import FlightState, Order
from skylimb.apps.ros1.steered_rows import SteeredRecord
from skylimb.flight.simulated_run import recorded
from steered import Steered

PREVIEW = str(Path(__file__).parents[3] / "examples" / "laws" / "preview.toml")


@pytest.fixture(scope="module", params=["hybrid", "following", PREVIEW])
def flown(request: pytest.FixtureRequest) -> tuple[Steered, SteeredRecord, tuple[int, int]]:
    robot = Steered(request.param)
    record: SteeredRecord | None = None
    mission: list[int] = []

    def kept() -> None:
        nonlocal record
        tick = robot.ticks[-1]
        if tick.reference is None or not tick.signals:
            return
        if record is None:
            paced = robot.takeoff.window.paced
            record = SteeredRecord(robot.plant.layout, tick.signals, tick.reference, paced)
        script = tick.script if tick.script is not None and tick.script.begun else None
        if script is not None:
            mission.append(record.ticks)
        clock = 0.0 if script is None else float(script.clock.ticks) * robot.takeoff.period
        record.add(robot.rows[-1], tick.signals, clock, tick.flying.shown, tick.reference)

    orders: dict[int, tuple[Order, ...]] = {1: (Order.START,), 20: (Order.TAKEOFF,)}
    hovered = False
    for k in range(8000):
        go = robot.state == FlightState.HOVER and not hovered
        hovered |= go
        robot.tick(*orders.get(k, ()), mission="paper" if go else "")
        kept()
        flight = robot.pilot.flight
        if hovered and flight is not None and flight.script is None and mission:
            break
    robot.tick(Order.LAND)
    while robot.state != FlightState.ARM_OFF:
        kept()
        robot.tick()
    assert record is not None
    return robot, record, (mission[0], mission[-1] + 1)


def test_it_is_replayed_to_the_same_numbers(flown: tuple[Steered, SteeredRecord, tuple[int, int]]) -> None:
    robot, record, _ = flown
    takeoff = robot.takeoff
    run = record.run(takeoff)
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


def test_its_mission_has_the_scores_of_run(flown: tuple[Steered, SteeredRecord, tuple[int, int]]) -> None:
    robot, record, (first, last) = flown
    run = recorded(robot.takeoff, record.flight(first, last))
    assert run.status == "OK"
    alone = skylimb.run(robot.takeoff.experiment, robot.takeoff.controller)
    assert run.metrics.keys() == alone.metrics.keys()
    for name in ("contact_time", "force_rms"):
        if name in alone.metrics:
            assert run.metrics[name] == pytest.approx(alone.metrics[name], rel=0.3)


def test_rows_grow_beyond_the_first_chunk(flown: tuple[Steered, SteeredRecord, tuple[int, int]]) -> None:
    _, record, _ = flown
    rows = record.flight(0, record.ticks)
    assert rows.signals.shape[0] == record.ticks
    assert np.isfinite(rows.signal("thrusts_command")).all()
