"""The page elsewhere: zoomed, in forced colours, by keyboard, without its studio, before another one."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest
from playwright import sync_api

from chromium import needs_chromium, overlapping, silent_page, until, wait_for
from flown_state import flown_gain
from skylimb.apps.studio.messages import Restart, Scores
from studio_page import drive

GAIN = "translation.normalized_stiffness"

pytestmark = needs_chromium

ASTRAY = """() => {
    const { sceneView: view } = skylimbStudio, { camera, canvas } = view, found = [];
    const size = [canvas.clientWidth, canvas.clientHeight];
    const pixels = (place) => view.placeOf(0, place)?.map((part, i) => part * size[i]);
    const unit = canvas.clientHeight / (2 * Math.tan(camera.fov * Math.PI / 360));
    view.scenes[0].traverseVisible((one) => {
        const axis = one.userData.axis;
        if (!axis || one.material.opacity === 0) return;
        const ends = axis.map((end) => pixels(one.parent.localToWorld(end.clone())));
        const place = pixels(one.getWorldPosition(camera.position.clone()));
        if (!place || ends.some((end) => !end)) return;
        const aside = [one.center.x - 0.5, one.center.y - 0.5];
        const off = unit * Math.hypot(aside[0] * one.scale.x, aside[1] * one.scale.y);
        const length = Math.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
        found.push([off, length / 2]);
    });
    return found;
}"""
"""How far each letter of an axis that is seen stands from its place, px, and half of its axis."""


@pytest.fixture(scope="module")
def page(studio: Any, browser: sync_api.Browser) -> Iterator[sync_api.Page]:
    with silent_page(browser) as page:
        page.goto(studio.url)
        drive(page)
        yield page


def test_keys_turn_the_speed_over_the_real_one(page: sync_api.Page, studio: Any) -> None:
    slider = page.get_by_label("Speed, 0.1 to 20 times")
    slider.focus()
    for _ in range(6):
        page.keyboard.press("ArrowRight")
    wait_for(lambda: 1.1 < studio.flight.pacing.speed < 1.3)
    for _ in range(12):
        page.keyboard.press("ArrowLeft")
    wait_for(lambda: 0.8 < studio.flight.pacing.speed < 0.95)
    slider.dblclick()
    wait_for(lambda: studio.flight.pacing.speed == 1.0)


def test_a_value_out_of_range_stays_with_its_reason_until_it_is_left(
    page: sync_api.Page, studio: Any
) -> None:
    page.get_by_role("tab", name="Gains").click()
    page.get_by_label("Search gains and keys").fill(GAIN.replace(".", " ").replace("_", " "))
    gain = page.get_by_label(f"controller.{GAIN}, entry 1", exact=True)
    for tab, field, name in (
        ("Gains", gain, "normalized stiffness"),
        ("Surface", page.locator("#surface-friction"), "Friction"),
    ):
        page.get_by_role("tab", name=tab).click()
        before = field.input_value()
        field.fill("-5")
        field.press("Enter")
        page.locator("#notes").get_by_text(f"{name} = -5: ").wait_for()
        until(page, "new Promise((done) => setTimeout(() => done(true), 700))")
        assert field.input_value() == "-5"
        page.keyboard.press("Tab")
        wait_for(lambda field=field, before=before: field.input_value() == before)
    assert flown_gain(studio.session, GAIN)[0] > 0.0


def test_a_comma_in_a_number_is_taken_for_the_point_that_it_stands_for(page: sync_api.Page) -> None:
    page.get_by_role("tab", name="Surface").click()
    field = page.locator("#surface-friction")
    for typed, left in (("0,3", "0.3"), ("0.5", "0.5")):
        field.fill("")
        field.press_sequentially(typed)
        assert field.input_value() == left
    page.locator("#notes").get_by_text("A number has a point, not a comma: 2.5").wait_for()
    page.keyboard.press("Escape")
    field.evaluate("(one) => { one.value = ''; one.blur(); }")


def test_what_a_browser_drops_from_a_number_is_said(page: sync_api.Page) -> None:
    page.get_by_role("tab", name="Surface").click()
    field = page.locator("#surface-friction")
    field.fill("")
    field.press_sequentially("1/2")
    page.locator("#notes").get_by_text("A number has no /: 2.5 or 1e-3").wait_for()
    page.keyboard.press("Escape")
    field.evaluate("(one) => { one.value = ''; one.blur(); }")


def test_a_wrong_force_is_said_also_where_its_field_is_not_seen(page: sync_api.Page) -> None:
    page.get_by_role("tab", name="Poke").click()
    page.locator("#poke-force").fill("")
    page.get_by_role("radio", name="Poke").click()
    page.get_by_role("tab", name="Gains").click()
    page.locator("#picture canvas").press("ArrowUp")
    page.locator("#notes").get_by_text("Force = ?: ").wait_for()
    assert not page.evaluate("skylimbStudio.poke.held")
    page.locator("#poke-force").evaluate("(one) => { one.value = 2; }")
    page.get_by_role("radio", name="Look").click()


def test_a_key_with_ctrl_or_alt_is_the_browsers(page: sync_api.Page, studio: Any) -> None:
    flight, canvas = studio.session.live.flights[0], page.locator("#picture canvas")
    taken = """() => { window.taken = []; addEventListener('keydown', (event) =>
        setTimeout(() => taken.push([event.key, event.defaultPrevented]))); }"""
    page.evaluate(taken)
    for key in ("Control+3", "Alt+ArrowLeft", "Control+r"):
        canvas.press(key)
    page.locator("#track").press("Alt+ArrowLeft")
    until(page, "taken.filter(([key]) => !['Control', 'Alt'].includes(key)).length === 4")
    assert not [key for key, prevented in page.evaluate("taken") if prevented]
    assert page.evaluate("[skylimbStudio.mode, skylimbStudio.looking]") == ["look", None]
    assert studio.session.live.flights[0] is flight
    canvas.press("Shift+R")  # as with Caps Lock
    wait_for(lambda: studio.session.live.flights[0] is not flight)


def test_arrows_go_through_what_a_drag_does(page: sync_api.Page) -> None:
    page.get_by_role("radio", name="Look").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("[skylimbStudio.mode, document.activeElement.dataset.mode]") == ["surface"] * 2
    modes = page.get_by_role("radiogroup", name="What dragging does").get_by_role("radio")
    assert [one.get_attribute("tabindex") for one in modes.all()] == ["-1", "-1", "0", "-1"]
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("skylimbStudio.mode") == "look"


def test_a_field_is_not_given_back_what_another_had(page: sync_api.Page) -> None:
    fields = page.evaluate("[...document.querySelectorAll('input, select')].map((one) => one.autocomplete)")
    assert set(fields) == {"off"}


def test_a_tab_that_is_duplicated_watches(page: sync_api.Page) -> None:
    with page.expect_popup() as opened:
        page.evaluate("void open(location.href)")  # it gets a copy of what the page has stored
    other = opened.value
    other.wait_for_selector("body[data-ready]")
    until(other, "skylimbStudio.line.open")
    assert other.evaluate("skylimbStudio.line.name") != page.evaluate("skylimbStudio.line.name")
    until(page, "skylimbStudio.shell.seats.others === 1")
    assert page.evaluate("skylimbStudio.shell.seats.drives")
    assert not other.evaluate("skylimbStudio.shell.seats.drives")
    other.close()


def test_a_push_that_a_page_may_hold_no_more_is_not_shown(page: sync_api.Page, studio: Any) -> None:
    page.get_by_role("tab", name="Poke").click()
    button = page.get_by_role("button", name="Hold to poke")
    for end in (lambda: studio.flight.command(Restart()), lambda: page.locator("#track").press("Home")):
        button.hover()
        page.mouse.down()
        until(page, "skylimbStudio.state.undo?.startsWith('push')")
        assert "2.0 N" in page.locator("#force").inner_text()
        end()
        until(page, "!skylimbStudio.poke.held && document.querySelector('#force').hidden")
        wait_for(lambda: studio.session.pushed is None)
        page.mouse.up()
    page.locator("#track").press("Escape")
    page.get_by_role("tab", name="Gains").click()


def test_a_busy_flight_is_called_so_and_the_line_stays(page: sync_api.Page, studio: Any) -> None:
    done = threading.Event()
    acts = studio.flight._acts
    kept, acts[Scores] = acts[Scores], lambda _: done.wait(60.0)
    try:
        page.evaluate("skylimbStudio.lost = 0; skylimbStudio.line.on('line', () => skylimbStudio.lost++)")
        page.get_by_role("tab", name="Scores").click()
        page.get_by_role("button", name="Score now").click()
        until(page, "document.querySelector('#status').textContent === 'Busy'")
        until(
            page, "new Promise((done) => setTimeout(() => done(true), 4000))"
        )  # more than a lost line's 3 s
        assert page.evaluate("[skylimbStudio.line.open, skylimbStudio.lost]") == [True, 0]
    finally:
        done.set()
        acts[Scores] = kept
    until(page, "document.querySelector('#status').textContent !== 'Busy'")


def test_a_paused_flight_goes_on_by_a_tick(page: sync_api.Page, studio: Any) -> None:
    page.locator("#picture canvas").press(".")
    page.locator("#notes").get_by_text("tick by tick while it is paused").wait_for()
    page.get_by_role("button", name="Pause").click()
    until(page, "skylimbStudio.state.paused")
    time, period = studio.session.live.time, studio.session.live.period
    page.locator("#picture canvas").press(".")
    wait_for(lambda: studio.session.live.time > time)
    page.get_by_role("button", name="One tick").click()
    wait_for(lambda: studio.session.live.time == pytest.approx(time + 2 * period))
    until(page, f"document.querySelector('.time').textContent === '{time + 2 * period:.3f} s'")
    page.get_by_role("button", name="Go on", exact=True).click()


@pytest.mark.parametrize("size", [(1400, 900), (933, 600), (1100, 700), (390, 844)])
def test_buttons_in_the_picture_lie_apart(page: sync_api.Page, size: tuple[int, int]) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    until(page, "new Promise((done) => setTimeout(() => done(true), 200))")
    boxes = page.evaluate(
        "() => [...document.querySelectorAll('#modes, #views')].map((one) => {"
        " const box = one.getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; })"
    )
    page.set_viewport_size({"width": 1000, "height": 800})
    assert overlapping(boxes) == []


def test_forced_colours_show_what_is_chosen_and_the_time(page: sync_api.Page) -> None:
    until(page, "skylimbStudio.past.end > 0.2")
    page.emulate_media(forced_colors="active")
    colour = "(one) => getComputedStyle(one).backgroundColor"
    modes = page.locator("#modes button")
    chosen, other = (modes.nth(i).evaluate(colour) for i in (0, 1))
    hand, flown, track = (page.locator(one).evaluate(colour) for one in (".hand", ".flown", ".track"))
    page.emulate_media(forced_colors="none")
    assert chosen != other
    assert len({hand, flown, track}) == 3


def test_a_letter_stays_at_its_axis_or_is_not_there(page: sync_api.Page) -> None:
    counts = []
    for view in ("home", "front", "side", "top", "pen"):
        page.evaluate(f"skylimbStudio.sceneView.view('{view}')")
        until(page, "!skylimbStudio.sceneView.stale")
        found = page.evaluate(ASTRAY)
        assert all(off <= half + 0.5 for off, half in found), (view, found)
        counts.append(len(found))
    assert max(counts) >= 4
    page.evaluate("skylimbStudio.sceneView.view('home')")


def test_what_is_done_without_a_studio_is_refused_and_another_one_is_named(
    page: sync_api.Page, studio: Any
) -> None:
    page.evaluate("skylimbStudio.line.connect = () => {}")
    page.evaluate("skylimbStudio.line.socket.close()")
    until(page, "!skylimbStudio.line.open")
    flight = studio.session.live.flights[0]
    page.locator("#picture canvas").press("r")
    page.locator("#notes").get_by_text("No connection: nothing is done until it is back.").wait_for()
    number = page.evaluate("skylimbStudio.number")
    page.evaluate("delete skylimbStudio.line.connect; skylimbStudio.line.connect()")
    until(page, f"skylimbStudio.line.open && skylimbStudio.number === {number}")
    until(page, "skylimbStudio.shell.seats.drives")
    assert studio.session.live.flights[0] is flight
    assert "Another studio" not in page.locator("#notes").inner_text()
    studio.flight._name = "another"  # as one that has begun since
    page.get_by_role("button", name="Take off again").click()
    page.locator("#notes").get_by_text("Another studio answers: the flight that was here is gone.").wait_for()
