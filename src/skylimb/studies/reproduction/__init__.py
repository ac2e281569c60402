"""The paper held against an ensemble: open values drawn from a declared prior, claims judged by count.

    from skylimb.studies.reproduction import reproduce

    if __name__ == "__main__":  # worker processes import this file
        outcome = reproduce("out/reproduction", draws=200)

Nothing is fitted: the prior (`prior.toml`) was written down before any ensemble was flown.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
