"""The verbs `ros` and `ros2`: the lab's robot on ROS 1, and the same on ROS 2."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from typing import TYPE_CHECKING, Annotated, Any, Literal

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Calibration, Fence, Settings, assignments_of, new_folder, within
from skylimb.base.aside import said_aside

if TYPE_CHECKING:
    from skylimb.apps.ros.bridge import Rim
    from skylimb.apps.ros.limits import FlightLimits
    from skylimb.apps.ros.node_config import NodeConfig

_Profile = Annotated[str, arg("simulator, controller or both.", "PROFILE")]
_Robot = Annotated[str, arg("The robot, in place of the experiment's.", "NAME")]
_Controller = Annotated[str | None, arg("A controller's name, its TOML file, or a Python file.", "NAME")]
_Experiment = Annotated[
    str, arg("Experiment of plant, surface and first mission: paper, for simulator free_flight.", "NAME")
]
_Missions = Annotated[tuple[str, ...], arg("Experiments whose missions may be flown besides it.", "NAME ...")]
_Cells = Annotated[int, arg("Cells of the battery in series; 0 where nobody tells its voltage.", "N")]
_Bare = Annotated[bool, arg("That the flight controller may hold no attitude; controller needs it.")]
_Pad = Annotated[
    dict[str, Any] | None,
    arg(
        "Other numbers of the radio's land, halt, yaw, up, left, forward.",
        "NAME=N ...",
        assignments_of("--pad", "land=4"),
    ),
]
_Adopt = Annotated[
    Literal["land", "hover"],
    arg("What becomes of a robot that flies already when controller begins.", "land|hover"),
]
_Check = Annotated[bool, arg("Look at everything before a flight, and command nothing.")]
_Start = Annotated[
    dict[str, Any] | None,
    arg(
        "Joint angles with which simulator stands, rad.",
        "NAME=RAD ...",
        assignments_of("--start", "joint1=0.5"),
    ),
]
_Out = Annotated[str, arg("New folder for flights and missions; none by default.", "DIR")]


def ros(
    profile: _Profile,
    *,
    robot: _Robot = "",
    controller: _Controller = None,
    experiment: _Experiment = "",
    mission: _Missions = (),
    messages: Annotated[
        tuple[str, ...], arg("Folders of .msg files: the robot's own checkout.", "DIR ...")
    ] = (),
    namespace: Annotated[str, arg("Of the lab's topics.", "NAME")] = "hydrus_xi",
    link: Annotated[str, arg("Link of mocap/pose; by default the flight controller.", "LINK")] = "",
    config: Annotated[
        tuple[str, ...],
        arg("The robot's own files of motor_info, servo_controller and uav_model.", "YAML ..."),
    ] = (),
    cells: _Cells = 6,
    anywhere: Annotated[bool, arg("Whether master and node may be on a network.")] = False,
    bare: _Bare = False,
    calibration: Calibration = None,
    fence: Fence = (),
    pad: _Pad = None,
    adopt: _Adopt = "land",
    check: _Check = False,
    start: _Start = None,
    set: Settings = None,
    out: _Out = "",
) -> None:
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
    from skylimb.apps.ros.node_config import NodeConfig
    from skylimb.apps.ros1.rim import ROS1

    asked = NodeConfig(
        profile,
        robot=robot,
        experiment=experiment,
        missions=mission,
        controller=controller,
        settings=set or {},
        messages=messages,
        link=link,
        lab_files=config,
        namespace=namespace,
        cells=_cells(profile, cells),
        anywhere=anywhere,
        bare=bare,
        calibration=calibration,
        limits=_limits(fence, pad, adopt),
        check=check,
        start=start or {},
    )
    _be(ROS1, asked, out)


def ros2(
    profile: _Profile,
    *,
    robot: _Robot = "",
    controller: _Controller = None,
    experiment: _Experiment = "",
    mission: _Missions = (),
    namespace: Annotated[str, arg("Of the topics.", "NAME")] = "skylimb",
    cells: _Cells = 6,
    anywhere: Annotated[bool, arg("Whether it may be heard beyond this machine.")] = False,
    bare: _Bare = False,
    calibration: Calibration = None,
    fence: Fence = (),
    pad: _Pad = None,
    adopt: _Adopt = "land",
    check: _Check = False,
    start: _Start = None,
    set: Settings = None,
    out: _Out = "",
) -> None:
    """Be a node on ROS 2, where none need be installed: a robot simulated, our controller for one, or both.

    PROFILE is as of `skylimb ros`. Flight states, supervisor and recorder are the same; messages, frames and
    quality of service are ROS 2's. The domain is ROS_DOMAIN_ID. Ctrl-C lands first.

    Examples:
        skylimb ros2 both --controller hybrid
        skylimb ros2 simulator
        skylimb ros2 controller --controller hybrid --bare
    """
    from skylimb.apps.ros.node_config import NodeConfig
    from skylimb.apps.ros2.rim import ROS2

    asked = NodeConfig(
        profile,
        robot=robot,
        experiment=experiment,
        missions=mission,
        controller=controller,
        settings=set or {},
        namespace=namespace,
        cells=_cells(profile, cells),
        anywhere=anywhere,
        bare=bare,
        calibration=calibration,
        limits=_limits(fence, pad, adopt),
        check=check,
        start=start or {},
    )
    _be(ROS2, asked, out)


def _cells(profile: str, cells: int) -> int:
    """Of the battery; a simulated one has some."""
    within("--cells", cells, 1 if profile == "simulator" else 0, 20)
    return cells


def _limits(fence: Sequence[float], pad: dict[str, Any] | None, adopt: str) -> FlightLimits:
    from skylimb.apps.ros.run import limits_of

    return limits_of(fence, pad or {}, adopt)


def _be(rim: Rim, config: NodeConfig, out: str) -> None:
    """Be a node until it ends, keep what it flew, and say how it went."""
    folder = new_folder(out, "ros") if out else None
    from skylimb.analysis.exchange.recorder import recording
    from skylimb.apps.ros.run import run, write

    # Also what is said after it: a terminal that has gone costs no flight that was flown.
    with said_aside(patience=None), recording(folder) if folder else nullcontext() as recorder:
        flown = run(rim, config, lambda words: print(words, flush=True), recorder)
        if folder is not None and not config.check:
            with output.working("writing the results"):
                write(flown, folder)
    if config.check:
        raise SystemExit(1 if flown.failed else 0)
    print(flown.timing.verdict())
    for name, count in flown.faults.items():
        print(f"note: {name}: {count} times")
    if folder is not None:
        output.places(folder)
