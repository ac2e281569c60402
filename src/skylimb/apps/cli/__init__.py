"""The command line: every verb is one call of a public function.

Nothing here is needed to use skylimb from Python. Importing this package loads neither the simulator nor the
analysis, so that `skylimb --help` answers at once.
"""

from skylimb.apps.cli.main import main

__all__ = ["main"]
