"""What a fault did is counted from its onset; a flight that was lost in its window has no such numbers."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.faults import BELIEVED, GONE, MODE, WINDOW
from skylimb.analysis.scores.registry import measured

TIME = 0.005 * np.arange(1200)
ONSET = 2.0


def log(events: list[dict[str, Any]], status: Any = "OK", **changes: Any) -> xr.Dataset:
    """A flight of six seconds that stands where it should but for what is changed."""
    still, q = np.zeros((len(TIME), 3)), np.tile([1.0, 0.0, 0.0, 0.0], (len(TIME), 1))
    places = ("cog_position", "tip_position", "cog_position_reference", "tip_position_reference")
    values: dict[str, Any] = {name: (("time", "axis"), changes.get(name, still)) for name in places}
    values["cog_velocity"] = ("time", "axis"), changes.get("cog_velocity", still)
    values["root_quaternion"] = ("time", "quaternion"), changes.get("root_quaternion", q)
    force = changes.get("contact_force_normal", np.ones(len(TIME)))
    values |= {"contact_force_normal": ("time", force), "phase": ("time", np.full(len(TIME), 4))}
    values["tilt"] = "time", changes.get("tilt", np.zeros(len(TIME)))
    values |= {name: ("time", changes[name]) for name in (MODE, GONE, *BELIEVED) if name in changes}
    found = xr.Dataset(values, {"time": TIME})
    found.phase.attrs = {"flag_values": [4], "flag_meanings": "slide"}
    told = [{"words": "", "duration": 0.0, **event} for event in events]
    found.attrs = {"status": status, "events": json.dumps(told), "contact_axis": "x"}
    return found


def numbers(flight: xr.Dataset, twin: xr.Dataset | None = None) -> dict[str, Any]:
    beside = None if twin is None else Run("", "", twin)
    found = measured(Run("", "", flight, twin=beside), ["faults"])
    return {name.removeprefix("fault_"): value for name, value in found.items()}


def step(at: float, size: list[float]) -> np.ndarray:
    return (TIME[:, None] >= at - 1e-9) * np.array(size)


PUSH = {"kind": "push", "time": ONSET, "duration": 0.5}


def test_what_is_counted_begins_with_the_fault_and_ends_after_it() -> None:
    apart, after = step(1.0, [5.0, 5.0, -5.0]) + step(4.1, [9.0, 9.0, -9.0]), step(2.5, [0.3, -0.2, -0.1])
    velocity = step(2.2, [0.0, 0.3, 0.4]) - step(2.4, [0.0, 0.3, 0.4])
    force = 1.0 + step(2.1, [3.0])[:, 0] - step(2.2, [3.0])[:, 0]
    tilted = np.array([np.cos(0.1), 0.0, np.sin(0.1), 0.0])
    q = np.where((TIME[:, None] > 3.0) & (TIME[:, None] < 3.1), tilted, [1.0, 0.0, 0.0, 0.0])
    places = {"cog_position": apart + after, "tip_position": apart + 2.0 * after}
    more = {"cog_velocity": velocity, "contact_force_normal": force, "root_quaternion": q}
    found = numbers(log([PUSH], **places, **more))
    wanted = {"tilt": 0.2, "sink": 0.1, "sideways": 0.2, "force": 4.0, "speed": 0.5}
    wanted["tip"] = 2.0 * np.sqrt(0.14)
    assert {key: found[key] for key in wanted} == pytest.approx(wanted)
    assert found["lasted"] == pytest.approx(TIME[-1] - ONSET)
    assert (found["seen"], found["alarms"]) == (None, None)


def test_a_flight_that_is_broken_off_is_held_to_the_reference_that_it_had() -> None:
    """The mission's reference goes on by itself: a robot that no longer follows it has not sunk."""
    rises = np.clip(TIME - 1.0, 0.0, None)[:, None] * np.array([0.0, 0.1, 0.1])
    places = {f"cog_position{end}": rises for end in ("", "_reference")}
    places["cog_position"] = np.minimum(rises, rises[TIME <= 2.5][-1])
    broken = numbers(log([PUSH], **places, **{MODE: 2.0 * step(2.5, [1.0])[:, 0]}))
    assert (broken["sink"], broken["sideways"]) == pytest.approx((0.0, 0.0))
    flown = numbers(log([PUSH], **places, **{MODE: np.zeros(len(TIME))}))
    assert flown["sink"] == pytest.approx(0.1 * (0.5 + WINDOW - 0.5), abs=1e-2)


