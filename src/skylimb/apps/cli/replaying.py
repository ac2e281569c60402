"""The verb that runs estimator and controller on a log: `replay`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import Positional, arg
from skylimb.apps.cli.options import Assignments, Calibration, Out, new_folder, settings_of, stem

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run


@dataclass(frozen=True)
class Replay:
    """Run estimator and controller on a recorded flight, simulated or real.

    With the configuration that flew, the recorded estimates and commands come out again, to the bit. With
    another controller or other gains one sees what would have been estimated and commanded. Nothing is
    simulated: measurements stay as recorded, and the estimator is told the thrusts that were flown. Leaves
    log.nc, config.toml, differences.csv and figures/.
    """

    examples: ClassVar[str] = """
        skylimb replay out/hybrid
        skylimb replay out/hybrid --controller following --out out/what-following-sees
        skylimb replay out/hybrid --set controller.estimation.observer.force=[2,2,2]
        skylimb replay flight.bag --controller hybrid --set robot=my_robot
    """

    log: Annotated[Positional[str], arg(metavar="LOG", help="A run's folder, or a .nc, .bag or .mcap file.")]
    controller: Annotated[
        str,
        arg(metavar="NAME", help="Another controller than flew: its name, its TOML file, or a Python file."),
    ] = ""
    calibration: Calibration = ""
    set: Assignments = ()
    out: Out = ""

    def __call__(self) -> int:
        """Replay, hold against what was recorded, draw."""
        settings = settings_of(self.set)
        usual = "-".join(filter(None, [Path(self.log).stem, stem(self.controller), "replayed"]))
        folder = new_folder(self.out, usual)
        import skylimb
        from skylimb.analysis.exchange.convert import read_log

        robot = str(settings.get("robot", ""))
        recorded, read_notes = read_log(self.log, robot)
        with output.flights() as progress:
            replayed = skylimb.replay(
                recorded,
                self.controller or None,
                set=settings,
                progress=lambda done, total: progress("replaying", done, total),
                calibration=self.calibration or None,
            )
        with output.working("writing log, table and figures"):
            from skylimb.analysis.report.replay_folder import write_replay

            write_replay(recorded, replayed, folder)
        _show(recorded, replayed)
        for note in read_notes:
            print(f"note: {note}")
        output.notes({replayed.name: replayed})
        output.places(folder)
        return 0


def _show(recorded: Run, replayed: Run) -> None:
    """The differences, largest against the signal's own size first; one line where there is none."""
    from skylimb.analysis.report.controller_replay import differences, only_in

    console, found = output.console_for(), differences(recorded, replayed)
    ticks = replayed.log.sizes["time"]
    if found and all(one.same for one in found):
        console.print(f"{len(found)} estimates and commands at {ticks} ticks: the recorded ones to the bit")
        return
    table = output.plain_table(
        f"{recorded.controller} recorded, {replayed.controller} replayed over {ticks} ticks",
        "Estimate or command", "", "Recorded, rms", "Difference, rms", "Largest", "at",
    )  # fmt: skip
    for one in sorted(found, key=lambda one: -one.rms / (one.size or 1.0)):
        numbers = (f"{one.size:.4g}", f"{one.rms:.3g}", f"{one.largest:.3g}", f"{one.time:.3f} s")
        table.add_row(one.signal, one.unit, *numbers)
    console.print(table)
    for words, names in (
        ("not recorded", only_in(replayed, recorded)),
        ("not replayed", only_in(recorded, replayed)),
    ):
        if names:
            console.print(f"{words}: {', '.join(names)}")
