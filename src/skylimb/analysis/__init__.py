"""Metrics, figures, video and report of recorded flights.

Reads runs and nothing else: a real flight's log is as welcome.
"""

from skylimb.analysis.metrics import metrics

__all__ = ["metrics"]