def test_a_surface_that_goes_is_timed_and_the_tip_s_rush_after_it_measured() -> None:
    advance = np.clip(TIME - ONSET, 0.0, 0.5)[:, None] * np.array([0.12, 0.3, 0.0])
    found = numbers(log([PUSH], tip_position=advance, **{GONE: step(ONSET + 0.2, [0.6])[:, 0]}))
    assert (found["rush"], found["gone"]) == pytest.approx((0.12, 0.2))
    assert numbers(log([PUSH]))["gone"] is None


def test_the_reference_s_own_motion_is_no_fault() -> None:
    course = TIME[:, None] * np.array([0.0, 0.1, 0.1])
    moved = dict.fromkeys(("cog_position", "tip_position"), course)
    moved |= {f"{name}_reference": course for name in moved}
    found = numbers(log([PUSH], **moved))
    assert [found[key] for key in ("sink", "sideways", "tip")] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_what_the_same_flight_moves_without_its_events_does_not_count() -> None:
    wanders = {
        "tip_position": TIME[:, None] * [0.01, 0.0, 0.0],
        "cog_position": TIME[:, None] * [0.0, 0.02, -0.01],
    }
    thrown = {name: path + step(2.2, [0.0, 0.1, -0.1]) for name, path in wanders.items()}
    alone, beside = log([PUSH], **thrown), log([], **wanders)
    paired = numbers(alone, beside)
    wanted = {"sink": 0.1, "sideways": 0.1, "tip": 0.1 * np.sqrt(2.0)}
    assert {key: paired[key] for key in wanted} == pytest.approx(wanted)
    assert all(numbers(alone)[key] > wanted[key] for key in ("sink", "sideways"))
    # One that is lost by itself is nothing to compare with; one whose mission ends earlier is, until then.
    assert numbers(alone, log([], "FAILED", **wanders))["tip"] is None
    assert numbers(alone, beside.sel(time=slice(0.0, 3.0)))["tip"] == pytest.approx(wanted["tip"])


def test_the_tip_is_to_stay_on_a_surface_that_leans() -> None:
    course = TIME[:, None] * np.array([0.0, 0.1, 0.0])
    on_it = course + TIME[:, None] * np.array([0.1 * np.tan(0.3), 0.0, 0.0])
    flight = log([PUSH], tip_position=on_it, tip_position_reference=course)
    assert numbers(flight)["tip"] == pytest.approx(0.1 * np.tan(0.3) * 2.0, abs=1e-3)
    axes = {"origin": [0, 0, 0], "axis_u": [0, 1, 0], "axis_v": [0, 0, 1]}
    lean = {**axes, "normal": [-np.cos(0.3), np.sin(0.3), 0.0]}
    flight = flight.assign(contact=("time", np.ones(len(TIME)))).assign_attrs(surface=json.dumps(lean))
    assert numbers(flight)["tip"] == pytest.approx(0.0, abs=1e-12)


def test_a_flight_that_is_lost_in_the_window_tells_only_how_long_it_went_on() -> None:
    whole = log([PUSH], "FAILED")
    end = ONSET + PUSH["duration"] + WINDOW
    lost, outlived = (numbers(whole.sel(time=slice(0.0, at))) for at in (end - 0.1, end + 0.1))
    assert lost["tilt"] is None
    assert lost["lasted"] == pytest.approx(1.9, abs=0.006)
    assert outlived["tilt"] == 0.0


def test_a_flight_that_went_on_for_long_tells_of_a_fault_that_lasts() -> None:
    sunk = step(3.0, [0.0, 0.0, -0.3])
    whole = log([{**PUSH, "time": 0.5, "duration": 100.0}], "FAILED", cog_position=sunk)
    assert numbers(whole)["sink"] == pytest.approx(0.3)
    assert numbers(whole.sel(time=slice(0.0, 5.4)))["sink"] is None


