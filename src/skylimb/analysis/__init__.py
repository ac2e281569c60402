"""Metrics, figures, video and report of recorded flights.

It reads runs and nothing else, so that a real flight's log is as welcome as a simulated one. The names of
`__init__.pyi` are loaded when they are first used: scoring a flight should not pay for drawing it.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
