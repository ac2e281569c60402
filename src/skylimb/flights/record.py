"""A flight as a run: its log with everything that produced it, and its scores."""

from __future__ import annotations

import dataclasses
import json

from skylimb.analysis.metrics import metrics
from skylimb.config import put, to_mapping
from skylimb.control.controller import Controller, controller_signals, controller_units, resolved_tables
from skylimb.control.thrusts import thrust_limits
from skylimb.experiments.experiment import Experiment
from skylimb.flights.reference_line import with_reference_line
from skylimb.flights.sources import kept_sources
from skylimb.flights.takeoff import Takeoff
from skylimb.keys import tables_of, units_of
from skylimb.loop.flight import Flight
from skylimb.recording.origin import origin_text
from skylimb.recording.run import Run
from skylimb.recording.versions import origin_versions, versions
from skylimb.simulation.compiling import compiler_version
from skylimb.simulation.log import flight_log


def recorded(takeoff: Takeoff, flight: Flight) -> Run:
    """The run of a flight: log, scores, configuration, versions and scene."""
    return documented(scored(takeoff, flight), takeoff)


def scored(takeoff: Takeoff, flight: Flight) -> Run:
    """The run of a flight with its scores; `documented` adds what only a record that is kept needs."""
    experiment, plant, mission = takeoff.experiment, takeoff.plant, takeoff.mission
    log = with_reference_line(
        flight_log(plant, flight, mission, controller_signals(takeoff.controller), takeoff.surface_table),
        experiment.trajectory,
    )
    frame, name = mission.frame, takeoff.controller.name
    log.attrs |= {
        "robot": takeoff.robot.name,
        "experiment": experiment.name,
        "controller": name,
        "seed": experiment.seed,
        "status": "FAILED" if flight.cause else "OK",
        "cause": flight.cause,
        "surface": json.dumps(plant.surface.describe()),
        "contact_axis": frame.contact.tolist(),
        "sliding_axes": [*frame.sliding_u.tolist(), *frame.sliding_v.tolist()],
        "thrust_limits": json.dumps([list(map(float, side)) for side in thrust_limits(takeoff.robot)]),
        "tolerances": json.dumps(to_mapping(experiment.tolerances) if mission.contact else {}),
        "path_center": json.dumps([float(x) for x in experiment.path_center]),
    }
    return Run(name=name, controller=name, log=log, metrics=metrics(log))


def documented(run: Run, takeoff: Takeoff) -> Run:
    """The run with all that produced it in its log: configuration and its units, versions and scene."""
    experiment, kept = takeoff.experiment.to_mapping(), kept_sources(takeoff)
    changes = experiment.pop("recorded", {}).get("changes", [])
    config = to_mapping({**experiment, "controller": resolved_tables(takeoff.controller)})
    for key, place in kept.places.items():
        put(config, key, place)
    made_with = {**origin_versions(), "compiler": compiler_version()}
    log = run.log.assign_attrs(
        config=origin_text(config, kept.files, made_with, kept.problems, kept.used),
        config_units=json.dumps(config_units(takeoff.experiment, takeoff.controller)),
        versions=json.dumps(versions()),
        scene=takeoff.plant.scene,
        notes=json.dumps(
            [
                *changes,
                *_moved(takeoff.experiment),
                *(f"this run cannot be repeated: {line}" for line in kept.problems),
            ]
        ),
    )
    return dataclasses.replace(run, log=log, sources=kept.files)


def _moved(experiment: Experiment) -> list[str]:
    """That the surface was elsewhere than figures draw it, and from when on."""
    times = [one.time for one in experiment.surface_changes if one.moves or one.present is not None]
    if not times:
        return []
    return [
        f"the surface was moved or taken away in flight, from t = {min(times):g} s on: gap, trace and forces "
        "are those of where it was, figures and videos draw it where it was at take-off"
    ]


def config_units(experiment: Experiment, controller: Controller) -> dict[str, str]:
    """Unit of every value in a run's configuration that has one, by dotted key."""
    gains = controller_units(controller)
    return {
        **units_of(tables_of(experiment)),
        **{f"controller.{key}": unit for key, unit in gains.items()},
    }
