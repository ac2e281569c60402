"""From words on a command line to a node that flies: all is checked before the middleware knows of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.frames import lab_link
from skylimb.analysis.exchange.recorder import FlightRecorder
from skylimb.apps.ros.both import Both
from skylimb.apps.ros.bridge import Bridge, Middleware
from skylimb.apps.ros.controlled import Controlled
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.lab_config import LabConfig, read_lab_config
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.node import Node, Profile
from skylimb.apps.ros.node_config import WARNING, NodeConfig
from skylimb.apps.ros.pad import Pad
from skylimb.apps.ros.profile import PendingRun
from skylimb.apps.ros.simulated import Simulated
from skylimb.apps.ros.tick import STARTED_BY_ITS_USER
from skylimb.base.config import from_mapping
from skylimb.base.errors import ConfigError
from skylimb.base.files import new_folder
from skylimb.control.missions.mission import Mission
from skylimb.control.supervisor.descents import unprotected
from skylimb.flight.events import require_applied
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.flyable import require_flyable
from skylimb.flight.loading import parted, plan_flights
from skylimb.flight.plan import FlightPlan, checked
from skylimb.flight.realtime.clocked_flight import compiled
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.preflight import LOOK, fence_of, preflight_facts
from skylimb.flight.realtime.timing import TIMING_FILE, Timing
from skylimb.flight.takeoff import simulated
from skylimb.robots.model import Robot

INNER_RATE = 1000.0
"""Hz, of the flight controller's inner loop, which `simulator` runs."""

UNKNOWN_MOTORS = (
    "controller: no motor_info is sent, and a flight controller that has none acknowledges no arming; "
    "--config names the robot's own file of it"
)


@dataclass(frozen=True)
class Flown:
    """What is left when a node has ended.

    Attributes:
        kept: flights and missions, in their order.
        timing: how the loop kept to the clock.
        faults: how often each was met, by name.
        failed: names of the checks that failed, where it only looked.
        broken: why the node ended by itself; empty where its user ended it.
    """

    kept: tuple[PendingRun, ...]
    timing: Timing
    faults: Mapping[str, int]
    failed: tuple[str, ...] = ()
    broken: str = ""


def run(
    middleware: Middleware,
    config: NodeConfig,
    say: Callable[[str], None] = print,
    recorder: FlightRecorder | None = None,
) -> Flown:
    """Be a node until it is shut down.

    Args:
        middleware: ROS 1 or ROS 2.
        config: what it is asked to be.
        say: takes what people are to read.
        recorder: keeps flights on the disk as they are flown.

    Raises:
        SkylimbError: before anything is published, where the middleware, a message or a name is missing.
    """
    middleware.require(config.anywhere)
    plan, pacer = _planned(config)
    missions = missions_of(plan, config.missions)
    lab = read_lab_config(config.lab_files, plan.robot)
    servos = lab.servos is not None
    topics = middleware.dialect.topics(config.profile, servos)
    middleware.reach(config.profile, topics, config.namespace)
    profile = _profile(middleware, config, plan, missions, lab, pacer)
    middleware.say_left_out(config.profile, (*topics.subscribed, *topics.published), config.messages, say)
    if config.profile == "controller":
        say(WARNING)
        for words in () if middleware.dialect.known(plan.robot.n_rotors) else _doubts(lab, plan.robot):
            say(words)
        if not config.check:
            say(_bends(plan))
    bridge = Bridge(
        middleware.package, config.profile, config.messages, config.namespace, servos, config.anywhere
    )
    bridge.carry(middleware.opening(plan))
    try:
        node = Node(profile, bridge, pacer, say, recorder=recorder)
        below = f"{plan.robot.name} below /{config.namespace.strip('/')}"
        say(f"{config.profile}: {below}, missions {', '.join(missions)}")
        found = node.look(LOOK) if config.check else node.spin()
    finally:
        bridge.close()
    for one in found or ():
        say(one.line)
    failed = tuple(one.name for one in found or () if not one.fine)
    return Flown(tuple(profile.kept), node.timing, dict(node.faults), failed, node.broken)


def _planned(config: NodeConfig) -> tuple[FlightPlan, Pacer]:
    """What is flown, and the clock of its ticks; `simulator` runs an inner loop within them."""
    keys = config.keys
    period = load_experiment(config.experiment_name, parted(keys)[0]).control_period
    if config.profile == "simulator":
        keys["controller_rate"] = INNER_RATE
    (plan,) = plan_flights(
        config.experiment_name, (config.controller,), set=keys, calibration=config.calibration
    )
    require_applied(plan.experiment.events, (), STARTED_BY_ITS_USER)
    return plan, Pacer(period)


