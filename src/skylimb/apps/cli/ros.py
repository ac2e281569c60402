"""The verb `ros`: the lab's robot on ROS 1."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import Positional, arg
from skylimb.apps.cli.options import Assignments, new_folder, settings_of, whole_number
from skylimb.base.errors import ConfigError


@dataclass(frozen=True)
class Ros:
    """Be a node on ROS 1: the lab's robot simulated, our controller for its robot, or both.

    PROFILE is simulator (our plant under the lab's own stack), controller (our controller for a robot or for
    simulator), or both (a robot to develop clients against). Flight states, topics and time-outs are the
    lab's. A mission is flown from hover, by its name on the topic skylimb/mission. Ctrl-C lands first.
    """

    examples: ClassVar[str] = """
        skylimb ros both --controller hybrid --messages ~/jsk_aerial_robot
        skylimb ros both --experiment paper --mission my_drawing.toml --out out/ros
        skylimb ros simulator --messages ~/jsk_aerial_robot
        skylimb ros controller --controller hybrid --messages ~/jsk_aerial_robot --bare
    """

    profile: Annotated[Positional[str], arg(metavar="PROFILE", help="simulator, controller or both.")]
    robot: Annotated[str, arg(metavar="NAME", help="The robot, in place of the experiment's.")] = ""
    controller: Annotated[
        str, arg(metavar="NAME", help="A controller's name, its TOML file, or a Python file.")
    ] = ""
    experiment: Annotated[
        str, arg(metavar="NAME", help="Experiment of plant, surface and the first mission.")
    ] = "paper"
    mission: Annotated[
        tuple[str, ...], arg(metavar="NAME ...", help="Experiments whose missions may be flown besides it.")
    ] = ()
    messages: Annotated[
        tuple[str, ...], arg(metavar="DIR ...", help="Folders of .msg files: the robot's own checkout.")
    ] = ()
    namespace: Annotated[str, arg(metavar="NAME", help="Of the lab's topics.")] = "hydrus_xi"
    link: Annotated[
        str, arg(metavar="LINK", help="Link of mocap/pose; by default the flight controller.")
    ] = ""
    config: Annotated[
        tuple[str, ...],
        arg(metavar="YAML ...", help="The robot's own files of motor_info, servo_controller and uav_model."),
    ] = ()
    cells: Annotated[str, arg(metavar="N", help="Cells of the battery in series.")] = "6"
    anywhere: Annotated[bool, arg(help="Whether master and node may be on a network.")] = False
    bare: Annotated[
        bool, arg(help="That the flight controller may hold no attitude; controller needs it.")
    ] = False
    set: Assignments = ()
    out: Annotated[str, arg(metavar="DIR", help="New folder for flights and missions; none by default.")] = ""

    def __call__(self) -> int:
        """Fly until the node is shut down."""
        cells = whole_number("--cells", self.cells) or 6
        if not 1 <= cells <= 20:
            raise ConfigError(f"--cells = {cells} is outside of 1 .. 20")
        folder: Path | None = new_folder(self.out, "ros") if self.out else None
        from skylimb.apps.ros1.run import Options, run, write

        flown = run(
            Options(
                self.profile,
                self.robot,
                self.experiment,
                self.mission,
                self.controller or None,
                settings_of(self.set),
                self.messages,
                self.namespace,
                self.link,
                cells,
                self.anywhere,
                self.bare,
                self.config,
            ),
            lambda words: print(words, flush=True),
        )
        print(flown.timing.verdict())
        for name, count in flown.faults.items():
            print(f"note: {name}: {count} times")
        if folder is not None:
            with output.working("writing the results"):
                write(flown, folder)
            output.places(folder)
        return 0
