"""The verb that writes a log for other tools: `convert`."""

from __future__ import annotations

from typing import Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Log


def salvage(
    source: Annotated[str, arg("A .bag or .mcap file that was cut off, or has no index.", "FILE")],
    target: Annotated[str, arg("New file: .bag or .mcap.", "OUT")],
) -> None:
    """Write what can still be read of a damaged bag or MCAP file as a whole file, with an index.

    Every topic is kept, to the byte, up to the last whole chunk before the cut, or before damage; until when
    is said. No ROS is needed.

    Examples:
        skylimb salvage out/ros-interrupted/01-flight.mcap flight.mcap
        skylimb salvage lab.bag.active lab.bag
    """
    from skylimb.analysis.exchange import convert as conversion

    with output.working("reading what is left"):
        count = conversion.salvage(source, target)
    print(f"{count} messages")
    print(f"  {target}")


def convert(
    log: Log,
    target: Annotated[str, arg("New file: .nc, .bag or .mcap.", "OUT")],
    *,
    robot: Annotated[str, arg("The robot that flew; by default the one that the log names.", "NAME")] = "",
    link: Annotated[
        str, arg("The link whose pose mocap/pose shows; by default the flight controller.", "LINK")
    ] = "",
    namespace: Annotated[str, arg("Of the lab's topics.", "NAME")] = "hydrus_xi",
    ros2: Annotated[bool, arg("Whether OUT.mcap holds messages of ROS 2, as `ros2 bag` reads them.")] = False,
    layouts: Annotated[bool, arg("Whether to write layouts for Foxglove and PlotJuggler beside it.")] = False,
) -> None:
    """Write a log as NetCDF, as a ROS 1 bag, or as MCAP for Foxglove, PlotJuggler and Rerun.

    The ending says which: .nc, .bag, .mcap. Bags and MCAP files hold the lab's topics, and beside them the
    whole run, so that it comes back to the bit. Of a bag that the lab recorded, what its topics hold becomes
    a log. What one format cannot hold is said. No ROS is needed.

    Examples:
        skylimb convert out/hybrid flight.mcap --layouts
        skylimb convert out/hybrid flight.mcap --ros2
        skylimb convert flight.bag flight.nc
        skylimb convert real.bag real.nc --robot my_robot --link link1
    """
    from skylimb.analysis.exchange import convert as conversion
    from skylimb.analysis.exchange.layouts import require_layouts, write_layouts

    if layouts:
        require_layouts(target)
    with output.working("converting"):
        notes = conversion.convert(log, target, robot, link, namespace, ros2)
    output.notes(notes)
    print(f"  {target}")
    for path in write_layouts(target, namespace) if layouts else ():
        print(f"  {path}")
