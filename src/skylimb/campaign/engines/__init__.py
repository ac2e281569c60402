"""Where a campaign's flights are flown: in this process, on this machine's cores, or on a cluster.

An engine takes jobs and hands back what came of them, in any order. It keeps no results and retries nothing;
what to do about a worker that died is the coordinator's business.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from skylimb.campaign.bench import Flown, Job


class Done(NamedTuple):
    """Jobs that were flown, and what came of each."""

    jobs: Sequence[Job]
    flown: Sequence[Flown]


class Died(NamedTuple):
    """Jobs whose worker died over them.

    Attributes:
        jobs: what it had in hand.
        final: whether the engine has tried often enough itself.
    """

    jobs: Sequence[Job]
    final: bool = False


class Engine(Protocol):
    """What a coordinator asks of an engine."""

    @property
    def free(self) -> int:
        """How many more batches can be handed over now."""
        ...

    @property
    def flying(self) -> int:
        """How many batches are in hand."""
        ...

    def submit(self, jobs: Sequence[Job]) -> bool:
        """Hand over a batch; False when nobody could take it after all."""
        ...

    def wait(self, timeout: float) -> list[Done | Died]:
        """What has come back, after at most `timeout` seconds; maybe nothing."""
        ...

    def close(self, now: bool = False) -> None:
        """Let the workers go; `now` without waiting for what they have in hand."""
        ...


__all__ = ["Died", "Done", "Engine"]
