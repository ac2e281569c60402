"""`skylimb convert`: a log in one format out of another."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

from skylimb.analysis.exchange.containers import CONTAINERS, container_of, ending_of
from skylimb.analysis.exchange.frames import lab_link
from skylimb.analysis.exchange.from_run import messages_of, topics_of
from skylimb.analysis.exchange.lab_topics import IN_LOGS, NAMESPACE, require_namespace
from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.ros2_types import Ros2Types
from skylimb.analysis.exchange.run_topics import row_names
from skylimb.analysis.exchange.stream import Raw, decoded, encoder
from skylimb.analysis.exchange.to_run import Read, run_from
from skylimb.analysis.recording.run import Run
from skylimb.base.errors import ConfigError, OutputError
from skylimb.base.files import require_new
from skylimb.robots.loader import load_robot

ROBOT = "hydrus_xi_quad"


def read_log(path: str | Path, robot: str = "", link: str = "") -> Read:
    """A run from a folder, a NetCDF file, a bag or an MCAP file, and what has to be said of it.

    Args:
        path: of the log.
        robot: that flew, where the log does not say; hydrus_xi_quad by default.
        link: whose pose the lab's topics show; the flight controller's by default.

    Raises:
        OutputError: when it cannot be read, or there is no flight in it.
        MissingExtraError: for a bag or an MCAP file without the extra `logs`.
    """
    path = Path(path)
    if path.suffix not in CONTAINERS:
        return Read(Run.load(path), ())
    with container_of(path).read(path) as messages:
        return run_from(
            decoded(_some(messages, path)),
            lambda: load_robot(robot or ROBOT),
            path.stem,
            lambda model: lab_link(model, link),
        )


def write_log(
    run: Run,
    path: str | Path,
    robot: str = "",
    link: str = "",
    namespace: str = NAMESPACE,
    ros2: bool = False,
) -> tuple[str, ...]:
    """Write a run as the file that its ending names.

    Args:
        run: what flew.
        path: a new .nc, .bag or .mcap.
        robot: that flew, by default the one that the run names.
        link: whose pose is on the lab's topics; the flight controller's by default.
        namespace: of the lab's topics.
        ros2: whether an MCAP file holds messages of ROS 2.

    Returns:
        What the format cannot hold, one line each.

    Raises:
        OutputError: if the file exists or cannot be written.
        ConfigError: for another ending, or no namespace of ROS.
    """
    path = require_new(path)
    require_namespace(namespace)
    if ros2 and path.suffix != ".mcap":
        raise ConfigError(f"messages of ROS 2 are written as .mcap, not as '{path.name}'")
    if ending_of(path) == ".nc":
        run.save(path)
        return ()
    container, types = container_of(path), Ros2Types().types if ros2 else message_types()
    model = load_robot(robot or str(run.log.attrs.get("robot", ROBOT)))
    shown = lab_link(model, link)
    messages = messages_of(run, model, types, shown, namespace, ros2=ros2)
    container.write(path, map(encoder(ros2), messages))
    return _not_held(run, shown)


def convert(
    source: str | Path,
    target: str | Path,
    robot: str = "",
    link: str = "",
    namespace: str = NAMESPACE,
    ros2: bool = False,
) -> tuple[str, ...]:
    """Write a log in another format; arguments are those of `read_log` and `write_log`.

    Returns:
        What one of the formats cannot hold, one line each.
    """
    ending_of(target)
    require_new(target)
    read = read_log(source, robot, link)
    return (*read.notes, *write_log(read.run, target, robot, link, namespace, ros2))


def salvage(source: str | Path, target: str | Path) -> int:
    """Write all that can be read of a bag or an MCAP file as a whole one with an index.

    Args:
        source: of ours or anybody's, also one that was cut off, without an index; of one that is damaged,
            what lies before the damage.
        target: a new file; its messages are those of the source to the byte.

    Returns:
        How many messages.

    Raises:
        OutputError: when no message of the source can be read, or the target exists.
        ConfigError: for another ending.
    """
    count = 0

    def counted(messages: Iterable[Raw]) -> Iterator[Raw]:
        nonlocal count
        for message in _some(messages, source):  # within the writing: no file is left then
            count += 1
            yield message

    # ROS calls a bag that is being recorded NAME.bag.active.
    container = container_of(str(source).removesuffix(".active"))
    with container.read(Path(source), salvaged=True) as messages:
        container_of(target).write(require_new(target), counted(messages))
    return count


def _some(messages: Iterable[Raw], source: str | Path) -> Iterator[Raw]:
    """The messages of a file; an error where there is none."""
    message = None
    for message in messages:
        yield message
    if message is None:
        raise OutputError(f"no message of '{source}' can be read; it is empty, or cut off before the first")


def _not_held(run: Run, link: str) -> tuple[str, ...]:
    log, names = run.log, set(row_names(run.log))
    lost = [str(name) for name in log.data_vars if "time" in log[name].dims and name not in names]
    missing = [topic.name for topic in IN_LOGS if topic not in topics_of(log)]
    return (
        f"poses on the lab's topics are those of {link}",
        *([f"no messages on {', '.join(missing)}: the log lacks their signals"] if missing else []),
        *([f"no place for words over time: {json.dumps(lost)}"] if lost else []),
    )
