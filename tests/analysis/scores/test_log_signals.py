"""Phases, axes and stretches of time."""

import json

import numpy as np
import pytest

from skylimb.analysis.scores.signals import (
    adapting,
    common_events,
    contact_transitions,
    events_of,
    in_contact,
    in_phase,
    phase_names,
    spans,
    surface_of,
)
from skylimb.base.errors import UnknownNameError


def test_phases(make_log):
    log = make_log(slide=6.0)
    assert list(phase_names(log)) == ["hover", "tare", "approach", "settle", "slide", "retreat", "hover_end"]
    assert in_phase(log, "slide").sum() == 1200
    with pytest.raises(UnknownNameError, match="did you mean 'slide'"):
        in_phase(log, "slides")
    assert not in_phase(log.drop_vars("phase"), "slide").any()


def test_spans():
    time = np.arange(10.0)
    mask = np.array([1, 1, 0, 0, 1, 0, 1, 1, 1, 0], dtype=bool)
    assert spans(time, mask) == [(0.0, 1.0), (4.0, 4.0), (6.0, 8.0)]
    assert spans(time, mask, bridge=2.0) == [(0.0, 1.0), (4.0, 8.0)]
    assert spans(time, ~mask & False) == []
    assert spans(time, mask | True) == [(0.0, 9.0)]


def test_contact_and_adaptation(make_log):
    log = make_log("hybrid")
    assert in_contact(log).sum() == (log.contact == 1).sum()
    assert adapting(log).any()
    assert not adapting(make_log("pid")).any()
    bare = log.drop_vars(["contact", "reach_command"])
    assert not in_contact(bare).any()
    assert not adapting(bare).any()


def test_transitions_of_the_contact(make_log):
    log = make_log()
    assert contact_transitions(log) == []
    entry = [2.5, "slide", "lost", "no force"]
    [change] = contact_transitions(log.assign_attrs(contact_transitions=json.dumps([entry])))
    assert change == tuple(entry)
    assert (change.after, change.reason) == ("lost", "no force")


def test_a_log_without_a_surface_has_none(make_log):
    log = make_log()
    assert (surface_of(log) or {})["kind"] == "board"
    assert surface_of(log.assign_attrs(surface="")) is None
    assert surface_of(log.assign_attrs(surface='{"kind": "air"}')) is None


def test_what_happened_is_told_in_the_order_of_time_up_to_the_flights_end(make_log, make_event, happening):
    log = make_log(slide=1.0)
    assert events_of(log) == []
    later, sooner = make_event(time=3.0, force=[1.0, 0.0, 0.0]), make_event("gain", 2.0, 0.5, "a to 2")
    first, second = events_of(happening(log, later, sooner, make_event(time=100.0)))
    assert (first.kind, first.time, first.duration, first.words) == ("gain", 2.0, 0.5, "a to 2")
    assert second.table["force"] == [1.0, 0.0, 0.0]


def test_flights_share_their_events_also_where_one_ended_earlier(make_log, make_event, happening):
    assert common_events([]) == []
    log = happening(make_log(slide=1.0), make_event(time=1.0), make_event(time=3.0))
    lost = log.isel(time=slice(0, 400))
    assert len(events_of(lost)) == 1
    assert common_events([lost, log]) == events_of(log)
    other = happening(log, make_event(time=1.5))
    assert common_events([log, other]) is None
    assert common_events([log, happening(log)]) == events_of(log)
