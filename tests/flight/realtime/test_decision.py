"""What a guarded flight does at a tick: every case of the table."""

from itertools import product

import pytest

from skylimb.flight.realtime.decision import Action, Evidence, decide
from skylimb.flight.realtime.watchdog import State

CASES = [
    (broken_off, Evidence(judged, *flags))
    for broken_off, judged, flags in product((False, True), State, product((False, True), repeat=4))
]
CONTROLLED = {Action.FLY, Action.GO_BACK}


def test_every_case_has_one_answer() -> None:
    assert len(CASES) == 96
    assert {decide(*case).action for case in CASES} == set(Action)


@pytest.mark.parametrize(("broken_off", "seen"), CASES)
def test_the_rules_hold_in_every_case(broken_off: bool, seen: Evidence) -> None:
    decision = decide(broken_off, seen)
    action = decision.action
    # There is no way back from broken off, and one way in: nothing measured or commanded for too long.
    assert decision.broken_off == (broken_off or seen.overdue or seen.judged == State.RETREAT)
    assert decision.held == (seen.missed or seen.judged == State.HOLD)
    # A flight that was broken off does not follow its mission, and no other one leaves it.
    assert action != (Action.FLY if decision.broken_off else Action.GO_BACK)
    # What was never commanded cannot be repeated, and nobody descends who never measured.
    assert seen.commanded or action in CONTROLLED
    assert seen.measured or action != Action.DESCEND
    if seen.commanded:
        # The controller is asked about good measurements only, and at its time.
        good = seen.measured and not decision.held and seen.judged == State.FLY
        assert (action in CONTROLLED) == good
        # Blind, the robot comes down; a moment without measurements is waited for.
        long = seen.judged == State.RETREAT or (broken_off and seen.overdue and decision.held)
        assert (action == Action.DESCEND) == (seen.measured and long)


@pytest.mark.parametrize(
    ("broken_off", "seen", "action"),
    [
        (False, Evidence(State.FLY, False, False, True, True), Action.FLY),
        (False, Evidence(State.FLY, True, False, True, True), Action.HOLD),
        (False, Evidence(State.HOLD, False, False, True, True), Action.HOLD),
        (False, Evidence(State.RETREAT, False, False, True, True), Action.DESCEND),
        (False, Evidence(State.RETREAT, False, False, False, True), Action.HOLD),
        (False, Evidence(State.FLY, False, True, True, True), Action.GO_BACK),
        (True, Evidence(State.FLY, False, False, True, True), Action.GO_BACK),
        (True, Evidence(State.FLY, True, False, True, True), Action.HOLD),
        (True, Evidence(State.RETREAT, True, False, True, True), Action.DESCEND),
        (False, Evidence(State.HOLD, False, True, True, True), Action.HOLD),
        (True, Evidence(State.HOLD, False, True, True, True), Action.DESCEND),
        (True, Evidence(State.FLY, True, True, True, True), Action.DESCEND),
    ],
)
def test_the_table(broken_off: bool, seen: Evidence, action: Action) -> None:
    assert decide(broken_off, seen).action == action
