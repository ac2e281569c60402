"""The verb `studio`: a live flight in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Experiment, Seed, Settings, within


def studio(
    experiment: Experiment = "paper",
    *,
    controller: Annotated[
        tuple[str, ...],
        arg(
            "One or two controllers' names, TOML files or Python files; by default the one in the "
            "experiment's file, else hybrid.",
            "NAME ...",
        ),
    ] = (),
    seed: Seed = None,
    set: Settings = None,
    out: Annotated[str, arg("Folder for all that is kept.", "DIR")] = "out/studio",
    host: Annotated[str, arg("Where to listen; others reach any but 127.0.0.1.", "ADDRESS")] = "127.0.0.1",
    port: Annotated[int, arg("Port to listen on; 0 for a free one.", "N")] = 0,
    token: Annotated[
        str, arg("Word that the address has to have; 'new' makes one up, 'none' asks for none.", "WORD")
    ] = "new",
    browser: Annotated[bool, arg("Whether to open the page in a browser.")] = True,
) -> None:
    """Fly live in the browser: poke the robot, move the surface, turn gains.

    Opens a page on a flight in real time, or 0.1 to 20 times as fast. What was flown can be kept: as an
    experiment with every poke and change in it, which flies again to the same bits. Ctrl-C ends it.

    Examples:
        skylimb studio
        skylimb studio paper --controller hybrid pid       two beside each other
        skylimb studio --controller my_controller.py      flown anew whenever the file is saved
        skylimb studio --host 0.0.0.0                     for others, who need the whole address
    """
    from skylimb.apps.studio.server_access import checked_token

    token = checked_token(host, token)
    within("--port", port, 0, 65535)
    from skylimb.apps.studio.server_run import serve

    serve(
        experiment, controller, set or {}, seed, Path(out), host=host, port=port, token=token, browser=browser
    )
