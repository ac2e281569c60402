"""What `skylimb replay` leaves: the replayed log, how it differs from the recorded one, figures of both."""

from __future__ import annotations

from pathlib import Path

from skylimb.analysis.figures import style
from skylimb.analysis.figures.controller_replay import replayed_figures
from skylimb.analysis.recording import LOG_FILE, Run
from skylimb.analysis.report.controller_replay import differences, differences_table
from skylimb.analysis.report.output import FIGURES_FOLDER
from skylimb.analysis.report.places import CONFIG_FILE, DIFFERENCES_FILE
from skylimb.base.files import new_folder


def write_replay(recorded: Run, replayed: Run, folder: str | Path) -> Path:
    """Write a replay into a new folder, which appears under its name when it is complete.

    Where every bit is as it was recorded there is nothing to draw.

    Args:
        recorded: the run that was replayed.
        replayed: what came out.
        folder: must not exist.

    Raises:
        OutputError: if the folder exists or cannot be written; nothing is left behind then.
    """
    with new_folder(folder) as aside:
        replayed.save(aside / LOG_FILE)
        (aside / CONFIG_FILE).write_text(replayed.config, encoding="utf-8")
        found = differences(recorded, replayed)
        (aside / DIFFERENCES_FILE).write_text(differences_table(found), encoding="utf-8")
        figures = {} if all(one.same for one in found) else replayed_figures(recorded, replayed)
        (aside / FIGURES_FOLDER).mkdir()
        for name, figure in figures.items():
            style.save(figure, aside / FIGURES_FOLDER / name)
    return Path(folder)
