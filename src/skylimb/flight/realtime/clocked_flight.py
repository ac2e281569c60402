"""What a flight on a clock needs, of a simulated plant and a real robot alike: the guarded controller."""

from __future__ import annotations

import gc
import itertools
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from skylimb.analysis.recording.run import Run
from skylimb.control.cascade import Cascade
from skylimb.control.controller import is_traceable
from skylimb.control.loop.flight import Flight
from skylimb.control.loop.loop import Progress
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.drivers.machine_code import fastest
from skylimb.flight.plan import FlightPlan
from skylimb.flight.realtime.compiled_controller import CompiledController
from skylimb.flight.realtime.guard import GuardedController
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.timing import Timing


@dataclass(frozen=True)
class ClockedFlight:
    """A flight on the wall clock.

    Attributes:
        run: as of any flight, with `tick_late`, `tick_latency`, `tick_held` and `retreating` in its log.
        timing: how it kept to the clock.
        faults: how often each fault was met, by name.
    """

    run: Run
    timing: Timing
    faults: Mapping[str, int]


def compiled(plan: FlightPlan, tells: bool = False) -> Any:
    """The controller of a plan, compiled where it can be.

    Args:
        plan: of the flight.
        tells: whether a cascade's signals are to have what its laws add up.
    """
    controller = plan.controller
    if tells and isinstance(controller, Cascade):
        controller = replace(controller, tells=True)
    return CompiledController(controller, plan.period, fastest) if is_traceable(controller) else controller


def guarded_controller(
    plan: FlightPlan, clock: Pacer | None, limits: Limits | None = None
) -> GuardedController:
    """The controller of a plan under its guard; the experiment says the limits where nobody else does."""
    return GuardedController(compiled(plan), plan.robot, clock, limits or plan.experiment.supervisor)


def timing_of(flight: Flight, period: float) -> Timing:
    """How a guarded flight kept to the clock."""
    late, latency, held = (flight.signal(name) for name in ("tick_late", "tick_latency", "tick_held"))
    return Timing(period, late, latency, held > 0.0)


@contextmanager
def without_garbage() -> Iterator[None]:
    """No pause for collecting garbage; what is there already is not looked at again."""
    enabled = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        if enabled:
            gc.enable()


def ticks_on_clock(clock: Pacer) -> Iterator[int]:
    """The number of every tick when it is due, with no pause for collecting garbage."""
    with without_garbage():
        clock.start(clock.period)
        for k in itertools.count():
            clock.wait(k)
            yield k


def each_second(clock: Pacer, progress: Progress | None, ticks: int, done: int, total: int) -> None:
    """Call `progress` once a second, with how much of the mission was flown after so many ticks."""
    if progress is not None and ticks % round(1.0 / clock.period) == 0:
        progress(min(done, total), total)
