"""The verb that runs estimator and controller on a log: `replay`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Calibration, Log, Out, Settings, new_folder, stem

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run


def replay(
    log: Log,
    *,
    controller: Annotated[
        str | None, arg("Another controller than flew: its name, its TOML file, or a Python file.", "NAME")
    ] = None,
    calibration: Calibration = None,
    set: Settings = None,
    out: Out = "",
) -> None:
    """Run estimator and controller on a recorded flight, simulated or real.

    With the configuration that flew, the recorded estimates and commands come out again, to the bit. With
    another controller or other gains one sees what would have been estimated and commanded. Nothing is
    simulated: measurements stay as recorded, and the estimator gets the thrusts that were flown. Leaves
    log.nc, config.toml, differences.csv and figures/.

    Examples:
        skylimb replay out/hybrid
        skylimb replay out/hybrid --controller following --out out/what-following-sees
        skylimb replay out/hybrid --set controller.estimation.observer.force=[2,2,2]
        skylimb replay flight.bag --controller hybrid --set robot=my_robot
    """
    folder = new_folder(out, "-".join(filter(None, [Path(log).stem, stem(controller or ""), "replayed"])))
    import skylimb
    from skylimb.analysis.exchange.convert import read_log

    recorded, notes = read_log(log, str((set or {}).get("robot", "")))
    with output.flights() as progress:
        replayed = skylimb.replay(
            recorded,
            controller,
            set=set,
            progress=lambda done, total: progress("replaying", done, total),
            calibration=calibration,
        )
    with output.working("writing log, table and figures"):
        from skylimb.analysis.report.replay_folder import write_replay

        write_replay(recorded, replayed, folder)
    _show(recorded, replayed)
    output.notes(notes)
    output.hand_over({replayed.name: replayed}, folder)


def _show(recorded: Run, replayed: Run) -> None:
    """The differences, largest against the signal's own size first; one line where there is none."""
    from skylimb.analysis.report.controller_replay import differences, only_in

    found, ticks = differences(recorded, replayed), replayed.log.sizes["time"]
    if found and all(one.same for one in found):
        print(f"{len(found)} estimates and commands at {ticks} ticks: the recorded ones to the bit")
        return
    rows = []
    for one in sorted(found, key=lambda one: -one.rms / (one.size or 1.0)):
        numbers = (f"{one.size:.4g}", f"{one.rms:.3g}", f"{one.largest:.3g}", f"{one.time:.3f} s")
        rows.append((one.signal, one.unit, *numbers))
    columns = ("Estimate or command", "", "Recorded, rms", "Difference, rms", "Largest", "at")
    title = f"{recorded.controller} recorded, {replayed.controller} replayed over {ticks} ticks"
    output.show_table(rows, *columns, title=title)
    for words, names in (
        ("not recorded", only_in(replayed, recorded)),
        ("not replayed", only_in(recorded, replayed)),
    ):
        if names:
            print(f"{words}: {', '.join(names)}")
    _show_truth(recorded, replayed)


def _show_truth(recorded: Run, replayed: Run) -> None:
    """What either estimate of the force is worth, where the log says what really pushed."""
    from skylimb.analysis.scores.registry import SCORES, measured

    before, after = (measured(run, ["estimate"]) for run in (recorded, replayed))
    known = [key for key in before if (before[key], after[key]) != (None, None)]
    rows = [
        (SCORES[key].titled(), *(SCORES[key].printed(found[key]) for found in (before, after)))
        for key in known
    ]
    if rows:
        output.show_table(rows, "Held against the true force", "Recorded", "Replayed")
