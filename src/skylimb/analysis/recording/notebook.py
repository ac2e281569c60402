"""How a run shows itself in a notebook: its verdict, a small plot, its scores. HTML that stands alone."""

from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run

_PLOTTED = (
    ("contact_force_normal", "contact_force_reference"),
    ("cog_position", "cog_position_reference"),
)
"""Signals that are drawn, each with its reference where there is one."""


def run_html(run: Run) -> str:
    """The run as HTML."""
    title = f"{run.log.attrs.get('experiment', 'flight')}: {run.name}"
    colour = "#b3261e" if run.failed or run.missed else "#2e7d32"
    verdict = f'<span style="color:{colour}">{html.escape(_verdict(run))}</span>'
    lines = [f"<b>{html.escape(title)}</b>", verdict]
    lines += [html.escape(note) for note in run.notes]
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{html.escape(_number(value))}</td></tr>"
        for name, value in run.metrics.items()
        if _is_number(value)
    )
    scores = f"<details><summary>scores</summary><table>{rows}</table></details>" if rows else ""
    return f"<div>{'<br>'.join(lines)}{_plot(run)}{scores}</div>"


def _verdict(run: Run) -> str:
    if run.failed:
        return f"{run.status}: {run.cause}"
    if run.missed:
        return f"finished, not done as commanded: {'; '.join(run.missed)}"
    return "done as commanded" if run.metrics.get("done") else "finished"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _number(value: float) -> str:
    return f"{value:.4g}"


def _plot(run: Run) -> str:
    """A small picture of the signals over time; empty where the log has none of them."""
    shown = [pair for pair in _PLOTTED if pair[0] in run.log.variables and run.log.sizes.get("time", 0) > 1]
    if not shown:
        return ""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.2 * len(shown), 2.2), layout="constrained")
    for axes, (name, reference) in zip(np.atleast_1d(figure.subplots(1, len(shown))), shown, strict=True):
        time = run.log.time.values
        signal = run.log[name]
        axes.plot(time, signal.values, linewidth=0.9)
        if reference in run.log.variables:
            axes.set_prop_cycle(None)
            axes.plot(time, run.log[reference].values, linestyle="--", linewidth=0.8)
        if signal.ndim == 2:
            entries = run.log[signal.dims[1]].values if signal.dims[1] in run.log.coords else ()
            axes.legend([str(entry) for entry in entries], fontsize=6, frameon=False)
        title = f"{name}, {signal.attrs.get('units', '')}".rstrip(", ")
        dashed = "; dashed: reference" if reference in run.log.variables else ""
        axes.set_title(f"{title}{dashed}", fontsize=8)
        axes.set_xlabel("time, s", fontsize=7)
        axes.tick_params(labelsize=7)
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=110)
    data = base64.b64encode(picture.getvalue()).decode("ascii")
    return f'<br><img alt="signals over time" src="data:image/png;base64,{data}">'
