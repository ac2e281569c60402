"""A flight as a run: its log, and everything that produced it.

Whoever flew, the run is made here: `flight_run` of any flight, `documented` with what only a record that is
kept needs. What is known of a simulated flight besides is in `flight.simulated_run`.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from skylimb.analysis.notebook_run import Run
from skylimb.analysis.recording.log import build_log
from skylimb.analysis.recording.origin import origin_text
from skylimb.analysis.recording.run import FAILED, OK, STOPPED, UNFINISHED
from skylimb.analysis.recording.versions import origin_versions, versions
from skylimb.base.config import put, to_mapping
from skylimb.base.keys import tables_of, units_of
from skylimb.base.signals import Signal
from skylimb.control import press
from skylimb.control.contact.machine import REASONS, STATES
from skylimb.control.controller import Controller, controller_signals, controller_units, resolved_tables
from skylimb.control.loop.flight import MISSION_TIME, held_back_cause, stopped_cause
from skylimb.control.missions.frame import ContactFrame, contact_frame
from skylimb.control.missions.mission import PHASES
from skylimb.flight.events import event_tables
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.plan import FlightPlan
from skylimb.flight.run_files import run_files

CONTACT_STATE, CONTACT_REASON = "contact_state", "contact_reason"
"""Signals of a controller whose contact law is a state machine."""

FLAGS = {"phase": PHASES, CONTACT_STATE: STATES, CONTACT_REASON: REASONS, "press_reason": press.REASONS}
"""Signals that count names."""


def flight_run(
    plan: FlightPlan,
    values: Mapping[str, np.ndarray],
    times: np.ndarray,
    cause: str = "",
    attributes: Mapping[str, Any] | None = None,
    declared: Mapping[str, Signal] | None = None,
    frame: ContactFrame | None = None,
) -> Run:
    """The run of any flight, simulated or real, without scores.

    Args:
        plan: what was flown.
        values: signals by name, the ticks first.
        times: of the ticks, s since take-off.
        cause: why the flight was lost, or empty.
        attributes: of the log, besides those that every log has.
        declared: what is said of signals that neither everybody knows nor the controller declares.
        frame: axes of the task, where its mission has others than the experiment.
    """
    experiment = plan.experiment
    frame = frame or contact_frame(experiment.contact_axis)
    name = plan.controller.name
    values = dict(values)
    for flag in FLAGS.keys() & values.keys():
        if flag != "phase":
            # Of a flight that diverged the last one may be no number.
            values[flag] = np.where(np.isfinite(values[flag]), values[flag], -1.0).astype(np.int8)
    status = _status(plan, cause, values, len(times))
    if status == STOPPED:
        at = len(times) * plan.mission.period
        cause = f"stopped by its experiment (stop_at) at t = {at:.3f} s, before the mission's end"
    said = {
        "robot": plan.robot.name,
        "experiment": experiment.name,
        "controller": name,
        "seed": experiment.seed,
        "status": status,
        "cause": cause,
        "contact_axis": frame.contact.tolist(),
        "sliding_axes": [*frame.sliding_u.tolist(), *frame.sliding_v.tolist()],
        "thrust_limits": json.dumps([list(map(float, side)) for side in plan.robot.thrust_limits()]),
        "path_center": json.dumps([float(x) for x in experiment.path_center]),
        "events": json.dumps(
            [
                {**table, "duration": event.duration, "words": event.words}
                for table, event in zip(event_tables(experiment.events), experiment.events, strict=True)
            ]
        ),
    }
    if experiment.wrap.radius is not None:
        said["wrap_radius"] = experiment.wrap.radius
    if CONTACT_STATE in values and CONTACT_REASON in values:
        transitions = contact_transitions(times, values[CONTACT_STATE], values[CONTACT_REASON])
        said["contact_transitions"] = json.dumps(transitions)
    known = {**controller_signals(plan.controller), **(declared or {})}
    log = build_log(values, times, plan.robot.description, known, FLAGS, {**said, **(attributes or {})})
    return Run(name=name, controller=name, log=log)


def _status(plan: FlightPlan, cause: str, values: Mapping[str, np.ndarray], ticks: int) -> str:
    """What became of a flight: one that was stopped (`stop_at`), or whose time was over, was not lost."""
    if not cause:
        return OK
    asked = plan.experiment.stop_at is not None and ticks >= plan.count  # and was not interrupted before
    if asked and cause == stopped_cause(ticks, plan.mission):
        return STOPPED
    at = values.get(MISSION_TIME, ())
    held_back = len(at) > 0 and cause == held_back_cause(float(at[-1]), plan.mission)
    return UNFINISHED if held_back else FAILED


def documented(
    run: Run,
    plan: FlightPlan,
    notes: Sequence[str] = (),
    made_with: Mapping[str, str] | None = None,
    scene: str = "",
) -> Run:
    """The run with all that produced it in its log: configuration and its units, versions, notes.

    Args:
        run: of a flight.
        plan: what was flown.
        notes: what has to be said of it besides its own, one line each.
        made_with: versions of what computed it, besides those of every run.
        scene: the simulated world as MJCF text; empty for a real one.
    """
    experiment, kept = plan.experiment.to_mapping(), run_files(plan)
    changes = experiment.pop("recorded", {}).get("changes", [])
    config = to_mapping({**experiment, "controller": resolved_tables(plan.controller)})
    for key, place in kept.places.items():
        put(config, key, place)
    with_versions = {**origin_versions(), **(made_with or {})}
    said = [*changes, *run.notes, *notes, *(f"this run cannot be repeated: {line}" for line in kept.problems)]
    log = run.log.assign_attrs(
        config=origin_text(config, kept.files, with_versions, kept.problems, kept.used),
        config_units=json.dumps(config_units(plan.experiment, plan.controller)),
        versions=json.dumps(versions()),
        notes=json.dumps(said),
        **({"scene": scene} if scene else {}),
    )
    return dataclasses.replace(run, log=log, sources=kept.files)


def contact_transitions(
    times: np.ndarray, state: np.ndarray, reason: np.ndarray
) -> list[tuple[float, str, str, str]]:
    """Every change of the contact's state: when (s), from which state, to which, and why, in words.

    Args:
        times: of the ticks, (k,).
        state: index of `STATES` at every tick, (k,).
        reason: index of `REASONS` of the last change, (k,).
    """
    changed = np.flatnonzero(np.diff(state)) + 1
    return [
        (
            round(float(times[k]), 6),
            _word(STATES, state[k - 1]),
            _word(STATES, state[k]),
            _word(REASONS, reason[k]),
        )
        for k in changed
    ]


def _word(names: tuple[str, ...], index: float) -> str:
    """The name of that number; the number itself where a user's own law counts otherwise."""
    return names[int(index)] if 0.0 <= index < len(names) else f"{index:g}"


def config_units(experiment: Experiment, controller: Controller) -> dict[str, str]:
    """Unit of every value in a run's configuration that has one, by dotted key."""
    gains = controller_units(controller)
    return {
        **units_of(tables_of(experiment)),
        **{f"controller.{key}": unit for key, unit in gains.items()},
    }
