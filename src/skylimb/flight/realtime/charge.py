"""A battery in flight: low for some seconds is low, a dip under load is none."""

from __future__ import annotations

from typing import NamedTuple

LASTS = 3.0
"""Seconds for which every charge that is reported has to be below the least one."""


class Charge(NamedTuple):
    """How long a battery has been low.

    Attributes:
        since: when it was first reported to be low, and has been ever since, s; None while it is not.
        low: whether it has lasted.
    """

    since: float | None = None
    low: bool = False

    def after(self, charge: float, least: float, now: float) -> Charge:
        """After a charge was reported; NaN counts as no report.

        Args:
            charge: per cent.
            least: with which a flight goes on, per cent.
            now: s.
        """
        if charge >= least:
            return Charge()
        since = now if self.since is None else self.since
        return Charge(since, now - since >= LASTS)
