"""`skylimb` and `python -m skylimb`: the command line as a process of its own."""

import gc
import sys

from skylimb.apps.cli import main

OBJECTS_BETWEEN_COLLECTIONS = 200_000
"""The libraries make half a million objects that stay, and hardly any cycle: looking for cycles after every
700 of them, as Python does, is a fifth of a short command's time."""


def command() -> int:
    """Run the command line on the arguments of the process; return its exit code."""
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS)
    code = main()
    gc.freeze()  # the process ends: what is still alive need not be searched through once more
    return code


if __name__ == "__main__":
    sys.exit(command())
