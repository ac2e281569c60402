"""A pen that is lifted between two strokes leaves the surface and comes back, whoever flies it."""

import numpy as np
import pytest

import skylimb
from skylimb.analysis.scores.signals import contact_transitions, in_phase

TWO_STROKES = {
    "phases.hover": 0.5,
    "phases.tare": 1.0,
    "phases.settle": 2.5,
    "phases.hover_end": 0.2,
    "approach.speed": 0.1,
    "trajectory.shape": "drawing",
    "trajectory.text": "11",
    "trajectory.width": 0.1,
    "trajectory.speed": 0.1,
    "trajectory.feedforward": "full",
}


@pytest.mark.parametrize(
    ("controller", "experiment"),
    [("following", "cylinder_convex"), ("following", "paper"), ("hybrid", "paper")],
)
def test_the_pen_leaves_between_two_strokes_and_comes_back(controller: str, experiment: str) -> None:
    # Away until two seconds before the touch: that takes a search of this speed.
    quick = {"controller.contact.approach_speed": 0.035} if controller == "following" else {}
    run = skylimb.run(experiment, controller=controller, set={**TWO_STROKES, **quick})
    assert run.status == "OK", run.cause
    log, time = run.log, run.log.time.values
    lift, contact = in_phase(log, "lift"), log.contact.values > 0
    [begin, end] = time[np.flatnonzero(lift)[[0, -1]]]
    away = (time > begin + 2.0) & (time < end - 2.0)
    assert away.sum() > 50
    assert not contact[away].any()
    assert log.surface_gap.values[away].min() > 0.025
    assert contact[(time > end) & in_phase(log, "slide")].mean() > 0.9
    assert run.metrics["contact_losses"] == 0
    assert run.metrics["contact_fraction"] > 0.95
    if controller == "following":
        states = [change.after for change in contact_transitions(log)]
        touch = ["approach", "settle", "slide", "retreat"]
        assert states == [*touch, "free", *touch, "free"][: len(states)]
        assert len(states) >= 9
