"""The synthetic flight's fixtures."""

from synthetic_flight import four_runs, happening, make_event, make_log, make_run

__all__ = ["four_runs", "happening", "make_event", "make_log", "make_run"]
