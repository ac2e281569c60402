"""A controller that stays keeps its gains, and nothing counts as changed that nobody changed."""

import pytest

from skylimb.apps.studio.key_edits import value_now
from told_session import Session

GAIN = "controller.attitude.damping_ratio"
TUNED = [0.5, 0.6, 0.7]


@pytest.fixture
def session(short, tmp_path):
    return Session("paper", ("hybrid",), set=short, out=tmp_path / "studio")


def changed(session):
    """Keys whose values are not those of the preset."""
    return {
        key
        for (key, number), preset in session.preset.items()
        if list_of(value_now(session.live, key, number)) != list_of(preset)
    }


def list_of(value):
    return list(value) if isinstance(value, tuple) else value


def test_a_controller_that_stays_keeps_its_gains(session):
    own = value_now(session.live, GAIN, 0)
    session.advance(10)
    session.set_key(GAIN, TUNED, 0)
    session.set_controllers(["pid", "hybrid"])
    assert list(value_now(session.live, GAIN, 1)) == TUNED
    assert session.preset[GAIN, 1] == own
    assert changed(session) == {GAIN}
    session.set_controllers(["hybrid"])
    assert list(value_now(session.live, GAIN, 0)) == TUNED
    session.back(True)
    assert list_of(value_now(session.live, GAIN, 0)) == own
    session.undo()  # of the way back
    session.undo()  # of the choice of one
    session.undo()  # of the choice of two
    assert (session.flown, list(value_now(session.live, GAIN, 0))) == (["hybrid"], TUNED)
    assert changed(session) == {GAIN}


def test_the_last_good_gains_are_of_their_controller(session):
    session.set_key(GAIN, TUNED, 0)
    session.advance(450)
    session.set_controllers(["pid", "hybrid"])
    session.recover()
    assert list(value_now(session.live, GAIN, 1)) == TUNED
    session.set_controllers(["pid"])
    session.recover()
    assert (session.flown, changed(session)) == (["pid"], set())


def test_what_a_controller_says_of_its_experiment_is_nobodys_change(session):
    assert not value_now(session.live, "supervisor.on")
    session.set_controllers(["drawing"])
    assert value_now(session.live, "supervisor.on")
    assert changed(session) == set()
    session.set_key("supervisor.on", False)
    assert changed(session) == {"supervisor.on"}
    session.back(True)
    assert value_now(session.live, "supervisor.on")
    assert changed(session) == set()


def test_keys_of_the_command_line_are_no_changes(session, short):
    assert changed(session) == set()
    session.set_key("phases.hover", 0.5)
    assert changed(session) == {"phases.hover"}
    session.back(True, "phases.hover")
    assert value_now(session.live, "phases.hover") == short["phases.hover"]
