"""The verb that writes a log for other tools: `convert`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import Positional, arg


@dataclass(frozen=True)
class Convert:
    """Write a log as NetCDF, as a ROS 1 bag, or as MCAP for Foxglove, PlotJuggler and Rerun.

    The ending says which: .nc, .bag, .mcap. Bags and MCAP files hold the lab's topics, and beside them the
    whole run, so that it comes back to the bit. Of a bag that the lab recorded, what its topics hold becomes
    a log. What one format cannot hold is said. No ROS is needed.
    """

    examples: ClassVar[str] = """
        skylimb convert out/hybrid flight.mcap --layouts
        skylimb convert flight.bag flight.nc
        skylimb convert real.bag real.nc --robot my_robot --link link1
    """

    log: Annotated[Positional[str], arg(metavar="LOG", help="A run's folder, or a .nc, .bag or .mcap file.")]
    target: Annotated[Positional[str], arg(metavar="OUT", help="New file: .nc, .bag or .mcap.")]
    robot: Annotated[
        str, arg(metavar="NAME", help="The robot that flew; by default the one that the log names.")
    ] = ""
    link: Annotated[
        str,
        arg(metavar="LINK", help="The link whose pose mocap/pose shows; by default the flight controller."),
    ] = ""
    namespace: Annotated[str, arg(metavar="NAME", help="Of the lab's topics.")] = "hydrus_xi"
    layouts: Annotated[bool, arg(help="Whether to write layouts for Foxglove and PlotJuggler beside it.")] = (
        False
    )

    def __call__(self) -> int:
        """Read, write, say what is lost."""
        from skylimb.analysis.exchange.convert import convert
        from skylimb.analysis.exchange.layouts import require_layouts, write_layouts

        if self.layouts:
            require_layouts(self.target)
        with output.working("converting"):
            notes = convert(self.log, self.target, self.robot, self.link, self.namespace)
        for note in notes:
            print(f"note: {note}")
        print(f"  {self.target}")
        for path in write_layouts(self.target, self.namespace) if self.layouts else ():
            print(f"  {path}")
        return 0
