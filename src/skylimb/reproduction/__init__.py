"""The paper held against an ensemble: open values drawn from a declared prior, claims judged by count.

    from skylimb.reproduction import reproduce

    if __name__ == "__main__":  # worker processes import this file
        outcome = reproduce("out/reproduction", draws=200)

Nothing is fitted: the prior (`prior.toml`) was written down before any ensemble was flown.
"""

from skylimb.reproduction.prior import Prior, load_prior
from skylimb.reproduction.reproduce import Reproduction, reproduce
from skylimb.reproduction.result import Result

__all__ = ["Prior", "Reproduction", "Result", "load_prior", "reproduce"]
