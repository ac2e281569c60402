"""skylimb: simulate, control, measure and fly multi-link aerial robots in contact.

    import skylimb

    run = skylimb.run("paper", controller="hybrid", set={"surface.friction": 0.3})
    run.status, run.metrics, run.log["cog_position"]

The names of `__init__.pyi` are loaded when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
