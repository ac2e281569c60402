"""What an experiment commands is what a press is held to, whatever a law says."""

import json

import numpy as np
import pytest

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.commanded_force import RAMP, force_is_commanded, wanted_force
from skylimb.analysis.scores.force import force_error
from skylimb.analysis.scores.metrics import metrics

SLIDE = 4
WANTED = 2.0


@pytest.fixture
def commanded(make_log):
    """A flight whose experiment commands 2 N, and which presses with 1 N."""
    log = make_log(dt=0.02, error=(0.0, 0.0, 0.0))
    log = log.assign(contact_force_commanded=(("time",), np.full(log.sizes["time"], WANTED)))
    return log.assign_attrs(tolerances=json.dumps({"force": 0.1, "force_swing": 0.3}))


def saying(log, reference):
    return log.assign(contact_force_reference=(("time",), np.broadcast_to(reference, log.sizes["time"])))


def kept(log):
    return metrics(log)["checks"]["force"]["kept"]


@pytest.mark.parametrize("reference", [0.0, 1.0, 50.0, np.nan, -3.0])
def test_no_word_of_a_law_makes_another_force_right(commanded, reference):
    assert not kept(commanded)
    assert not kept(saying(commanded, reference))
    assert not kept(saying(commanded, commanded.contact_force_normal.values))


def test_a_law_that_commands_no_force_misses_the_commanded_one(commanded):
    scores = metrics(commanded)
    assert scores["done"] is False
    assert "the controller says of no force that it commands it" in scores["missed"][0]


def test_a_force_that_is_commanded_and_not_known_is_missed(commanded):
    scores = metrics(commanded.drop_vars("contact_force_normal"))
    assert scores["done"] is False
    assert scores["checks"]["force"] == {"value": None, "tolerance": 0.1, "kept": False}
    assert scores["missed"][0].endswith(": there is none to be judged")


def test_a_law_keeps_to_the_experiment_where_it_does(commanded):
    commanded.contact_force_normal[:] = WANTED
    assert kept(commanded)
    assert kept(saying(commanded, WANTED))


def test_the_laws_own_ramp_counts_at_both_ends_of_a_stroke(commanded):
    time, sliding = commanded.time.values, commanded.phase.values == SLIDE
    begin, end = time[sliding][[0, -1]]
    within = np.minimum(time - begin, end - time)
    ramped = saying(commanded, WANTED * np.clip(within / (0.5 * RAMP), 0.0, 1.0))
    assert np.array_equal(wanted_force(ramped)[sliding], ramped.contact_force_reference.values[sliding])
    ramped.contact_force_normal[:] = ramped.contact_force_reference
    assert force_error(Run("", "", ramped))["mean"] == pytest.approx(0.0, abs=1e-9)


def test_a_ramp_is_no_slower_than_it_may_be_and_none_stands_amid_a_stroke(commanded):
    time, sliding = commanded.time.values, commanded.phase.values == SLIDE
    within = np.minimum(time - time[sliding][0], time[sliding][-1] - time)
    least = WANTED * np.clip(within / RAMP, 0.0, 1.0)
    assert wanted_force(saying(commanded, 0.0))[sliding] == pytest.approx(least[sliding])
    for unsaid in (commanded, saying(commanded, np.nan)):
        assert (wanted_force(unsaid)[sliding] == WANTED).all()
    lost = saying(commanded, np.where(np.abs(within - 5.0) < 1.0, 0.0, WANTED))
    assert (wanted_force(lost)[sliding & (within > RAMP)] == WANTED).all()


def test_where_the_experiment_commands_none_the_laws_word_stands(commanded):
    silent = saying(commanded, 1.0)
    assert force_is_commanded(silent)
    assert not kept(silent)
    assert kept(silent.drop_vars("contact_force_commanded"))
    silent.contact_force_commanded[:] = np.nan
    assert kept(silent)
    assert not force_is_commanded(silent)
