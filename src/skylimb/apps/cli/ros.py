"""The verb `ros`: the lab's robot on ROS 1."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Annotated, Any, Literal

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Calibration, Fence, Settings, new_folder, settings_of, within


def ros(
    profile: Annotated[str, arg("simulator, controller or both.", "PROFILE")],
    *,
    robot: Annotated[str, arg("The robot, in place of the experiment's.", "NAME")] = "",
    controller: Annotated[
        str | None, arg("A controller's name, its TOML file, or a Python file.", "NAME")
    ] = None,
    experiment: Annotated[
        str, arg("Experiment of plant, surface and first mission: paper, for simulator free_flight.", "NAME")
    ] = "",
    mission: Annotated[
        tuple[str, ...], arg("Experiments whose missions may be flown besides it.", "NAME ...")
    ] = (),
    messages: Annotated[
        tuple[str, ...], arg("Folders of .msg files: the robot's own checkout.", "DIR ...")
    ] = (),
    namespace: Annotated[str, arg("Of the lab's topics.", "NAME")] = "hydrus_xi",
    link: Annotated[str, arg("Link of mocap/pose; by default the flight controller.", "LINK")] = "",
    config: Annotated[
        tuple[str, ...],
        arg("The robot's own files of motor_info, servo_controller and uav_model.", "YAML ..."),
    ] = (),
    cells: Annotated[int, arg("Cells of the battery in series.", "N")] = 6,
    anywhere: Annotated[bool, arg("Whether master and node may be on a network.")] = False,
    bare: Annotated[
        bool, arg("That the flight controller may hold no attitude; controller needs it.")
    ] = False,
    calibration: Calibration = None,
    fence: Fence = (),
    pad: Annotated[
        dict[str, Any] | None,
        arg("Other numbers of the radio's land, halt, yaw, up, left, forward.", "NAME=N ...", settings_of),
    ] = None,
    adopt: Annotated[
        Literal["land", "hover"],
        arg("What becomes of a robot that flies already when controller begins.", "land|hover"),
    ] = "land",
    check: Annotated[bool, arg("Look at everything before a flight, and command nothing.")] = False,
    start: Annotated[
        dict[str, Any] | None,
        arg("Joint angles with which simulator stands, rad.", "NAME=RAD ...", settings_of),
    ] = None,
    set: Settings = None,
    out: Annotated[str, arg("New folder for flights and missions; none by default.", "DIR")] = "",
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
    within("--cells", cells, 1, 20)
    folder = new_folder(out, "ros") if out else None
    from skylimb.analysis.exchange.recorder import recording
    from skylimb.apps.ros.run import limits_of, run, write
    from skylimb.apps.ros1.rim import ROS1

    limits = limits_of(fence, pad or {}, adopt)
    with recording(folder) if folder else nullcontext() as recorder:
        flown = run(
            ROS1,
            profile,
            robot=robot,
            experiment=experiment,
            missions=mission,
            controller=controller,
            settings=set,
            messages=messages,
            namespace=namespace,
            link=link,
            cells=cells,
            anywhere=anywhere,
            bare=bare,
            config=config,
            calibration=calibration,
            limits=limits,
            check=check,
            start=start,
            say=lambda words: print(words, flush=True),
            recorder=recorder,
        )
        if folder is not None and not check:
            with output.working("writing the results"):
                write(flown, folder)
    if check:
        raise SystemExit(1 if flown.failed else 0)
    print(flown.timing.verdict())
    for name, count in flown.faults.items():
        print(f"note: {name}: {count} times")
    if folder is not None:
        output.places(folder)
