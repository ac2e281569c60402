"""The part of a page that shows flights again: one element, its styles, its program and its data."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from skylimb.recording import Run

NEEDED = ("configuration", "tip_position", "cog_position")

_HERE = Path(__file__).parent


def can_replay(run: Run) -> bool:
    """Whether a run's log holds a scene and what moves in it."""
    return bool(run.log.attrs.get("scene")) and all(name in run.log for name in NEEDED)


def replay_html(runs: Mapping[str, Run]) -> str:
    """HTML that holds everything and fetches nothing; empty where no run can be shown."""
    shown = {name: run for name, run in runs.items() if can_replay(run)}
    if not shown:
        return ""
    from skylimb.analysis.replay.payload import replay_payload  # the engine is slow to load

    data = json.dumps(replay_payload(shown), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    style, program = ((_HERE / name).read_text(encoding="utf-8") for name in ("viewer.css", "viewer.js"))
    return (
        f"<style>{style}</style>\n"
        '<div class="replay" id="replay"></div>\n'
        f'<script type="application/json" id="replay-data">{data}</script>\n'
        f"<script>{program}</script>\n"
    )
