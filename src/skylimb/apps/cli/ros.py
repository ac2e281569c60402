"""The verbs `ros` and `ros2`: the lab's robot on ROS 1, and the same on ROS 2."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Calibration, Fence, Settings, assignments_of, new_folder, within
from skylimb.base.aside import said_aside

if TYPE_CHECKING:
    from skylimb.apps.ros.bridge import Middleware
    from skylimb.apps.ros.node_config import NodeConfig

_Profile = Annotated[str, arg("simulator, controller or both.", "PROFILE")]


@dataclass(frozen=True, kw_only=True)
class NodeOptions:
    """What a node is given on any ROS."""

    robot: Annotated[str, arg("The robot, in place of the experiment's.", "NAME")] = ""
    controller: Annotated[
        str | None, arg("A controller's name, its TOML file, or a Python file.", "NAME")
    ] = None
    experiment: Annotated[
        str,
        arg("Experiment of plant, surface and first mission: paper, for simulator free_flight.", "NAME"),
    ] = ""
    mission: Annotated[
        tuple[str, ...], arg("Experiments whose missions may be flown besides it.", "NAME ...")
    ] = ()
    cells: Annotated[int, arg("Cells of the battery in series; 0 where nobody tells its voltage.", "N")] = 6
    bare: Annotated[bool, arg("That thrusts go around the flight controller; controller needs it.")] = False
    calibration: Calibration = None
    fence: Fence = None
    pad: Annotated[
        dict[str, Any] | None,
        arg(
            "Other numbers of the radio's land, halt, yaw, up, left, forward.",
            "NAME=N ...",
            assignments_of("--pad", "land=4"),
        ),
    ] = None
    adopt: Annotated[
        Literal["land", "hover"],
        arg("What becomes of a robot that flies already when controller begins.", "land|hover"),
    ] = "land"
    check: Annotated[bool, arg("Look at everything before a flight, and command nothing.")] = False
    start: Annotated[
        dict[str, Any] | None,
        arg(
            "Joint angles with which simulator stands, rad.",
            "NAME=RAD ...",
            assignments_of("--start", "joint1=0.5"),
        ),
    ] = None
    set: Settings = None
    out: Annotated[str, arg("New folder for flights and missions; none by default.", "DIR")] = ""


def ros(
    profile: _Profile,
    *,
    options: NodeOptions = NodeOptions(),
    messages: Annotated[
        tuple[str, ...], arg("Folders of .msg files: the robot's own checkout.", "DIR ...")
    ] = (),
    namespace: Annotated[str, arg("Of the lab's topics.", "NAME")] = "hydrus_xi",
    link: Annotated[str, arg("Link of mocap/pose; by default the flight controller.", "LINK")] = "",
    config: Annotated[
        tuple[str, ...],
        arg("The robot's own files of motor_info, servo_controller and uav_model.", "YAML ..."),
    ] = (),
    anywhere: Annotated[bool, arg("Whether master and node may be on a network.")] = False,
) -> int:
    """Be a node on ROS 1: the lab's robot simulated, our controller for its robot, or both.

    PROFILE is simulator (our plant under the lab's own stack), controller (our controller for a robot or for
    simulator), or both (a robot to develop clients against). Flight states, topics and time-outs are the
    lab's. A mission is flown from hover, by its name on the topic skylimb/mission. Ctrl-C lands first.

    Examples:
        skylimb ros both --controller hybrid --messages ~/jsk_aerial_robot
        skylimb ros both --experiment paper --mission my_drawing.toml --out out/ros
        skylimb ros simulator --messages ~/jsk_aerial_robot
        skylimb ros controller --controller hybrid --messages ~/jsk_aerial_robot --bare
        skylimb ros controller --controller hybrid --messages ~/jsk_aerial_robot --bare --check
    """
    from skylimb.apps.ros1.middleware import ROS1

    own = {"messages": messages, "link": link, "lab_files": config}
    return _be(ROS1, profile, options, namespace=namespace, anywhere=anywhere, **own)


def ros2(
    profile: _Profile,
    *,
    options: NodeOptions = NodeOptions(),
    namespace: Annotated[str, arg("Of the topics.", "NAME")] = "skylimb",
    anywhere: Annotated[bool, arg("Whether it may be heard beyond this machine.")] = False,
) -> int:
    """Be a node on ROS 2, also without ROS installed: a simulated robot, our controller for a robot, or both.

    PROFILE is as of `skylimb ros`. Flight states, supervisor and recorder are the same; messages, frames and
    quality of service are ROS 2's. The domain is ROS_DOMAIN_ID. Ctrl-C lands first.

    Examples:
        skylimb ros2 both --controller hybrid
        skylimb ros2 simulator
        skylimb ros2 controller --controller hybrid --bare
    """
    from skylimb.apps.ros2.middleware import ROS2

    return _be(ROS2, profile, options, namespace=namespace, anywhere=anywhere)


def _asked(profile: str, options: NodeOptions, **own: Any) -> NodeConfig:
    """What a node is asked to be; the battery of a simulated one has cells."""
    from skylimb.apps.ros.node_config import NodeConfig
    from skylimb.apps.ros.run import limits_of

    within("--cells", options.cells, 1 if profile == "simulator" else 0, 20)
    return NodeConfig(
        profile,
        robot=options.robot,
        experiment=options.experiment,
        missions=options.mission,
        controller=options.controller,
        settings=options.set or {},
        cells=options.cells,
        bare=options.bare,
        calibration=options.calibration,
        limits=limits_of(options.fence, options.pad or {}, options.adopt),
        check=options.check,
        start=options.start or {},
        **own,
    )


def _be(middleware: Middleware, profile: str, options: NodeOptions, **own: Any) -> int:
    """Be a node until it ends, keep what it flew, and say how it went; 1 where it failed."""
    config = _asked(profile, options, **own)
    folder = new_folder(options.out, "ros") if options.out else None
    from skylimb.analysis.exchange.recorder import recording
    from skylimb.apps.ros.run import run, write

    # Also what is said after it: a terminal that has gone costs no flight that was flown.
    with said_aside(patience=None), recording(folder) if folder else nullcontext() as recorder:
        flown = run(middleware, config, lambda words: print(words, flush=True), recorder)
        if folder is not None and not config.check:
            with output.working("writing the results"):
                write(flown, folder)
    if config.check:
        output.faults(flown.faults)  # why something is not known
        return int(bool(flown.failed))
    print(flown.timing.verdict())
    output.faults(flown.faults)
    if folder is not None:
        output.places(folder)
    return int(bool(flown.broken))
