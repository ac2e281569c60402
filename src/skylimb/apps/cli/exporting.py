"""The verb that writes a controller as C: `export-c`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

from skylimb.apps.cli.arguments import Positional, arg
from skylimb.apps.cli.options import Calibration, new_folder
from skylimb.base.errors import ConfigError


@dataclass(frozen=True)
class ExportC:
    """Write a controller as C for a flight computer: no allocation, nothing needed but libm.

    Leaves the controller's function, its header, a test vector and an example that holds the one against the
    other.
    """

    examples: ClassVar[str] = """
        skylimb export-c --controller hybrid out/hybrid-c
        skylimb export-c --controller my_gains.toml out/mine-c --rate 250
        skylimb export-c --log out/hybrid out/hybrid-c
    """

    folder: Annotated[Positional[str], arg(metavar="DIR", help="New folder for the files.")]
    controller: Annotated[str, arg(metavar="NAME", help="A controller's name or its TOML file.")] = "hybrid"
    robot: Annotated[str, arg(metavar="NAME", help="A robot's name, folder or file.")] = "hydrus_xi_quad"
    calibration: Calibration = ""
    rate: Annotated[float, arg(metavar="HZ", help="Control ticks a second.")] = 200.0
    log: Annotated[
        str,
        arg(
            metavar="LOG", help="A recorded flight: its controller is written, and its inputs as flight.bin."
        ),
    ] = ""

    def __call__(self) -> int:
        """Trace it and write the files."""
        if not 10.0 <= self.rate <= 10_000.0:
            raise ConfigError(f"--rate = {self.rate:g} Hz is outside 10 .. 10000 Hz")
        folder = new_folder(self.folder, "")
        if self.log:
            return self._with_flight(folder)
        import skylimb
        from skylimb.flight.export import export_c

        robot = skylimb.load_robot(self.robot)
        controller = skylimb.load_controller(self.controller, robot)
        if self.calibration:
            from skylimb.control.cascade import calibrated
            from skylimb.control.corrections import read_corrections

            controller = calibrated(controller, robot, read_corrections(self.calibration))
        for path in export_c(controller, folder, 1.0 / self.rate):
            print(f"  {path}")
        build = "cc main.c controller.c controller_function.c -o example -lm"
        print(f"try it: cd {folder} && {build} && ./example")
        return 0

    def _with_flight(self, folder: Path) -> int:
        from skylimb.analysis.exchange.convert import read_log
        from skylimb.flight.export.host import export_with_flight

        for path in export_with_flight(read_log(self.log).run, folder):
            print(f"  {path}")
        build = "cc -std=c99 -O2 host.c controller.c controller_function.c -o host -lm"
        print(f"try it: cd {folder} && {build} && ./host < flight.bin > commands.bin")
        return 0
