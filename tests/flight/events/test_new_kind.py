"""A kind of event that nobody has met: one file and one line in the list of kinds: all drivers agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar, Literal

import numpy as np
import pytest

from short_flights import HOLD
from skylimb.base.errors import UnknownNameError, unknown_name
from skylimb.base.keys import Key, configuration
from skylimb.flight.drivers.native import fly_native, native_available
from skylimb.flight.events import EVENTS
from skylimb.flight.events.event import Event, EventContext, ModelRows, Place
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off


@configuration
class Flutter(Event):
    """A rotor loses a part of its thrust."""

    rotor: Annotated[str, Key("", "name of the rotor")]
    left: Annotated[float, Key("", "thrust that is left, over commanded", low=0.0, high=1.5)] = 0.0
    kind: Annotated[Literal["flutter"], Key("", "kind of event")] = field(default="flutter", kw_only=True)
    on: ClassVar[Literal["controller", "plant"]] = "plant"

    @property
    def words(self) -> str:
        return f"{self.rotor} at {self.left:g} of its thrust"

    def require(self, context: EventContext) -> None:
        names = [one.name for one in context.robot.description.rotors]
        if self.rotor not in names:
            raise unknown_name("rotor of an event", self.rotor, names)

    @classmethod
    def effect(cls, events: Sequence[Flutter], context: EventContext, times: np.ndarray) -> ModelRows:
        assert context.plant is not None
        names = [one.name for one in context.robot.description.rotors]
        first = context.plant.model.actuator_gainprm[: len(names), 0]
        values = np.tile(first, (len(times), 1))
        for event in sorted(events, key=lambda one: one.time):
            rotor = names.index(event.rotor)
            values[times >= event.time - 1e-9, rotor] = event.left * first[rotor]
        places = tuple(Place("actuator_gainprm", i, 1, i) for i in range(len(names)))
        return ModelRows(places, values)


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(EVENTS, "flutter", Flutter)


def weak(rotor: str) -> dict[str, object]:
    return {**HOLD, "events": [{"kind": "flutter", "time": 0.5, "rotor": rotor, "left": 0.85}]}


@pytest.mark.skipif(not native_available(), reason="no C compiler")
def test_every_driver_flies_it_alike_and_leaves_the_plant_as_it_was() -> None:
    (whole,) = take_off("paper", ("hybrid",), set=HOLD)
    (takeoff,) = take_off("paper", ("hybrid",), set=weak(whole.robot.description.rotors[1].name))
    compiled, native, without = fly_here(takeoff), fly_native([takeoff])[0], fly_here(whole)
    np.testing.assert_array_equal(native.signals[: native.ticks], compiled.signals[: compiled.ticks])
    before = int(0.5 / takeoff.period)
    same = compiled.signal("configuration")[:before], without.signal("configuration")[:before]
    np.testing.assert_array_equal(*same)
    assert not np.array_equal(compiled.signal("configuration"), without.signal("configuration"))
    np.testing.assert_array_equal(takeoff.plant.model.actuator_gainprm, whole.plant.model.actuator_gainprm)


def test_its_own_mistakes_are_refused_by_name() -> None:
    with pytest.raises(UnknownNameError, match="unknown rotor of an event 'rotr1'; did you mean 'rotor1'"):
        take_off("paper", ("hybrid",), set=weak("rotr1"))
