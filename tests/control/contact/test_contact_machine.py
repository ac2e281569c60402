"""The contact's state machine: every transition, and what holds whatever happens."""

from typing import Any

import casadi as ca
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout
from skylimb.control.contact.machine import (
    APPROACH,
    CALM,
    CLEAR,
    FREE,
    LOST,
    NO_FORCE,
    NOTHING,
    OVER,
    REASONS,
    RECONTACT,
    RESTED,
    RETREAT,
    SETTLE,
    SLIDE,
    START,
    STATES,
    TOUCHED,
    WANTED,
    Cues,
    MachineGains,
    MachineState,
    advance,
)

GAINS, DT = MachineGains(), 0.005
TOUCHING = {"touch": 1.0, "force": 0.0, "smooth_force": 1.0, "beyond": 0.0, "sunk": 0.0, "clear": 0.0}


def machine(state: float, **changes: float) -> MachineState:
    return MachineState(state, START, 0.0, 0.0, 0.0, 0.0, 0.0)._replace(**changes)


def after(before: MachineState, **cues: float) -> MachineState:
    found = advance(GAINS, before, Cues(**{**TOUCHING, **cues}), DT)
    return MachineState(*(float(value) for value in found))


@pytest.mark.parametrize(
    ("before", "cues", "state", "reason"),
    [
        (machine(FREE), {}, APPROACH, WANTED),
        (machine(FREE), {"touch": 0.0}, FREE, START),
        (machine(FREE, given_up=1.0), {}, FREE, START),
        (machine(APPROACH), {}, APPROACH, START),
        (machine(APPROACH, strong=0.012), {"force": 0.6}, SETTLE, TOUCHED),
        (machine(APPROACH, strong=0.005), {"force": 0.6}, APPROACH, START),
        (machine(APPROACH), {"beyond": 0.26}, RETREAT, NOTHING),
        (machine(APPROACH), {"touch": 0.0}, RETREAT, OVER),
        (machine(SETTLE, since=0.5), {}, SETTLE, START),
        (machine(SETTLE, since=1.01), {}, SLIDE, CALM),
        (machine(SETTLE, weak=0.4), {"smooth_force": 0.1}, LOST, NO_FORCE),
        (machine(SLIDE, weak=0.4), {"smooth_force": 0.1}, LOST, NO_FORCE),
        (machine(SLIDE, weak=0.4), {"smooth_force": 0.3}, SLIDE, START),
        (machine(SLIDE, weak=0.4), {"smooth_force": 0.1, "touch": 0.0}, RETREAT, OVER),
        (machine(LOST, since=0.3), {}, LOST, START),
        (machine(LOST, since=0.51), {}, RECONTACT, RESTED),
        (machine(LOST, strong=0.012), {"force": 0.6}, SETTLE, TOUCHED),
        (machine(RECONTACT, strong=0.012), {"force": 0.6}, SETTLE, TOUCHED),
        (machine(RECONTACT, slid=1.0), {"sunk": 0.11}, RETREAT, NOTHING),
        (machine(RECONTACT), {"sunk": 0.11}, RECONTACT, START),
        (machine(RECONTACT), {"sunk": 0.11, "beyond": 0.26}, RETREAT, NOTHING),
        (machine(RECONTACT), {"sunk": 0.05}, RECONTACT, START),
        (machine(RETREAT), {}, RETREAT, START),
        (machine(RETREAT), {"clear": 1.0}, FREE, CLEAR),
        (machine(RETREAT), {"clear": 1.0, "touch": 0.0}, FREE, CLEAR),
    ],
)
def test_every_transition(before: MachineState, cues: dict[str, float], state: float, reason: float) -> None:
    found = after(before, **cues)
    assert (STATES[int(found.state)], REASONS[int(found.reason)]) == (
        STATES[int(state)],
        REASONS[int(reason)],
    )
    changed = state != before.state
    assert found.since == pytest.approx(0.0 if changed else before.since + DT)
    if changed:
        assert (found.weak, found.strong) == (0.0, 0.0)


def test_a_surface_that_is_not_there_is_not_looked_for_again_until_the_next_stroke() -> None:
    missed = after(machine(APPROACH), beyond=1.0)
    assert missed.given_up == 1.0
    free = after(missed, clear=1.0)
    assert (free.state, free.given_up) == (FREE, 1.0)
    assert after(free).state == FREE
    untouched = after(free, touch=0.0)
    assert untouched.given_up == 0.0
    assert after(untouched).state == APPROACH


