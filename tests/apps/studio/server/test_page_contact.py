"""A short flight in contact in a real browser: what is done when it is over, looked back at, or drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright import sync_api

from chromium import needs_chromium, silent_page, until, wait_for
from flown_state import flown_gain
from of_kind import of_kind
from short_flights import CIRCLE
from skylimb.apps.studio.branches import Act
from skylimb.apps.studio.messages import Back, Restart
from skylimb.flight.events import GainChange
from studio_page import drive

STIFFNESS = "attitude.normalized_stiffness"
TIGHT = {"tolerances.pen_line": 1e-6, "tolerances.finest": 1e-6}

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory, run_studio: Callable[..., Any]) -> Iterator[Any]:
    out: Path = tmp_path_factory.mktemp("contact")
    with run_studio(out, experiment="paper", keys={**CIRCLE, **TIGHT}) as found:
        yield found


@pytest.fixture(scope="module")
def opened(studio: Any, browser: sync_api.Browser) -> Iterator[sync_api.Page]:
    with silent_page(browser) as page:
        page.goto(studio.url)
        drive(page)
        yield page


def _acted(done: tuple[Act, ...], before: tuple[Act, ...], words: str) -> bool:
    """Whether the last act is a new one of these words."""
    return bool(done) and done[-1].words == words and not any(done[-1] is old for old in before)


@pytest.fixture
def page(opened: sync_api.Page, studio: Any) -> sync_api.Page:
    """The page with a flight that has just taken off, by the preset."""
    studio.speed(0.2)  # it lasts for 5 s, which a busy machine may need to show it
    # What the test before asked for may be done late: each act is waited for by its words.
    for command, words in (
        (Back(to="preset"), "everything back to the preset"),
        (Restart(), "take off again"),
    ):
        before = studio.session.branches.done
        studio.flight.command(command)
        wait_for(lambda old=before, said=words: _acted(studio.session.branches.done, old, said))
    flown = studio.session.live.flights[0]
    until(opened, "skylimbStudio.state.scene === skylimbStudio.number && !skylimbStudio.state.over")
    wait_for(
        lambda: opened.evaluate("skylimbStudio.state.branches.length") == len(studio.session.branches.ways)
    )
    assert studio.session.live.flights[0] is flown
    until(opened, "skylimbStudio.past.end > 0.1")
    studio.speed(1)
    return opened


def come_to_the_end(page: sync_api.Page, studio: Any) -> None:
    studio.speed(20)
    until(page, "skylimbStudio.state.over")
    studio.speed(1)


def gain(page: sync_api.Page, kind: str = "") -> sync_api.Locator:
    """The field of a gain's first number, or its slider."""
    page.get_by_role("tab", name="Gains").click()
    page.get_by_label("Search gains and keys").fill(STIFFNESS.replace(".", " ").replace("_", " "))
    return page.get_by_label(f"controller.{STIFFNESS}, entry 1{kind}", exact=True)


def test_a_flight_that_is_over_says_so_and_what_it_missed(page: sync_api.Page, studio: Any) -> None:
    come_to_the_end(page, studio)
    page.locator("#status").get_by_text("Over: not done as commanded").wait_for()
    page.get_by_role("tab", name="Scores").click()
    words = page.get_by_role("tabpanel", name="Scores").get_by_text("Hybrid was not done as commanded: ")
    assert "mm allowed" in words.inner_text()
    before = studio.session.branches
    for tab, part in (("Poke", "#panel-poke .hold"), ("Surface", "#surface-friction")):
        page.get_by_role("tab", name=tab).click()
        assert page.locator(part).is_disabled()
        assert "The flight is over; take off again (R)." in page.locator(f"#panel-{tab.lower()}").inner_text()
    page.get_by_role("radio", name="Poke").click()
    page.locator("#picture canvas").press("ArrowUp")
    page.locator("#notes").get_by_text("The flight is over").wait_for()
    page.get_by_role("radio", name="Look").click()
    assert studio.session.branches == before


def test_a_slider_on_a_flight_that_is_over_takes_off_once_with_its_last_value(
    page: sync_api.Page, studio: Any
) -> None:
    come_to_the_end(page, studio)
    slider = gain(page, ", slider")
    box = slider.bounding_box()
    assert box is not None
    flight, number = studio.session.live.flights[0], page.evaluate("skylimbStudio.number")
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 0.5 * box["height"], steps=6)
    until(page, "new Promise((done) => setTimeout(() => done(true), 300))")
    assert studio.session.live.flights[0] is flight
    value = float(slider.input_value())
    page.mouse.up()
    until(page, f"skylimbStudio.state.scene === skylimbStudio.number && skylimbStudio.number > {number}")
    assert page.evaluate("skylimbStudio.number") == number + 1
    assert flown_gain(studio.session, STIFFNESS)[0] == pytest.approx(value)
    assert "look again" not in page.locator("#notes").inner_text()


