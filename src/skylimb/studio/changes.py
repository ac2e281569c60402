"""What people do to a flight, as entries of its experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from skylimb.experiments.experiment import Experiment
from skylimb.simulation.disturbance import PushConfig
from skylimb.simulation.gain_changes import GainChange

BLEND = 0.1
"""How long a gain takes to its new value, s."""


def with_gain(experiment: Experiment, time: float, key: str, value: Any) -> Experiment:
    """The experiment with a gain that changes at `time` (s); one of the same moment is replaced."""
    if isinstance(value, Sequence):
        value = tuple(map(float, value))
    change = GainChange(time=time, key=key, value=value, blend=BLEND)
    others = [one for one in experiment.gain_changes if (one.time, one.key) != (time, key)]
    return dataclasses.replace(experiment, gain_changes=(*others, change))


def with_push(experiment: Experiment, push: PushConfig) -> Experiment:
    """The experiment with one more push."""
    return dataclasses.replace(experiment, pushes=(*experiment.pushes, push))


def without_push(experiment: Experiment, held: PushConfig, time: float) -> Experiment:
    """The experiment with a push that ends at `time` (s), or never was where it would begin then."""
    shorter = round(time - held.start, 9)
    ended = (dataclasses.replace(held, duration=shorter),) if shorter > 0.0 else ()
    others = tuple(one for one in experiment.pushes if one is not held)
    return dataclasses.replace(experiment, pushes=(*others, *ended))
