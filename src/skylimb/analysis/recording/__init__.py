"""The run record: what a flight left behind, in memory and on disk.

This package knows nothing of simulation or control, so that the log of a real flight is as good a `Run` as a
simulated one. Its names (`__init__.pyi`) are loaded when they are first used: who writes a file needs no
dataset.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
