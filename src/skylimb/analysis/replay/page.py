"""The part of a page that shows flights again: one element, its styles, its program and its data."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from skylimb.analysis.replay.payload import can_replay, replay_payload
from skylimb.recording import Run

_HERE = Path(__file__).parent


def replay_html(runs: Mapping[str, Run]) -> str:
    """HTML that holds everything and fetches nothing; empty where no run can be shown."""
    if not any(can_replay(run) for run in runs.values()):
        return ""
    data = json.dumps(replay_payload(runs), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    style, program = ((_HERE / name).read_text(encoding="utf-8") for name in ("viewer.css", "viewer.js"))
    return (
        f"<style>{style}</style>\n"
        '<div class="replay" id="replay"></div>\n'
        f'<script type="application/json" id="replay-data">{data}</script>\n'
        f"<script>{program}</script>\n"
    )
