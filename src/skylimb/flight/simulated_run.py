"""The run of a simulated flight: its log with the truth, its scores, and everything that produced it."""

from __future__ import annotations

import dataclasses
import json

from skylimb.analysis.notebook_run import Run
from skylimb.analysis.scores.user_scores import scored
from skylimb.base.config import to_mapping
from skylimb.control.loop.flight import Flight, flown_mission
from skylimb.control.missions.mission import Mission
from skylimb.flight.events import SurfaceChange
from skylimb.flight.flight_run import documented, flight_run
from skylimb.flight.reference_line import with_reference_line
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.compiling import compiler_version
from skylimb.simulation.flight_truth import flight_truth
from skylimb.simulation.joint_stops import leaning
from skylimb.simulation.user_plant import plant_name


def scored_run(takeoff: Takeoff, flight: Flight, mission: Mission | None = None) -> Run:
    """The run of a simulated flight with all that produced it and its scores; see `simulated_run`."""
    return scored(with_origin(simulated_run(takeoff, flight, mission), takeoff), takeoff.own)


def with_origin(run: Run, takeoff: Takeoff) -> Run:
    """A simulated run with configuration, versions and scene: what a record that is kept needs."""
    made_with = {"compiler": compiler_version()}
    own = takeoff.own_plant
    flew = [] if own is None else [f"plant '{plant_name(own)}' flew in place of MuJoCo"]
    notes = [*flew, *_moved(takeoff), *_leaning(run, takeoff)]
    return documented(run, takeoff, notes, made_with, takeoff.plant.scene)


def simulated_run(takeoff: Takeoff, flight: Flight, mission: Mission | None = None) -> Run:
    """The run of a simulated flight, with its truth and without scores.

    Args:
        takeoff: what was flown.
        flight: its raw record.
        mission: what was asked, where its user chose another than the plan's.
    """
    plan, plant = takeoff, takeoff.plant
    mission = flown_mission(mission or plan.mission, flight)
    truth = flight_truth(plant, flight, mission, takeoff.surface_table)
    attributes = {
        "contact_gaps": json.dumps(truth.gaps),
        "surface": json.dumps(plant.surface.describe()),
        "clearance": json.dumps(truth.clearance if mission.contact else None),
        "notes": json.dumps(flight.notes),
        "tolerances": json.dumps(to_mapping(plan.experiment.tolerances) if mission.contact else {}),
    }
    times = mission.times[: flight.ticks]
    run = flight_run(plan, truth.signals, times, flight.cause, attributes, frame=mission.frame)
    log = with_reference_line(run.log, plan.experiment.trajectory)
    return dataclasses.replace(run, log=log)


def _moved(takeoff: Takeoff) -> list[str]:
    """That the surface was elsewhere than figures draw it, and from when on."""
    changes = [one for one in takeoff.experiment.events if isinstance(one, SurfaceChange)]
    times = [one.time for one in changes if one.moves]
    if not times:
        return []
    return [
        f"the surface was moved or taken away in flight, from t = {min(times):g} s on: gap, trace and forces "
        "are those of where it was, figures and videos draw it where it was at take-off"
    ]


def _leaning(run: Run, takeoff: Takeoff) -> list[str]:
    """Which joints leaned on their stops: what they did there is the stops' doing."""
    robot = takeoff.robot
    shares = leaning(run.log.joint_angles.values, *robot.joint_limits(), robot.description.shape_joints)
    return [
        f"{name} leaned on the stop at its limit for {100.0 * share:.2g} % of the flight"
        for name, share in shares.items()
    ]
