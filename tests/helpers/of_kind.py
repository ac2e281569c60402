"""The events of an experiment that are of one kind."""

from typing import TypeVar

from skylimb.flight.events import Event
from skylimb.flight.experiments.experiment import Experiment

T = TypeVar("T", bound=Event)


def of_kind(experiment: Experiment, kind: type[T]) -> list[T]:
    return [event for event in experiment.events if isinstance(event, kind)]