def test_a_slide_is_remembered_until_the_mission_wants_no_touch() -> None:
    lost = after(machine(SLIDE, weak=0.4), smooth_force=0.1)
    assert (lost.state, lost.slid) == (LOST, 1.0)
    assert after(lost, touch=0.0).slid == 0.0


def test_a_flicker_of_force_is_no_touch_and_a_flicker_of_none_no_loss() -> None:
    state = machine(APPROACH)
    for tick in range(50):
        state = after(state, force=0.6 if tick % 3 else 0.0)
    assert state.state == APPROACH
    state = machine(SLIDE)
    for tick in range(500):
        state = after(state, smooth_force=0.0 if tick % 30 else 1.0)
    assert state.state == SLIDE


number = st.floats(-1.0, 3.0)
flag = st.sampled_from([0.0, 1.0])
sensing = st.builds(Cues, flag, number, number, number, number, flag)
MAY_FOLLOW = {
    FREE: {APPROACH},
    APPROACH: {SETTLE, RETREAT},
    SETTLE: {SLIDE, LOST, RETREAT},
    SLIDE: {LOST, RETREAT},
    LOST: {SETTLE, RECONTACT, RETREAT},
    RECONTACT: {SETTLE, RETREAT},
    RETREAT: {FREE},
}


@given(st.lists(sensing, min_size=1, max_size=60), st.floats(0.001, 0.3))
def test_the_state_is_always_a_state_and_changes_along_the_arrows(cues: list[Cues], dt: float) -> None:
    state = MachineState()
    for cue in cues:
        new = MachineState(*(float(value) for value in advance(GAINS, state, cue, dt)))
        assert new.state in MAY_FOLLOW
        assert 0.0 <= new.reason < len(REASONS)
        assert new.state == state.state or new.state in MAY_FOLLOW[state.state]
        assert (new.reason != state.reason) <= (new.state != state.state)
        assert min(new.since, new.weak, new.strong) >= 0.0
        assert new.given_up in (0.0, 1.0)
        state = new


@given(st.lists(sensing, max_size=40), sensing)
def test_where_no_touch_is_wanted_it_is_free_within_two_ticks(cues: list[Cues], last: Cues) -> None:
    state = MachineState()
    for cue in cues:
        state = advance(GAINS, state, cue, 0.05)
    for _ in range(2):
        state = advance(GAINS, state, last._replace(touch=0.0, clear=1.0), 0.05)
    assert float(state.state) == FREE
    for _ in range(5):
        state = advance(GAINS, state, last._replace(touch=0.0), 0.05)
    assert float(state.state) == FREE


@given(st.sampled_from(sorted(MAY_FOLLOW)), number, number, number, sensing)
def test_symbols_and_numbers_agree(
    state: float, since: float, weak: float, strong: float, cues: Cues
) -> None:
    before = machine(state, since=since, weak=weak, strong=strong)
    states, senses = Layout(before), Layout(cues)
    given_state, given_cues = states.pack(before), senses.pack(cues)
    wanted = states.pack(advance(GAINS, before, cues, DT))
    found: Any = _compiled(states, senses)(given_state, given_cues)
    assert found.full().ravel().tolist() == pytest.approx(wanted.tolist(), abs=1e-15)


_functions: list[ca.Function] = []


def _compiled(states: Layout[MachineState], senses: Layout[Cues]) -> ca.Function:
    if not _functions:
        x, s = ca.SX.sym("x", states.size), ca.SX.sym("s", senses.size)
        new = advance(GAINS, states.unpack(x), senses.unpack(s), DT)
        _functions.append(ca.Function("machine", [x, s], [ca.densify(states.pack(new))]))
    return _functions[0]


@pytest.mark.parametrize("values", [{"touch_force": 0.0}, {"lost_force": -1.0}, {"settle_time": -1.0}])
def test_gains_that_make_no_sense(values: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match=next(iter(values))):
        MachineGains(**values)


def test_it_begins_free_with_all_clocks_at_zero() -> None:
    assert MachineState() == (FREE, START, 0.0, 0.0, 0.0, 0.0, 0.0)
