"""Events: what happens to a flight besides what its mission asks: a push, a new gain, a rotor that fails, ...

A kind of event is one file here: a configuration that says when, what and for how long, what it needs to be
there, and what it does at every tick, in one of four ways that every driver of simulated flights has:

- numbers of the controller that are written before a tick (`GainRows`),
- numbers of the engine's model that are written before a tick's physics (`ModelRows`),
- numbers of the sensors, which are known before take-off (`TickRows`),
- wrenches on a body (`Wrench`).

So a new kind is a new file, a line in `EVENTS`, and its test. Start reading at `event.py`; `timeline.py` has
what all events of a flight do, and the checks that hold for all kinds.
"""

from skylimb.flight.events.body import BodyChange
from skylimb.flight.events.event import Event, EventContext, GainRows, ModelRows, Place, TickRows
from skylimb.flight.events.gain import GainChange
from skylimb.flight.events.joint import JointFault
from skylimb.flight.events.push import Push, Wrench
from skylimb.flight.events.rotor import RotorChange
from skylimb.flight.events.sensor import SensorFault
from skylimb.flight.events.surface import SurfaceChange
from skylimb.flight.events.tables import event_tables, events_from_mapping
from skylimb.flight.events.tick import LateTicks
from skylimb.flight.events.timeline import (
    ALL_KINDS,
    CONTROLLER_KINDS,
    EVENTS,
    OWN_PLANT_KINDS,
    PLANT_KINDS,
    Timeline,
    require_applied,
    require_events,
    timeline,
)
from skylimb.flight.events.wind import Wind

__all__ = [
    "ALL_KINDS",
    "CONTROLLER_KINDS",
    "EVENTS",
    "OWN_PLANT_KINDS",
    "PLANT_KINDS",
    "BodyChange",
    "Event",
    "EventContext",
    "GainChange",
    "GainRows",
    "JointFault",
    "LateTicks",
    "ModelRows",
    "Place",
    "Push",
    "RotorChange",
    "SensorFault",
    "SurfaceChange",
    "TickRows",
    "Timeline",
    "Wind",
    "Wrench",
    "event_tables",
    "events_from_mapping",
    "require_applied",
    "require_events",
    "timeline",
]
