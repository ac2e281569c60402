"""A hover that tests share is to each what one of its own would be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import steered
import wired
from moment import Moment
from skylimb.analysis.exchange import lab_topics as topics


def test_a_hover_that_is_brought_back_flies_to_the_bit_as_one_of_its_own() -> None:
    own = wired.Wire()
    own.hover()
    shared = wired.in_hover()
    shared.spoil = lambda one: None if one.topic is topics.MOCAP else one
    shared.robot.plant._model.actuator_gainprm[:] = 0.0
    shared.fly(0.7)
    for wire in (own, shared := wired.in_hover()):
        wire.fly_alone(0.1)
        wire.restart()
        wire.fly(0.3)
    np.testing.assert_array_equal(own.where, shared.where)
    assert own.said == shared.said
    assert own.pilot.faults == shared.pilot.faults


def test_a_robot_that_is_steered_hovers_again() -> None:
    first, ended = steered.in_hover(), list[Any]()
    for _ in range(2):
        first.fly(0.2)
        ended.append((first.k, first.pacer.time(), first.plant.truth().position))
        assert steered.in_hover() is first
    np.testing.assert_equal(ended[0], ended[1])


def test_what_cannot_be_brought_back_is_no_moment() -> None:
    with pytest.raises(TypeError, match="generator"):
        Moment([(k for k in range(2))])
