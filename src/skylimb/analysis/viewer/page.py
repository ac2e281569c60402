"""The part of a page that shows flights again: one element, its styles, its program and its data."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from pathlib import Path

from skylimb.analysis.pages.pages import render_page
from skylimb.analysis.recording import Run
from skylimb.analysis.viewer import VENDOR
from skylimb.base.errors import OutputError

NEEDED = ("configuration", "tip_position", "cog_position")

_HERE = Path(__file__).parent
_FRAME_HEIGHT = 900
"""Of the frame in a notebook, in its pixels."""


def can_replay(run: Run) -> bool:
    """Whether a run's log holds a scene and what moves in it."""
    return bool(run.log.attrs.get("scene")) and all(name in run.log for name in NEEDED)


def viewer_html(runs: Mapping[str, Run], speed: float = 1.0) -> str:
    """HTML that holds everything and fetches nothing; empty where no run can be shown."""
    shown = {name: run for name, run in runs.items() if can_replay(run)}
    if not shown:
        return ""
    from skylimb.analysis.viewer.payload import viewer_payload  # the engine is slow to load

    data = json.dumps(
        {**viewer_payload(shown), "speed": speed}, separators=(",", ":"), allow_nan=False
    ).replace("<", "\\u003c")
    files = (_HERE / "viewer.css", VENDOR, _HERE / "viewer.js")
    style, vendor, program = (path.read_text(encoding="utf-8") for path in files)
    return (
        f"<style>{style}</style>\n"
        '<div class="replay" id="replay"></div>\n'
        f'<script type="application/json" id="replay-data">{data}</script>\n'
        f"<script>{vendor}</script>\n<script>{program}</script>\n"
    )


class FlightViewer:
    """Flights to watch in a notebook: a frame with a page of its own.

    Args:
        runs: by name.
        speed: at which they play, times the real speed.

    Raises:
        OutputError: when no run was recorded with its scene.
    """

    def __init__(self, runs: Mapping[str, Run], speed: float = 1.0) -> None:
        content = viewer_html(runs, speed)
        if not content:
            raise OutputError(f"{', '.join(runs)} was recorded without its scene; there is nothing to watch")
        self.page = render_page(_HERE / "page.html", title=", ".join(runs), versions={}, viewer=content)

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.page)}" width="100%" height="{_FRAME_HEIGHT}" '
            'style="border:0" title="The flight in three dimensions"></iframe>'
        )