def _profile(
    middleware: Middleware,
    config: NodeConfig,
    plan: FlightPlan,
    missions: Mapping[str, Mission],
    lab: LabConfig,
    pacer: Pacer,
) -> Profile:
    """What stands behind the topics: a robot, who flies it, or both."""
    link = lab_link(plan.robot, config.link)
    if config.profile == "simulator":
        slows, speech = middleware.by_clock(), middleware.dialect
        return Simulated(simulated(plan), link, pacer, config.cells, lab.servos, config.start, slows, speech)
    supervisor = plan.experiment.supervisor
    told = unprotected(plan.robot, plan.needs.vectoring, supervisor)
    flyer = Flyer(
        plan,
        compiled(plan, tells=True),
        missions,
        link,
        pacer,
        config.cells,
        config.limits,
        supervisor,
        namespace=config.namespace,
        facts=preflight_facts(
            plan.robot, middleware.described_mass(config.namespace), config.calibration, told
        ),
        dialect=middleware.dialect,
    )
    return Both(simulated(plan), flyer) if config.profile == "both" else Controlled(flyer, lab)


def limits_of(fence: Sequence[float] | None, pad: Mapping[str, Any], adopt: str) -> FlightLimits:
    """The limits of a flight whose user says some of them.

    Args:
        fence: least and greatest x, y and z of the centre of gravity, W, m; None for a large one.
        pad: buttons and axes of the radio by name.
        adopt: what becomes of a flight that somebody else began.

    Raises:
        ConfigError: where one of them cannot be.
    """
    limits = FlightLimits(adopt=adopt, pad=from_mapping(Pad, pad, "--pad"))
    return limits if fence is None else replace(limits, fence=fence_of(fence))


def write(flown: Flown, folder: Path) -> list[Path]:
    """Flights and missions below a new folder, and how the loop kept to the clock."""
    from skylimb.analysis import write_run

    places = []
    with new_folder(folder) as aside:
        for count, kept in enumerate(flown.kept, 1):
            path = aside / f"{count:02d}-{kept.name}"
            run = kept.run()
            if kept.name == "flight":
                run.save(path.with_suffix(".nc"))
                places.append(folder / f"{path.name}.nc")
            else:
                write_run(run, path)
                places.append(folder / path.name)
        (aside / TIMING_FILE).write_text(flown.timing.record(flown.faults), encoding="utf-8")
    return places


def missions_of(plan: FlightPlan, more: Sequence[str]) -> dict[str, Mission]:
    """The missions that can be flown, the plan's and those of more experiments, by their names."""
    found = {plan.experiment.name: plan.mission}
    for name in more:
        experiment = load_experiment(name, {"robot": plan.experiment.robot})
        if experiment.control_period != plan.period:
            raise ConfigError(
                f"mission '{experiment.name}' is at {experiment.controller_rate:g} Hz, the node at "
                f"{1.0 / plan.period:g} Hz"
            )
        other = checked(FlightPlan(experiment, plan.robot, plan.controller))
        require_flyable(plan.experiment.surface, plan.robot, other.mission)
        found[experiment.name] = other.mission
    return found


def _bends(plan: FlightPlan) -> str:
    """What a robot's servos do as soon as a node begins, before anybody has ordered anything."""
    angles = ", ".join(f"{angle:.2f}" for angle in plan.mission.first.joint_angles)
    return f"controller: the joints go to ({angles}) rad now, at their servos' own speed: hands off"


def _doubts(config: LabConfig, robot: Robot) -> list[str]:
    """What a user should know of the motors before the first flight, one line each."""
    if config.motors is None:
        return [UNKNOWN_MOTORS]
    doubts, lands = list[str](), config.motors.force_landing_thrust
    if lands * robot.n_rotors >= robot.weight:
        doubts.append(
            f"controller: a forced landing ends with {lands:g} N a rotor (force_landing_thrust), and "
            f"{robot.weight / robot.n_rotors:.3g} N carry {robot.name}: it does not bring it down"
        )
    least = min(motor.max_thrust for motor in config.motors.motors)
    most = float(robot.thrust_limits()[1].max())
    if most <= least:
        return doubts
    return [
        *doubts,
        f"controller: commands go up to {most:g} N a rotor, motor_info says {least:g} N at its lowest "
        "voltage; beyond that the flight controller lowers all thrusts alike",
    ]
