"""The run record: what a flight left behind, in memory and on disk.

This package knows nothing of simulation or control, so that the log of a real flight is as good a `Run` as a
simulated one.
"""

from skylimb.recording.files import new_file, new_folder, require_new
from skylimb.recording.folder import load_runs
from skylimb.recording.run import FORMAT_VERSION, LOG_FILE, Run
from skylimb.recording.versions import versions

__all__ = [
    "FORMAT_VERSION",
    "LOG_FILE",
    "Run",
    "load_runs",
    "new_file",
    "new_folder",
    "require_new",
    "versions",
]