def test_a_gain_that_is_changed_while_one_looks_back_belongs_to_the_branch(
    page: sync_api.Page, studio: Any
) -> None:
    until(page, "skylimbStudio.past.end > 1.0")
    page.locator("#track").focus()
    for key in ("Home", "Shift+ArrowRight", "ArrowLeft", "ArrowLeft", "ArrowLeft"):
        page.keyboard.press(key)
    seen = page.evaluate("skylimbStudio.looking")
    field = gain(page)
    before = flown_gain(studio.session, STIFFNESS)
    field.fill("60")
    field.press("Enter")
    page.locator("#status").get_by_text("Looking back; changes that go along: 1").wait_for()
    time = studio.session.live.time
    wait_for(lambda: studio.session.live.time > time + 0.3)
    assert of_kind(studio.session.live.flights[0].experiment, GainChange) == []
    assert field.input_value() == "60"
    page.get_by_role("button", name="Go on from here").click()
    wait_for(lambda: flown_gain(studio.session, STIFFNESS)[0] == 60.0)
    (change,) = of_kind(studio.session.live.flights[0].experiment, GainChange)
    assert change.time == pytest.approx(seen, abs=0.01)
    assert list(np.ravel(change.value)[1:]) == before[1:]
    until(page, "skylimbStudio.looking === null && !skylimbStudio.pending.length")
    assert field.input_value() == "60"


def test_what_acts_now_is_refused_while_one_looks_back(page: sync_api.Page, studio: Any) -> None:
    until(page, "skylimbStudio.past.end > 0.5")
    page.locator("#track").focus()
    page.keyboard.press("Home")
    before = studio.session.branches
    page.get_by_role("tab", name="Poke").click()
    assert page.locator("#panel-poke .hold").is_disabled()
    page.get_by_text("You look back. First go on from there").first.wait_for()
    field = gain(page)
    field.fill("55")
    field.press("Enter")
    page.get_by_role("button", name="Back to now").click()
    page.get_by_text(f"Not taken along: controller.{STIFFNESS}").wait_for()
    wait_for(lambda: float(field.input_value()) == flown_gain(studio.session, STIFFNESS)[0])
    assert studio.session.branches == before
    page.get_by_role("tab", name="Poke").click()
    assert page.locator("#panel-poke .hold").is_enabled()


def test_words_are_drawn_in_one_take_off(page: sync_api.Page, studio: Any) -> None:
    number = page.evaluate("skylimbStudio.number")
    page.get_by_role("tab", name="Draw").click()
    page.locator("#draw-words").fill("a/b.c")
    page.get_by_label("Font", exact=True).select_option("scripts")
    page.get_by_role("button", name="Write").click()
    until(page, f"skylimbStudio.number > {number} && skylimbStudio.state.scene === skylimbStudio.number")
    path = studio.session.live.flights[0].experiment.trajectory
    assert (path.shape, path.text, path.font) == ("drawing", "a/b.c", "scripts")
    assert page.evaluate("skylimbStudio.number") == number + 1


def test_an_error_in_a_file_names_it(page: sync_api.Page) -> None:
    page.get_by_role("tab", name="Draw").click()
    svg = b'<svg xmlns="http://www.w3.org/2000/svg"><text>hi</text></svg>'
    page.locator("#svg-file").set_input_files(
        {"name": "words.svg", "mimeType": "image/svg+xml", "buffer": svg}
    )
    page.locator("#notes").get_by_text("SVG file 'words.svg' has a text element").wait_for()


def test_who_cannot_draw_well_is_told_who_can(page: sync_api.Page, studio: Any) -> None:
    page.get_by_role("tab", name="Draw").click()
    page.get_by_text("hybrid may miss where a stroke begins").wait_for()
    page.get_by_role("button", name="Fly drawing").click()
    wait_for(lambda: studio.session.flown == ["drawing"])
    page.get_by_role("button", name="Fly drawing").wait_for(state="hidden")
    page.get_by_label("Controller", exact=True).select_option("hybrid")
    wait_for(lambda: studio.session.flown == ["hybrid"])


def test_the_charts_show_a_whole_flight_and_follow_it_again(page: sync_api.Page, studio: Any) -> None:
    come_to_the_end(page, studio)
    page.evaluate("skylimbStudio.charts.zoom([1, 2])")
    page.get_by_role("button", name="Whole flight").click()
    least, most = page.evaluate(
        "(({ min, max }) => [min, max])(skylimbStudio.charts.charts[0].plot.scales.x)"
    )
    assert least < 0.1
    assert most == pytest.approx(studio.session.live.time, abs=0.1)
    page.get_by_role("button", name="Follow the flight").click()
    assert page.get_by_role("button", name="Whole flight").is_visible()


def test_the_timeline_is_as_long_as_what_it_shows_and_counts_what_it_does_not(
    page: sync_api.Page, studio: Any
) -> None:
    come_to_the_end(page, studio)
    assert page.evaluate("skylimbStudio.timeline.end") == pytest.approx(studio.session.live.time, abs=0.02)
    lasts = page.evaluate("skylimbStudio.timeline.lasts")
    for _ in range(2):  # branches that are shorter than this flight
        page.locator("#track").focus()
        page.keyboard.press("Home")
        page.keyboard.press("Shift+ArrowRight")
        count = len(studio.session.branches.ways)
        page.evaluate("skylimbStudio.past.frames[0].left = true")  # what is seen until the branch comes
        page.keyboard.press("Enter")
        wait_for(lambda count=count: len(studio.session.branches.ways) > count)
        until(page, "skylimbStudio.past.end > 1.2 && !skylimbStudio.past.frames[0].left")
        assert page.evaluate("skylimbStudio.looking") is None
    until(page, "document.querySelectorAll('.branch').length === 4")
    hidden = len(studio.session.branches.ways) - 4
    more = page.get_by_role("button", name=f"Earlier branches: {hidden}")
    more.click()
    assert page.locator(".branch").count() == hidden + 4
    page.get_by_role("button", name="The newest branches only").click()
    page.evaluate("skylimbStudio.timeline.branches = []")
    page.evaluate("skylimbStudio.timeline.show(1)")
    assert page.evaluate("skylimbStudio.timeline.end") == pytest.approx(lasts)
