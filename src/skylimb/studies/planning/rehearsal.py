"""Postures flown before one is proposed: a margin at rest does not say how a controller flies there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skylimb.base.errors import SkylimbError
from skylimb.control.controller import Controller
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.flying import fly_here
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off

DRAWS = 3
"""Flights of each posture; their noise is the same for all postures."""

_ALIKE = {"touch": (0.01, 0.0), "spread": (0.005, 0.03), "line": (2e-4, 0.03)}
"""By how much postures differ that fly alike, and by what share: noise moves medians of `DRAWS` so far."""
_SCORES = "contact_force_normal_mean", "contact_fraction", "contact_force_normal_std", "pen_line_rms"


@dataclass(frozen=True)
class Rehearsal:
    """How an experiment was flown in a posture, medians of `DRAWS` flights.

    Attributes:
        lost: why a flight was lost, or refused before take-off; empty where none was.
        force: mean normal force while in touch, N.
        touch: share of the slide in touch.
        spread: standard deviation of the normal force, N.
        line: root mean square distance of the pen from its line, m.
    """

    lost: str = ""
    force: float = float("nan")
    touch: float = float("nan")
    spread: float = float("nan")
    line: float = float("nan")

    def worse_than(self, other: Rehearsal) -> str:
        """In what it flew worse than another posture, in words; empty where in nothing."""
        found = []
        for name, scale, text in (
            ("touch", -1.0, "in touch {:.2f} of the time ({:.2f} in its own)"),
            ("spread", 1.0, "the force spreads by {:.2f} N ({:.2f} in its own)"),
            ("line", 1.0, "{:.1f} mm off its line ({:.1f} in its own)"),
        ):
            here, there = getattr(self, name), getattr(other, name)
            apart, share = _ALIKE[name]
            if scale * (here - there) > apart + share * abs(there):
                unit = 1e3 if name == "line" else 1.0
                found.append(text.format(unit * here, unit * there))
        return "; ".join(found)


def rehearse(experiment: Experiment, controller: Controller) -> Rehearsal:
    """Fly an experiment `DRAWS` times, with other noise each; the first that is lost or refused ends it."""
    scores = []
    for draw in range(DRAWS):
        try:
            (takeoff,) = take_off(replace(experiment, seed=experiment.seed + draw), (controller,))
        except SkylimbError as error:
            return Rehearsal(str(error))
        flight = fly_here(takeoff)
        if flight.cause:
            return Rehearsal(flight.cause)
        metrics = scored_run(takeoff, flight).metrics
        found = (metrics.get(name) for name in _SCORES)
        scores.append([float("nan") if score is None else float(score) for score in found])
    return Rehearsal("", *map(float, np.median(scores, axis=0)))
