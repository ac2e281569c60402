"""A report that one can read, send and keep: one HTML file with its pictures and videos inside."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from skylimb.analysis.figures import REPORT_FIGURES, palette
from skylimb.analysis.figures.report_figures import ReportFigure
from skylimb.analysis.pages.pages import inlined, render_page
from skylimb.analysis.paper.check import check_claims
from skylimb.analysis.paper.configuration import not_the_papers
from skylimb.analysis.paper.numbers import SOURCE, published_beside
from skylimb.analysis.recording import Run
from skylimb.analysis.recording.run import OK
from skylimb.analysis.report.places import VIDEO_FILE, configurations, films, home
from skylimb.analysis.scores.axis_names import AxisNames, common_names
from skylimb.analysis.scores.declared import shown_scores
from skylimb.analysis.scores.score import Score
from skylimb.analysis.scores.signals import HappenedEvent, common_events, contact_transitions, events_of
from skylimb.analysis.viewer.page import viewer_html

TEMPLATE = Path(__file__).with_name("report_template.html")

EMBED_BYTES = 12_000_000
"""Videos are put into the page up to this size together; larger ones are linked."""

FACTS = (
    ("trajectory.shape", "Path", ""),
    ("trajectory.file", "Drawing", ""),
    ("trajectory.text", "Words", ""),
    ("trajectory.radius", "Radius", "m"),
    ("trajectory.length", "Length", "m"),
    ("trajectory.period", "Period", "s"),
    ("trajectory.direction", "Direction", ""),
    ("surface.kind", "Surface", ""),
    ("surface.slope", "Slope", "rad"),
    ("surface.friction", "Friction", ""),
    ("approach.depth", "Press depth", "m"),
    ("sensors.latency", "Sensor latency", "s"),
    ("controller_rate", "Controller rate", "Hz"),
)
"""Keys of the configuration that a reader wants to know first, what to call them, and their units."""


_FILES = ("trajectory.file", "trajectory.shape", "surface.kind")
"""Those whose value may be a file."""

_SHAPES = {
    "trajectory.radius": ("circle", "lemniscate"),
    "trajectory.length": ("line", "lawnmower"),
    "trajectory.period": ("circle", "lemniscate"),
    "trajectory.direction": ("circle", "lemniscate", "line", "lawnmower", "waypoints"),
}
"""Shapes of a path that have these keys; other shapes leave them unused."""


def render_report(
    runs: Mapping[str, Run], folder: Path, videos_follow: bool = False, own: Iterable[ReportFigure] = ()
) -> str:
    """Put the report together from runs and from the figures and videos that already lie in `folder`.

    Args:
        runs: by name.
        folder: holds figures/NAME.png for each figure, and video.mp4 or one in a subfolder for each run.
        videos_follow: whether videos are drawn after this; the page points to where they will be.
        own: figures besides those that ship.

    Returns:
        HTML.
    """
    first = next(iter(runs.values()))
    config = first.tables
    axes = common_names(run.log for run in runs.values())
    groups, claims = _groups(runs, axes), check_claims(runs)
    return render_page(
        TEMPLATE,
        title=_title(runs),
        description=str(config.get("description", "")),
        robot=str(first.log.attrs.get("robot", "")),
        experiment=str(first.log.attrs.get("experiment", "")),
        seed=first.log.attrs.get("seed"),
        axes=axes,
        facts=_facts(config),
        columns=[(palette.label(name), palette.colours(runs)[name], run) for name, run in runs.items()],
        groups=groups,
        failures=[
            (palette.label(name), run.mark, run.cause or "no cause was recorded")
            for name, run in runs.items()
            if run.failed
        ],
        stopped=[(palette.label(name), run.cause) for name, run in runs.items() if run.stopped],
        missed=[
            (palette.label(name), run.missed) for name, run in runs.items() if run.missed and not run.failed
        ],
        done=sum(run.done is True for run in runs.values()),
        judged=sum(run.done is not None and not run.failed for run in runs.values()),
        finished=sum(run.status == OK for run in runs.values()),
        total=len(runs),
        transitions=[
            (palette.label(name), contact_transitions(run.log))
            for name, run in runs.items()
            if contact_transitions(run.log)
        ],
        happened=_happened(runs),
        compared=any(printed for _, rows in groups for _, _, cells in rows for _, printed in cells),
        otherwise=not_the_papers({palette.label(name): run for name, run in runs.items()}),
        claims=claims,
        held=sum(claim.holds for claim in claims),
        source=SOURCE,
        pictures=[
            (picture, inlined(folder / "figures" / f"{picture.name}.png", "image/png"))
            for picture in (*REPORT_FIGURES, *own)
            if (folder / "figures" / f"{picture.name}.png").is_file()
        ],
        viewer=viewer_html(runs),
        films=_films(runs, folder, videos_follow),
        videos_follow=videos_follow,
        commands=_commands(runs, folder),
        configs=[(palette.label(name), run.config) for name, run in runs.items()],
        versions=first.versions,
    )


def _title(runs: Mapping[str, Run]) -> str:
    first = next(iter(runs.values()))
    experiment = str(first.log.attrs.get("experiment", "")) or "flight"
    who = palette.label(first.name) if len(runs) == 1 else f"{len(runs)} controllers compared"
    return f"{experiment[:1].upper()}{experiment[1:]}: {who}"


def _happened(runs: Mapping[str, Run]) -> list[tuple[str, list[HappenedEvent]]]:
    """Events of each run by its name; of runs that share them, once and without a name."""
    common = common_events(run.log for run in runs.values())
    known = ((palette.label(name), events_of(run.log)) for name, run in runs.items())
    each = known if common is None else [("", common)]
    return [(name, events) for name, events in each if events]


Line = tuple[str, str, list[tuple[str, str]]]


def _groups(runs: Mapping[str, Run], axes: AxisNames) -> list[tuple[str, list[Line]]]:
    """The table: the title of each group, and its lines.

    A line has what, its unit, and for each run our number and the paper's, empty where it prints none.
    """

    def cell(run: Run, score: Score) -> tuple[str, str]:
        ours = score.printed(run.metrics.get(score.name)) or "–"
        return ours, score.printed(published_beside(run, score.name))

    return [
        (
            title,
            [(score.line(axes), score.unit, [cell(run, score) for run in runs.values()]) for score in part],
        )
        for title, part in shown_scores(runs.values()).items()
    ]


def _shape(config: Mapping[str, Any]) -> str | None:
    """The shape of the path that was flown."""
    path = config.get("trajectory")
    return path.get("shape") if isinstance(path, Mapping) else None


def _facts(config: Mapping[str, Any]) -> list[tuple[str, str]]:
    facts = []
    shape = _shape(config)
    for key, text, unit in FACTS:
        value: Any = config
        for part in key.split("."):
            value = value.get(part) if isinstance(value, Mapping) else None
        if value is not None and value != "" and shape in _SHAPES.get(key, (shape,)):
            signed = "+" if key.endswith("direction") else ""
            shown = f"{value:{signed}.4g}" if isinstance(value, int | float) else str(value)
            shown = Path(shown).name if key in _FILES else shown  # not the place of its copy
            degrees = f" ({math.degrees(value):.3g}°)" if unit == "rad" and value else ""
            facts.append((text, f"{shown} {unit}".strip() + degrees))
    return facts


def _commands(runs: Mapping[str, Run], folder: Path) -> list[str]:
    """What flies each run again that has its configuration there, in the report's folder."""
    ours, _ = configurations(runs, folder)
    return [f"skylimb run {shlex.quote(file.relative_to(folder).as_posix())}" for file in ours]


def _films(runs: Mapping[str, Run], folder: Path, follow: bool) -> list[tuple[str, str]]:
    """Each video: whose, and its source, which is its bytes or a file beside the page."""
    there = {name: home(folder, name) / VIDEO_FILE for name in runs} if follow else films(runs, folder)[0]
    embed = not follow and sum(path.stat().st_size for path in there.values()) <= EMBED_BYTES
    return [
        (palette.label(name), inlined(path, "video/mp4") if embed else path.relative_to(folder).as_posix())
        for name, path in there.items()
    ]
