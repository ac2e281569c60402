"""The verb `studio`: a live flight in the browser."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Assignments, Experiment, Seed, settings_of, whole_number
from skylimb.base.errors import ConfigError


@dataclass(frozen=True)
class Studio:
    """Fly live in the browser: poke the robot, move the surface, turn gains.

    Opens a page on a flight in real time, or 0.1 to 20 times as fast. What was flown can be kept: as an
    experiment with every poke and change in it, which flies again to the same bits. Ctrl-C ends it.
    """

    examples: ClassVar[str] = """
        skylimb studio
        skylimb studio paper --controller hybrid pid       two beside each other
        skylimb studio --controller my_controller.py      flown anew whenever the file is saved
        skylimb studio --host 0.0.0.0 --token new         for others, who need the whole address
    """

    experiment: Experiment = "paper"
    controller: Annotated[
        tuple[str, ...],
        arg(
            metavar="NAME ...",
            help="One or two controllers' names, TOML files or Python files; by default the one in the "
            "experiment's file, else hybrid.",
        ),
    ] = ()
    seed: Seed = ""
    set: Assignments = ()
    out: Annotated[str, arg(metavar="DIR", help="Folder for all that is kept.")] = "out/studio"
    host: Annotated[str, arg(metavar="ADDRESS", help="Where to listen; others reach any but 127.0.0.1.")] = (
        "127.0.0.1"
    )
    port: Annotated[str, arg(metavar="N", help="Port to listen on; 0 for a free one.")] = "0"
    token: Annotated[
        str,
        arg(metavar="WORD", help="Word that the address has to have; 'new' makes one up."),
    ] = ""
    browser: Annotated[bool, arg(help="Whether to open the page in a browser.")] = True

    def __call__(self) -> int:
        """Serve until Ctrl-C."""
        from skylimb.apps.studio.server_access import checked_token

        settings, seed = settings_of(self.set), whole_number("--seed", self.seed)
        token = checked_token(self.host, self.token)
        port = whole_number("--port", self.port) or 0
        if not 0 <= port <= 65535:
            raise ConfigError(f"--port = {port} is outside of 0 .. 65535")
        from skylimb.apps.studio.server_run import serve

        serve(
            self.experiment,
            self.controller,
            settings,
            seed,
            Path(self.out),
            host=self.host,
            port=port,
            token=token,
            browser=self.browser,
        )
        return 0
