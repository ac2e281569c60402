"""Metrics, figures, video and report of recorded flights.

It reads runs and nothing else, so that a real flight's log is as welcome as a simulated one. The names below
are loaded when they are first used: scoring a flight should not pay for drawing it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from skylimb.analysis.metrics import metrics

if TYPE_CHECKING:
    from skylimb.analysis.figures import write_figures
    from skylimb.analysis.output import Written, write_comparison, write_report, write_run
    from skylimb.analysis.video import find_renderer, write_video
    from skylimb.recording import load_runs

_HOME = {
    "Written": "skylimb.analysis.output",
    "find_renderer": "skylimb.analysis.video",
    "load_runs": "skylimb.recording",
    "write_comparison": "skylimb.analysis.output",
    "write_figures": "skylimb.analysis.figures",
    "write_report": "skylimb.analysis.output",
    "write_run": "skylimb.analysis.output",
    "write_video": "skylimb.analysis.video",
}

__all__ = [
    "Written",
    "find_renderer",
    "load_runs",
    "metrics",
    "write_comparison",
    "write_figures",
    "write_report",
    "write_run",
    "write_video",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'skylimb.analysis' has no attribute '{name}'")
    return getattr(importlib.import_module(_HOME[name]), name)
