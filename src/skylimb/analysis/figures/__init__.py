"""The paper's figures from any set of runs.

Each function of `__init__.pyi` takes runs by name and returns a matplotlib figure.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
