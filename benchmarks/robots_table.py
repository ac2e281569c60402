"""Robots from their files: check, hover, touch and a line on a surface, and whether check and flight agree.

    python benchmarks/robots_table.py [--lab FOLDER] [--px4 FOLDER] [--only WORD ...] [--write]

Flown are the robots that ship, those of `robots_made.py`, with `--lab` every robot of the laboratory in
a folder of URDFs and packages, and with `--px4` the multirotors among PX4's Gazebo models, which are SDF, in
the folder `models` of their repository. Each draws where its check says that its tip is foremost: on a wall,
a floor or a ceiling. What was flown is kept in docs/robots.json, so that `--only` flies some anew; `--write`
writes the table of docs/reports/robots.md. Times are of processor, s.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "helpers"))

from robots_made import ARMED, KINDS

import skylimb
from armed_robots import multirotor_with_arm
from skylimb.apps.robot_import.checking import RobotReport
from skylimb.apps.robot_import.hover_flight import HOVER, not_hovered
from skylimb.apps.robot_import.report import verdict
from skylimb.base.errors import SkylimbError

DOCS = Path(__file__).parents[1] / "docs"
PAGE, KEPT = DOCS / "reports" / "robots.md", DOCS / "robots.json"
BEGIN, END = "<!-- files: written by benchmarks/robots_table.py -->", "<!-- end of files -->"
BOARD = "board_tilted_hexarotor"
SURFACES: dict[str, dict[str, Any]] = {
    "wall": {},
    "floor": {"contact_axis": [0.0, 0.0, -1.0], "surface.position": [0.6, 0.0, 0.5]},
    "ceiling": {"contact_axis": [0.0, 0.0, 1.0], "surface.position": [0.6, 0.0, 2.0]},
}
FORCES = (1.0, 0.7, 0.5)
"""Forces that are tried, N: more may be refused for a weak yaw, and less is not felt as a touch."""
WANTED = 0.008
"""What a line may be off, m."""
HEAD = (
    "| robot | edits | check: hover, touch | flown: hover | where | force, N | line, mm | touch | done "
    "| s: check, hover, line |",
    "|---|---|---|---|---|---|---|---|---|---|",
)


class Entry(NamedTuple):
    """A robot of the table: its group, name, file, and mapping."""

    group: str
    name: str
    path: Path
    mapping: str = ""


def timed(work: Callable[[], object]) -> tuple[Any, float]:
    """What a call gives, a refusal as its words, and its time."""
    begin = time.process_time()
    found: Any
    try:
        found = work()
    except SkylimbError as error:
        found = str(error)
    return found, round(time.process_time() - begin, 1)


PX4 = ("x500", "x500_depth", "x500_gimbal", "px4vision", "omnicopter", "omniquad", "tiltrotor")


def entries(lab: Path | None, px4: Path | None, folder: Path) -> Iterator[Entry]:
    """All robots of the table."""
    for name in skylimb.list_robots():
        yield Entry("ships", name, Path(name))
    for path in sorted(lab.rglob("*.urdf")) if lab else ():
        yield Entry("lab", path.stem, path)
    for path in sorted(lab.rglob("*.urdf.xacro")) if lab else ():
        if path.parent.parent.name == "quad":
            yield Entry("lab", f"{path.parents[3].name}, {path.parent.name}", path)
        elif path.parent.name == "quad":
            yield Entry("lab", f"{path.parents[2].name}, {path.name.removesuffix('.urdf.xacro')}", path)
    for path in (px4 / name / "model.sdf" for name in PX4) if px4 else ():
        yield Entry("px4", path.parent.name, path)
    for group, made in (("kinds", KINDS), ("arms", ARMED)):
        for k, (name, (given, mapping)) in enumerate(made.items()):
            yield Entry(group, name, multirotor_with_arm(folder / f"{group}{k}.urdf", **given), mapping)


def flown(entry: Entry, folder: Path) -> dict[str, Any]:
    """What check and flights say of a robot."""
    robot = entry.name if entry.group == "ships" else str(folder / "robot")
    mapping = folder / "mapping.toml"
    mapping.write_text(entry.mapping, encoding="utf-8")

    def checked(*, mend: bool = False) -> RobotReport:
        if entry.group == "ships":
            return skylimb.check_robot_file(robot)
        shutil.rmtree(robot, ignore_errors=True)
        return skylimb.import_robot(entry.path, robot, mapping=mapping, mend=mend)

    said, checking = timed(checked)
    row: dict[str, Any] = {"group": entry.group, "name": entry.name, "edits": len(entry.mapping.splitlines())}
    if isinstance(said, str):
        return {**row, "refused": said}
    if any("inertia of link" in reason.what for reason in said.reasons):
        said, checking = timed(lambda: checked(mend=True))
        row["edits"] = "`--mend`"
    row |= {"hover": said.can_hover, "touch": said.can_touch, "check_s": checking}
    row["why"] = "" if said.can_touch else verdict(said)
    hovered, row["hover_s"] = timed(
        lambda: skylimb.run("free_flight", "following", set={"robot": robot, **HOVER})
    )
    row["flown"] = hovered if isinstance(hovered, str) else not not_hovered(hovered)
    return row | drawn(robot, said) if said.can_touch else row


def where(report: RobotReport) -> str:
    """The surface that the tip can touch."""
    if report.actuation is None or report.actuation.ahead:
        return "wall"
    return "floor" if report.actuation.touch.direction[2] < 0.0 else "ceiling"


def drawn(robot: str, report: RobotReport) -> dict[str, Any]:
    """What a line on a surface comes to, with the first force that take-off allows."""
    row: dict[str, Any] = {"where": where(report)}
    for force in FORCES:
        keys = {"robot": robot, "controller.translation.force": force, **SURFACES[row["where"]]}
        run, row["line_s"] = timed(lambda keys=keys: skylimb.run(BOARD, "following", set=keys))
        if not isinstance(run, str):
            found = run.metrics
            row |= {"force": force, "line": found["pen_line_rms"], "done": bool(found["done"])}
            row |= {"touched": found["contact_fraction"], "missed": list(found["missed"])}
            return row
        row["stopped"] = run
    return row


def agree(row: dict[str, Any]) -> bool:
    """Whether the flight does what the check says: hovers or not, and touches where the tip is foremost."""
    if "refused" in row:
        return True
    hovers = row["flown"] is True
    touches = not row["touch"] or "line" in row or "cannot touch" not in row.get("stopped", "")
    return hovers == row["hover"] and touches


def line(row: dict[str, Any]) -> str:
    """A line of the table."""
    if "refused" in row:
        return f"| {row['name']} | {row['edits']} | refused: {row['refused'][:90]} | | | | | | | |"
    said = ", ".join("yes" if row[key] else "no" for key in ("hover", "touch"))
    hover = "yes" if row["flown"] is True else "no" if row["flown"] is False else "refused"
    times = ", ".join(f"{row[key]:.1f}" for key in ("check_s", "hover_s", "line_s") if key in row)
    ends = ["", "", "", "", ""]
    if "line" in row:
        length = "lost" if row["line"] is None else f"{1e3 * row['line']:.1f}"
        touched = "" if row["touched"] is None else f"{row['touched']:.2f}"
        ends = [row["where"], f"{row['force']:g}", length, touched, "yes" if row["done"] else "no"]
    elif "stopped" in row:
        ends = [row["where"], f"refused: {row['stopped'][:110]}", "", "", ""]
    return f"| {row['name']} | {row['edits']} | {said} | {hover} | {' | '.join(ends)} | {times} |"


def table(rows: list[dict[str, Any]]) -> str:
    """The table, and a summary of it."""
    flew = [row for row in rows if "line" in row]
    within = sum(row["line"] is not None and row["line"] <= WANTED for row in flew)
    differ = [row["name"] for row in rows if not agree(row)]
    return "\n".join(
        (
            f"{len(rows)} robots. Check and flight "
            + ("agree on all" if not differ else f"DISAGREE on {', '.join(differ)}")
            + f". {within} of {len(flew)} lines are within {1e3 * WANTED:g} mm; "
            f"{sum(row['done'] for row in flew)} flights are done.\n",
            *HEAD,
            *map(line, rows),
        )
    )


def kept() -> dict[str, dict[str, Any]]:
    """The rows that were flown so far."""
    return json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}


def main() -> None:
    """Fly, keep, and print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--lab", type=Path)
    parser.add_argument("--px4", type=Path)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as place:
        for k, entry in enumerate(entries(given.lab, given.px4, Path(place))):
            key = f"{entry.group}: {entry.name}"
            if given.only and not any(word in key for word in given.only):
                continue
            folder = Path(place) / str(k)
            folder.mkdir()
            row = flown(entry, folder)
            print(line(row), "" if agree(row) else "DISAGREE", flush=True)
            KEPT.write_text(json.dumps({**kept(), key: row}, indent=1) + "\n", encoding="utf-8")
    if given.write:
        order = ("ships", "lab", "px4", "kinds", "arms")
        rows = sorted(kept().values(), key=lambda row: order.index(row["group"]))
        page = PAGE.read_text(encoding="utf-8")
        before, _, rest = page.partition(BEGIN)
        PAGE.write_text(
            f"{before}{BEGIN}\n\n{table(rows)}\n\n{END}{rest.partition(END)[2]}", encoding="utf-8"
        )


if __name__ == "__main__":
    main()
