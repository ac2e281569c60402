"""What a run says of its flight: events, transitions of the contact, units of the configuration."""

import json

import numpy as np

import skylimb
from skylimb.base.config import flatten
from skylimb.base.keys import rows_of, tables_of
from skylimb.control.contact.machine import (
    APPROACH,
    CALM,
    FREE,
    REASONS,
    SETTLE,
    SLIDE,
    START,
    STATES,
    TOUCHED,
    WANTED,
)
from skylimb.flight.flight_run import config_units, contact_transitions

SHORT = {
    "phases.hover": 0.3,
    "phases.tare": 0.5,
    "phases.settle": 1.5,
    "phases.hover_end": 1.5,
    "approach.speed": 0.2,
    "trajectory.shape": "hold",
    "trajectory.duration": 1.0,
}


def test_transitions_are_told_in_words() -> None:
    state = np.array([FREE, APPROACH, APPROACH, SETTLE, SLIDE])
    reason = np.array([START, WANTED, WANTED, TOUCHED, CALM])
    assert contact_transitions(0.1 * np.arange(5), state, reason) == [
        (0.1, "free", "approach", "the mission wants touch"),
        (0.3, "approach", "settle", "touched"),
        (0.4, "settle", "slide", "the force is calm"),
    ]
    assert contact_transitions(np.arange(2.0), np.array([0, 9]), np.array([0, -1])) == [
        (1.0, "free", "9", "-1")
    ]
    assert contact_transitions(np.zeros(0), np.zeros(0), np.zeros(0)) == []


def test_a_flights_transitions_are_in_its_log() -> None:
    log = skylimb.run("paper", controller="following", set=SHORT).log
    changes = json.loads(log.attrs["contact_transitions"])
    assert [after for _, _, after, _ in changes] == ["approach", "settle", "slide", "retreat", "free"]
    assert changes[0][3] == "the mission wants touch"
    assert changes[0][0] == 0.8
    for name, names in (("contact_state", STATES), ("contact_reason", REASONS)):
        assert log[name].dtype == np.int8
        np.testing.assert_array_equal(log[name].attrs["flag_values"], range(len(names)))
        assert log[name].attrs["flag_meanings"].replace("_", " ").startswith(names[0])
    assert len(log.contact_reason.attrs["flag_meanings"].split()) == len(REASONS)


def test_the_reference_is_the_missions_whatever_the_law_aims_at() -> None:
    follower = skylimb.run("paper", controller="following", set=SHORT)
    keeper = skylimb.run(
        "paper", controller="hybrid", set={**SHORT, "controller.allocation.vectoring.purpose": "contact"}
    )
    log, plain = follower.log, keeper.log
    # Both flew the same mission; the follower's clock may have stood still in between.
    for signal in ("cog_position_reference", "tip_position_reference"):
        missions = [
            np.interp(log.mission_time, plain.time, plain[signal].sel(axis=axis)) for axis in ("x", "y", "z")
        ]
        np.testing.assert_allclose(log[signal], np.stack(missions, axis=1), atol=1e-9, err_msg=signal)
    assert float(abs(log.cog_position_target - log.cog_position_reference).max()) > 0.01
    assert log.cog_position_target.attrs["kind"] == "command"
    assert log.cog_position_target.attrs["units"] == "m"
    assert "cog_position_target" not in plain
    assert follower.metrics["target_error_u_median"] < follower.metrics["error_u_median"]
    assert keeper.metrics["target_error_u_median"] is None


def test_every_gap_of_the_contact_is_in_the_log() -> None:
    log = skylimb.run("paper", controller="hybrid", set=SHORT).log
    touching = np.flatnonzero(log.contact.values[1:] > 0)
    gaps = json.loads(log.attrs["contact_gaps"])
    assert len(gaps) == np.count_nonzero(np.diff(touching) > 1)


def test_a_controller_without_a_state_machine_has_no_transitions() -> None:
    log = skylimb.run("paper", controller="hybrid", set=SHORT).log
    assert "contact_transitions" not in log.attrs
    assert "contact_state" not in log


def test_a_log_tells_what_happened_when_how_long_and_in_words() -> None:
    events = [
        {"kind": "push", "time": 0.5, "duration": 0.1, "force": [0.0, 0.3, 0.0], "link": "link2"},
        {"kind": "gain", "time": 0.6, "key": "attitude.damping_ratio", "value": [1.0, 1.0, 1.0]},
        {"kind": "surface", "time": 0.7, "friction": 0.2},
    ]
    log = skylimb.run("paper", controller="hybrid", set={**SHORT, "events": events, "stop_at": 1.0}).log
    told = json.loads(log.attrs["events"])
    assert [table | given for table, given in zip(told, events, strict=True)] == told
    assert [table["duration"] for table in told] == [0.1, 0.5, 0.2]
    assert [table["words"] for table in told] == [
        "0.3 N on link2",
        "attitude.damping_ratio to [1.0, 1.0, 1.0]",
        "surface friction to 0.2",
    ]
    without = skylimb.run("paper", controller="hybrid", set={**SHORT, "stop_at": 0.5}).log
    assert json.loads(without.attrs["events"]) == []


def test_units_of_the_configuration_stand_under_its_dotted_keys() -> None:
    experiment = skylimb.load_experiment("paper")
    controller = skylimb.load_controller("hybrid", skylimb.load_robot("hydrus_xi_quad"))
    units = config_units(experiment, controller)
    assert units["surface.slope"] == "rad"
    assert units["trajectory.speed"] == "m/s"
    assert units["plant.cog_offset"] == "m"
    assert "surface.friction" not in units
    assert json.loads(json.dumps(units)) == units
    of_experiment = {name for name in units if not name.startswith("controller.")}
    assert of_experiment <= {name for name, _, _ in rows_of(tables_of(experiment))}
    # Keys of the log's `config`, but for those that are not set.
    assert {name for name in of_experiment if name not in flatten(experiment)} == {
        "plant.foot",
        "plant.joint_stop_stiffness",
        "plant.peg",
        "stop_at",
        "surface_error",
        "surface.damping",
        "surface.motion_direction",
        "trajectory.brush",
        "trajectory.center",
        "trajectory.force",
        "wrap.radius",
    } & of_experiment


class NumpyController:
    name = "own"


def test_a_controller_of_ones_own_has_no_units() -> None:
    experiment = skylimb.load_experiment("paper")
    units = config_units(experiment, NumpyController())  # type: ignore[arg-type]
    assert not [name for name in units if name.startswith("controller.")]


def test_a_flight_that_is_ended_before_its_stop_was_not_stopped_by_it() -> None:
    flight = skylimb.begin("free_flight", "hybrid", set={"stop_at": 0.2})
    for _ in range(20):
        flight.tick()
    ended = flight.finish()
    assert ended.status == "FAILED"
    assert ended.cause.startswith("stopped from outside at t = ")  # as by Ctrl-C


def test_a_flight_that_its_experiment_stops_says_so() -> None:
    run = skylimb.run("free_flight", "hybrid", set={"stop_at": 0.2})
    assert run.status == "STOPPED"
    assert run.cause == "stopped by its experiment (stop_at) at t = 0.200 s, before the mission's end"
