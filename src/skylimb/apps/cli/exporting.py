"""The verb that writes a controller as C: `export-c`."""

from __future__ import annotations

from typing import Annotated

from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Calibration, new_folder, within
from skylimb.base.errors import ConfigError


def export_c(
    folder: Annotated[str, arg("New folder for the files.", "DIR")],
    *,
    controller: Annotated[
        str | None, arg("A controller's name or its TOML file; by default hybrid.", "NAME")
    ] = None,
    robot: Annotated[
        str | None, arg("A robot's name, folder or file; by default hydrus_xi_quad.", "NAME")
    ] = None,
    calibration: Calibration = None,
    rate: Annotated[float | None, arg("Control ticks a second; by default 200.", "HZ")] = None,
    losses: Annotated[
        bool | None,
        arg(
            "Whether its supervisor looks for rotors that lose thrust; tuned to hydrus_xi_quad. "
            "By default no, with --log as in the flight."
        ),
    ] = None,
    log: Annotated[
        str,
        arg(
            "A recorded flight: its controller and supervisor are written, and its inputs as flight.bin.",
            "LOG",
        ),
    ] = "",
) -> None:
    """Write a controller as C for a flight computer: no allocation, nothing needed but libm.

    Leaves the controller's function, its header, a test vector and an example that holds the one against the
    other.

    Examples:
        skylimb export-c --controller hybrid out/hybrid-c
        skylimb export-c --controller my_gains.toml out/mine-c --rate 250
        skylimb export-c --log out/hybrid out/hybrid-c
        skylimb export-c --controller following --losses out/following-c
    """
    within("--rate", 200.0 if rate is None else rate, 10.0, 10_000.0, "Hz")
    if log:
        chosen = {"controller": controller, "robot": robot, "calibration": calibration, "rate": rate}
        for name, value in chosen.items():
            if value is not None:
                raise ConfigError(f"--{name} cannot stand beside --log: the flight says what is written")
    place = new_folder(folder, "")
    if log:
        from skylimb.analysis.exchange.convert import read_log
        from skylimb.flight.export.host import export_with_flight

        written = export_with_flight(read_log(log).run, place, losses)
        compiler, program, use = "cc -std=c99 -O2 host.c", "host", " < flight.bin > commands.bin"
    else:
        import skylimb
        from skylimb.control.supervisor.limits import Limits
        from skylimb.flight import export

        model = skylimb.load_robot(robot or "hydrus_xi_quad")
        law = skylimb.load_controller(controller or "hybrid", model)
        if calibration:
            from skylimb.control.calibrated import calibrated
            from skylimb.control.corrections import read_corrections

            law = calibrated(law, model, read_corrections(calibration))
        written = export.export_c(law, place, 1.0 / (rate or 200.0), limits=Limits(losses=bool(losses)))
        compiler, program, use = "cc main.c", "example", ""
    for path in written:
        print(f"  {path}")
    build = f"{compiler} controller.c controller_function.c -o {program} -lm"
    print(f"try it: cd {place} && {build} && ./{program}{use}")
