"""How a run shows itself in a notebook: its verdict, two plots, its scores. HTML that stands alone."""

from __future__ import annotations

import base64
import html

from skylimb.analysis.figures import style
from skylimb.analysis.figures.plotting import plotted
from skylimb.analysis.recording import Run

PLOTTED = ("contact_force_normal", "cog_position")
"""Signals that are drawn, each with its reference where there is one."""


def run_html(run: Run) -> str:
    """The run as HTML."""
    title = f"{run.log.attrs.get('experiment', 'flight')}: {run.name}"
    colour = "#b3261e" if run.failed or run.missed else "#2e7d32"
    lines = [
        f"<b>{html.escape(title)}</b>",
        f'<span style="color:{colour}">{html.escape(run.verdict)}</span>',
    ]
    lines += [html.escape(note) for note in run.notes]
    lines += [_picture(run, signal) for signal in PLOTTED if signal in run.log and run.log.sizes["time"] > 1]
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{text}</td></tr>" for name, text in run.numbers().items()
    )
    scores = f"<details><summary>scores</summary><table>{rows}</table></details>" if rows else ""
    return f"<div>{'<br>'.join(lines)}{scores}</div>"


def _picture(run: Run, signal: str) -> str:
    data = base64.b64encode(style.png(plotted({run.name: run}, signal), dpi=80)).decode("ascii")
    return f'<img alt="{signal} over time" src="data:image/png;base64,{data}">'