@pytest.mark.parametrize(
    ("speed", "tilt", "acting", "landed"),
    [(0.3, 0.1, 1.0, True), (0.7, 0.1, 1.0, False), (0.3, 0.3, 1.0, False), (0.3, 0.1, 0.0, False)],
)
def test_what_the_supervisor_lands_is_not_lost(
    speed: float, tilt: float, acting: float, landed: bool
) -> None:
    velocity, still = step(0.0, [0.0, 0.0, -speed]), np.ones(len(TIME))
    more = {"cog_velocity": velocity, "tilt": tilt * still, MODE: acting * still}
    found = numbers(log([PUSH], "FAILED", **more).sel(time=slice(0.0, 3.0)))
    assert (found["landed"], found["speed"] is not None) == (landed, landed)


def test_without_an_event_all_of_the_flight_counts() -> None:
    sunk = step(0.1, [0.0, 0.0, -0.3])
    assert numbers(log([], cog_position=sunk))["sink"] == pytest.approx(0.3)
    assert numbers(log([], "FAILED", cog_position=sunk))["sink"] == pytest.approx(0.3)
    early = numbers(log([], "FAILED", cog_position=sunk).sel(time=slice(0.0, 4.9)))
    assert (early["sink"], early["lasted"]) == (None, pytest.approx(4.9))


def test_a_flight_that_is_lost_before_its_fault_tells_nothing_of_it() -> None:
    lost = log([{**PUSH, "time": 6.5}], "FAILED")
    assert {key for key, value in numbers(lost).items() if value is not None} == {"landed", "unnamed"}


def test_what_the_supervisor_does_before_a_fault_is_a_false_alarm() -> None:
    mode = np.where((TIME > 1.0) & (TIME < 1.1) | (TIME >= 2.25), 1.0, 0.0)
    found = numbers(log([PUSH], **{MODE: mode}))
    assert (found["seen"], found["alarms"]) == (pytest.approx(0.25, abs=0.006), 1.0)
    quiet = numbers(log([], **{MODE: mode}))
    assert (quiet["seen"], quiet["alarms"]) == (None, 2.0)


@pytest.mark.parametrize(
    ("status", "mode", "unnamed"),
    [
        ("FAILED", 1.0, 1.0),
        ("FAILED", 2.0, 0.0),
        ("FAILED", 4.0, 0.0),
        ("OK", 0.0, 0.0),
        ("UNFINISHED", 1.0, 0.0),
    ],
)
def test_a_loss_has_a_name_once_the_supervisor_has_broken_the_flight_off(
    status: str, mode: float, unnamed: float
) -> None:
    flight = log([PUSH], status, **{MODE: mode * step(2.5, [1.0])[:, 0]})
    assert numbers(flight)["unnamed"] == unnamed
    assert numbers(log([PUSH], status))["unnamed"] == float(status == "FAILED")


def test_commands_that_are_no_numbers_or_beyond_the_rotors_are_counted() -> None:
    low, high = [2.0, 2.0], [30.0, 30.0]
    flight = log([PUSH]).assign_attrs(thrust_limits=json.dumps([low, high]))
    thrusts = np.tile(np.array([2.0, 30.0], dtype=np.float32), (len(TIME), 1))
    flight["thrusts_command"] = ("time", "rotor"), thrusts
    flight["joint_angles_command"] = ("time", "joint"), np.zeros((len(TIME), 3))
    assert numbers(flight)["invalid"] == 0.0
    thrusts[[7, 8], [0, 1]] = 1.9, 30.1
    thrusts[9, 0] = flight["joint_angles_command"].values[9, 1] = np.nan
    flight["joint_angles_command"].values[11, 2] = np.inf
    assert numbers(flight)["invalid"] == 4.0
    assert numbers(log([PUSH]))["invalid"] is None


@pytest.mark.parametrize(("signal", "plain"), BELIEVED.items())
def test_what_is_believed_is_timed_to_half_of_what_it_comes_to(signal: str, plain: float) -> None:
    learnt = plain - 0.05 * np.clip((TIME - ONSET) / 0.4, 0.0, 1.0)
    assert numbers(log([PUSH], **{signal: learnt}))["believed"] == pytest.approx(0.2, abs=0.006)
    known, never = np.full(len(TIME), plain - 0.05), np.full(len(TIME), plain + 0.01)
    assert numbers(log([PUSH], **{signal: known}))["believed"] == pytest.approx(0.0, abs=0.006)
    assert numbers(log([PUSH], **{signal: never}))["believed"] is None
    assert numbers(log([PUSH]))["believed"] is None
