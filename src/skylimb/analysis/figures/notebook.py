"""How a run shows itself in a notebook: its verdict, two plots, its scores. HTML that stands alone."""

from __future__ import annotations

import base64
from pathlib import Path

from skylimb.analysis.figures import style
from skylimb.analysis.figures.plotting import plotted
from skylimb.analysis.pages.pages import render_page
from skylimb.analysis.recording import Run

TEMPLATE = Path(__file__).with_name("notebook.html")

PLOTTED = ("contact_force_normal", "cog_position")
"""Signals that are drawn, each with its reference where there is one."""


def run_html(run: Run) -> str:
    """The run as HTML."""
    drawn = [signal for signal in PLOTTED if signal in run.log and run.log.sizes["time"] > 1]
    pictures = {signal: style.png(plotted({run.name: run}, signal), dpi=80) for signal in drawn}
    return render_page(
        TEMPLATE,
        run=run,
        title=f"{run.log.attrs.get('experiment', 'flight')}: {run.name}",
        colour="#b3261e" if run.failed or run.missed else "#2e7d32",
        pictures=[(signal, base64.b64encode(png).decode("ascii")) for signal, png in pictures.items()],
    )
