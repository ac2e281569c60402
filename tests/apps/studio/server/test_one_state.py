"""What a page shows is what flies: after a branch, after a reload, on a second page, and in random order."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from flown_state import flown_gain, flown_push, flown_surface

STIFFNESS = "controller.translation.normalized_stiffness"
DAMPING = "controller.attitude.damping_ratio"
FRICTION = "surface.friction"
PATIENCE = 10.0


@pytest.fixture
def driven(studio: Any) -> Iterator[Any]:
    """A page that drives a flight that has just taken off."""
    with studio.page() as page:
        page.event("hello")
        page.say("restart")
        page.event("restarted")
        page.say("pause", paused=False)
        page.say("back", to="preset")
        page.state_where(lambda state: state["scene"] == page.hello["number"] and not state["over"])
        yield page


def shows_what_flies(page: Any, studio: Any) -> str:
    """What a page shows otherwise than it is flown; empty where all is the same."""
    session, state = studio.session, page.state
    if not state or state["scene"] != page.hello["number"]:
        return "no state of this flight yet"
    for number in range(len(session.live.flights)):
        for key in (STIFFNESS, DAMPING):
            told, flown = (
                page.value(key, number),
                flown_gain(session, key.removeprefix("controller."), number),
            )
            if told != pytest.approx(flown, abs=1e-12):
                return f"{key} of flight {number}: shown {told}, flown {flown}"
    surface = flown_surface(session)
    for name, flown in surface.items():
        if state["surface"][name] != pytest.approx(flown, abs=1e-9):
            return f"surface {name}: shown {state['surface'][name]}, flown {flown}"
    push = state["push"] and state["push"]["force"]
    if push != flown_push(session):
        return f"push: shown {push}, flown {flown_push(session)}"
    if (state["paused"], state["speed"]) != (studio.flight.paused, studio.flight.pacing.speed):
        return "mode"
    if state["controllers"] != session.flown or state["over"] != session.live.over:
        return "controllers or end"
    return ""


def settle(studio: Any, *pages: Any) -> None:
    """Listen until every page shows what flies, twice in a row."""
    until, good = time.monotonic() + PATIENCE, 0
    while good < 2:
        for page in pages:
            page.event("frame")
        told = [shows_what_flies(page, studio) for page in pages]
        good = 0 if any(told) else good + 1
        assert time.monotonic() < until, told


def test_a_branch_shows_what_flies_there(driven: Any, studio: Any) -> None:
    driven.frame_where(lambda frame: frame[0] > 0.4)
    driven.say("pause", paused=True)
    here = driven.state_where(lambda state: state["paused"]) and studio.session.live.time
    driven.say("pause", paused=False)
    driven.say("set", key=STIFFNESS, value=7.0, entry=0)
    driven.say("surface", position=[0.2, None, None])
    driven.say("surface", present=False)
    driven.state_where(lambda state: not state["surface"]["present"])
    driven.frame_where(lambda frame: frame[0] > here + 0.2)
    driven.say("rewind", time=here - 0.1)
    state = driven.state_where(lambda state: state["surface"]["present"])
    assert state["surface"]["position"] == pytest.approx(
        studio.session.live.flights[0].experiment.surface.position
    )
    assert driven.value(STIFFNESS)[0] != 7.0
    settle(studio, driven)


def test_a_page_that_is_loaded_again_or_comes_second_shows_what_flies(driven: Any, studio: Any) -> None:
    driven.say("set", key=STIFFNESS, value=6.0, entry=0)
    driven.state_where(lambda _: driven.value(STIFFNESS)[0] == 6.0)
    with studio.page("other") as other:
        other.state_where(lambda _: True)
        assert other.value(STIFFNESS)[0] == 6.0
        other.say("take over")
        other.say("set", key=STIFFNESS, value=1.3, entry=2)
        driven.state_where(lambda _: driven.value(STIFFNESS)[2] == 1.3)
        assert driven.value(STIFFNESS)[0] == other.value(STIFFNESS)[0] == 6.0
        settle(studio, driven, other)


def test_one_entry_of_each_of_two_flights_is_changed_and_the_others_stay(
    run_studio: Callable[..., Any], tmp_path: Path
) -> None:
    with run_studio(tmp_path, "hybrid", "hybrid") as studio, studio.page() as page:
        page.event("hello")
        page.state_where(lambda _: True)
        first, second = page.value(DAMPING, 0), page.value(DAMPING, 1)
        page.say("set", key=DAMPING, value=0.5, entry=1, flight=0)
        page.say("set", key=DAMPING, value=1.1, entry=2)
        page.state_where(lambda _: page.value(DAMPING, 1)[2] == 1.1)
        assert page.value(DAMPING, 0) == [first[0], 0.5, 1.1]
        assert page.value(DAMPING, 1) == [second[0], second[1], 1.1]
        settle(studio, page)


def test_an_own_controller_keeps_its_name(run_studio: Callable[..., Any], tmp_path: Path) -> None:
    own = str(Path(__file__).parents[4] / "examples" / "user_controller.py")
    with run_studio(tmp_path, own) as studio, studio.page() as page:
        assert page.event("hello")["controllers"][0] == own
        page.state_where(lambda state: state["controllers"] == [own])
        page.say("controllers", names=[own, "hybrid"])
        page.state_where(lambda state: state["controllers"] == [own, "hybrid"])
        page.say("restart")
        page.event("restarted")
        page.state_where(lambda state: state["controllers"] == [own, "hybrid"])


def test_what_was_meant_for_another_flight_is_refused(driven: Any, studio: Any) -> None:
    driven.frame_where(lambda frame: frame[0] > 0.3)
    seen = driven.state["version"]
    driven.say("rewind", time=0.1, seen=seen)
    driven.say("set", key=STIFFNESS, value=9.0, entry=0, seen=seen)
    assert "another" in driven.event("refused")["text"]
    settle(studio, driven)
    assert driven.value(STIFFNESS)[0] != 9.0
    driven.say("set", key=STIFFNESS, value=3.0, entry=0, seen=driven.state["version"])
    driven.state_where(lambda _: driven.value(STIFFNESS)[0] == 3.0)


def test_everything_is_brought_back_to_take_off_and_to_the_preset(driven: Any, studio: Any) -> None:
    preset = driven.value(STIFFNESS)
    driven.say("set", key=STIFFNESS, value=3.0, entry=0)
    driven.state_where(lambda _: driven.value(STIFFNESS)[0] == 3.0)
    driven.say("restart")
    driven.event("hello")
    driven.state_where(lambda state: state["scene"] == driven.hello["number"])
    driven.say("set", key=STIFFNESS, value=4.0, entry=1)
    driven.say("surface", friction=0.1, tilt=[0.2, None])
    driven.state_where(lambda state: state["surface"]["friction"] == 0.1)
    driven.say("back", to="take-off")
    driven.state_where(lambda state: state["surface"]["friction"] != 0.1)
    assert driven.value(STIFFNESS) == [3.0, *preset[1:]]
    driven.say("back", to="preset", key=STIFFNESS)
    driven.state_where(lambda _: driven.value(STIFFNESS) == preset)
    settle(studio, driven)


def test_a_lost_flight_is_one_press_away_from_the_last_good_gains(driven: Any, studio: Any) -> None:
    driven.say("speed", times=10.0)
    driven.say("set", key=STIFFNESS, value=3.0, entry=0)
    begun = driven.frame()[0]
    driven.frame_where(lambda frame: frame[0] > begun + 2.5)
    driven.say("set", key="controller.attitude.normalized_stiffness", value=[4000.0, 4000.0, 4000.0])
    driven.state_where(lambda state: state["over"] and "lost" not in state["verdict"][0][:0])
    assert "came to its end" not in driven.state["verdict"][0]
    driven.say("recover")
    driven.event("hello")
    driven.state_where(lambda state: state["scene"] == driven.hello["number"] and not state["over"])
    assert driven.value(STIFFNESS)[0] == 3.0
    settle(studio, driven)


def walk(studio: Any, steps: int, seed: int) -> None:
    """Two pages do things in random order, come and go; after each step both show what flies."""
    draw = random.Random(seed)
    with ExitStack() as open_pages:
        names = ["first", "second"]
        stacks = [open_pages.enter_context(ExitStack()) for _ in names]
        pages = [stack.enter_context(studio.page(name)) for stack, name in zip(stacks, names, strict=True)]
        driver = 0
        pages[0].say("take over")
        for _ in range(steps):
            page = pages[driver]
            seen = {"seen": page.state["version"]} if page.state and draw.random() < 0.5 else {}
            match draw.randrange(14):
                case 0 | 1:
                    page.say(
                        "set",
                        key=STIFFNESS,
                        value=round(draw.uniform(2, 4), 3),
                        entry=draw.randrange(3),
                        **seen,
                    )
                case 2:
                    page.say(
                        "set",
                        key=DAMPING,
                        value=round(draw.uniform(0.7, 1.3), 3),
                        entry=draw.randrange(3),
                        **seen,
                    )
                case 3:
                    place: list[float | None] = [None, None, None]
                    place[draw.randrange(3)] = round(draw.uniform(0, 0.1), 3)
                    page.say("surface", position=place, **seen)
                case 4:
                    page.say(
                        "surface",
                        **draw.choice(
                            [{"present": False}, {"present": True}, {"friction": 0.3}, {"tilt": [0.1, None]}]
                        ),
                    )
                case 5:
                    page.say(
                        "poke", link="link1", point=[0, 0, 0], force=[0, round(draw.uniform(0.1, 1), 3), 0]
                    )
                case 6:
                    page.say("release")
                case 7:
                    page.say("rewind", time=round(draw.uniform(0, studio.session.live.time), 2), **seen)
                case 8:
                    page.say(draw.choice(["undo", "redo"]), **seen)
                case 9:
                    page.say(
                        "jump",
                        branch=draw.choice([*{way["number"] for way in page.state.get("branches", [])}, 99]),
                    )
                case 10:
                    page.say("back", to=draw.choice(["take-off", "preset"]))
                case 11:
                    page.say(*draw.choice([("restart",), ("recover",)]))
                case 12:
                    driver = 1 - driver
                    pages[driver].say("take over")
                case 13:  # a page is loaded again
                    which = draw.randrange(2)
                    stacks[which].close()
                    pages[which] = stacks[which].enter_context(studio.page(names[which]))
                    if names[which] == "first":
                        driver = 0  # it asks for the seat
            settle(studio, *pages)
        pages[driver].say("release")


@pytest.mark.parametrize("seed", range(12))
def test_two_pages_show_what_flies_at_every_step(studio: Any, seed: int) -> None:
    studio.speed(4.0)
    walk(studio, 12, seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 600))
def test_two_pages_show_what_flies_at_every_step_of_500_walks(studio: Any, seed: int) -> None:
    studio.speed(4.0)
    walk(studio, 12, seed)
