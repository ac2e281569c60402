"""The studio in a real browser: it moves, a slider turns a gain, a poke is felt, and a reload comes back."""

from __future__ import annotations

import random
import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright import sync_api

import skylimb
from chromium import PAINTED, needs_chromium, serious, silent_page, until, wait_for
from failing_controller import save_failing_controller
from flown_state import flown_gain
from of_kind import of_kind
from skylimb.analysis.recording import Run
from skylimb.flight.events import GainChange, Push, SurfaceChange
from studio_page import drive

PATIENCE = 20_000

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def open_page(studio: Any, browser: sync_api.Browser) -> Iterator[sync_api.Page]:
    """The one page of all tests."""
    with silent_page(browser) as page:
        page.set_default_timeout(PATIENCE)
        page.goto(studio.url)
        page.wait_for_selector("body[data-ready]")
        yield page


@pytest.fixture
def page(open_page: sync_api.Page, studio: Any) -> sync_api.Page:
    """The page with a flight that has just taken off, and flies."""
    before, number = studio.session.live.flights[0], open_page.evaluate("skylimbStudio.number")
    studio.speed(1)
    open_page.get_by_role("button", name="Take off again").click()
    if (go_on := open_page.get_by_role("button", name="Go on", exact=True)).is_visible():
        go_on.click()
    wait_for(lambda: studio.session.live.flights[0] is not before)
    until(open_page, f"!skylimbStudio.state.paused && skylimbStudio.number > {number}")
    open_page.get_by_role("tab", name="Gains").click()
    return open_page


def shown_time(page: sync_api.Page) -> float:
    return page.evaluate("skylimbStudio.past.end")


def test_the_picture_moves(page: sync_api.Page) -> None:
    before = shown_time(page)
    until(page, f"skylimbStudio.past.end > {before} + 0.3")
    assert page.locator("#charts .uplot").count() >= 4
    drawn = page.evaluate("() => { const t = skylimbStudio.sceneView; t.render(); " + PAINTED + " }")
    assert drawn > 20  # a picture, not one colour


def test_a_slider_turns_a_gain_in_the_flight(page: sync_api.Page, studio: Any) -> None:
    page.get_by_label("Search gains and keys").fill("translation normalized stiffness")
    slider = page.get_by_label("controller.translation.normalized_stiffness, entry 1, slider")
    slider.focus()
    before = float(slider.input_value())
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    value = float(slider.input_value())
    assert before < value < 1.1 * before

    def changes() -> Any:
        return of_kind(studio.session.live.flights[0].experiment, GainChange)

    wait_for(lambda: bool(changes()))
    wait_for(lambda: changes()[-1].value[0] == pytest.approx(value))
    page.get_by_label("Search gains and keys").fill("")


def test_search_finds_a_key_and_says_that_it_restarts(page: sync_api.Page, studio: Any) -> None:
    page.get_by_label("Search gains and keys").fill("seed noise")
    field = page.locator("#key-seed")
    row = page.locator(".key", has=field)
    assert "restarts" in row.inner_text()
    field.fill("7")
    field.press("Enter")
    wait_for(lambda: studio.session.live.flights[0].experiment.seed == 7)
    page.get_by_text("Took off again").first.wait_for()
    page.get_by_label("Search gains and keys").fill("")


def test_a_poke_of_2_newtons_is_felt(page: sync_api.Page, studio: Any) -> None:
    studio.speed(6)
    wait_for(lambda: studio.session.live.time > 8.0)  # the bias of the estimate is known by then
    studio.speed(1)
    page.get_by_role("tab", name="Poke").click()
    page.locator("#poke-force").fill("2")
    page.get_by_label("Direction of the poke").select_option("left")
    hold = page.get_by_role("button", name="Hold to poke")
    hold.focus()
    page.keyboard.down("Space")
    wait_for(lambda: bool(of_kind(studio.session.live.flights[0].experiment, Push)))
    begun = of_kind(studio.session.live.flights[0].experiment, Push)[0].time
    wait_for(lambda: studio.session.live.time > begun + 1.5)
    assert "2.0 N" in page.locator("#force").inner_text()
    page.keyboard.up("Space")
    wait_for(lambda: of_kind(studio.session.live.flights[0].experiment, Push)[-1].duration < 20)
    flight = studio.session.live.flights[0]
    first = round((begun + 1.0) / studio.session.live.period)
    estimate = flight.recent[first : first + 80, flight.slices["external_force_estimate"]]
    np.testing.assert_allclose(estimate.mean(axis=0), [0.0, 2.0, 0.0], atol=0.3)


def test_a_drag_on_a_link_pokes(page: sync_api.Page, studio: Any) -> None:
    page.get_by_role("radio", name="Poke").click()
    until(page, "skylimbStudio.past.end > 0.3")
    place = page.evaluate(
        "() => { const s = skylimbStudio, b = s.sceneView.canvas.getBoundingClientRect();"
        " for (let y = b.top + 40; y < b.bottom - 60; y += 4) for (let x = b.left; x < b.right; x += 4)"
        "  if ([[0, 0], [5, 0], [-5, 0], [0, 5], [0, -5]].every(([dx, dy]) =>"
        "   s.poke.linkAt({ clientX: x + dx, clientY: y + dy }))) return [x, y]; }"
    )
    page.mouse.move(*place)
    page.mouse.down()
    page.mouse.move(place[0], place[1] - 60, steps=4)
    wait_for(
        lambda: any(push.force[2] > 0.3 for push in of_kind(studio.session.live.flights[0].experiment, Push))
    )
    page.keyboard.press("Shift")  # let go of while the button is held
    assert page.evaluate("Boolean(skylimbStudio.poke.held)")
    page.mouse.up()
    until(page, "!skylimbStudio.poke.held")
    page.get_by_role("radio", name="Look").click()


def test_the_surface_is_moved_and_made_slippery(page: sync_api.Page, studio: Any) -> None:
    page.get_by_role("radio", name="Surface").click()
    forward = page.locator("#surface-x")
    forward.fill("0.1")
    forward.press("Enter")
    friction = page.get_by_label("Friction, slider", exact=True)
    friction.focus()
    page.keyboard.press("ArrowLeft")

    def changes() -> Any:
        return of_kind(studio.session.live.flights[0].experiment, SurfaceChange)

    wait_for(lambda: any(one.friction is not None for one in changes()))
    place = studio.session.live.flights[0].experiment.surface.position
    (moved,) = (one.position for one in changes() if one.position)
    assert moved == pytest.approx((place[0] + 0.1, place[1], place[2]))
    page.get_by_role("radio", name="Look").click()


def test_what_is_kept_is_flown_again_to_the_bit(page: sync_api.Page, studio: Any) -> None:
    page.get_by_role("tab", name="Poke").click()
    page.get_by_role("button", name="Hold to poke").focus()
    page.keyboard.down("Space")
    wait_for(lambda: bool(of_kind(studio.session.live.flights[0].experiment, Push)))
    begun = studio.session.live.time
    wait_for(lambda: studio.session.live.time > begun + 0.3)
    page.keyboard.up("Space")
    page.get_by_role("tab", name="Keep").click()
    page.locator("#keep-name").fill("felt")
    page.get_by_role("button", name="Keep", exact=True).click()
    page.locator(".kept code").wait_for()
    command = shlex.split(page.locator(".kept code").inner_text())
    assert command[:2] == ["skylimb", "run"]
    kept = Run.load(studio.session.out / "felt")
    again = skylimb.run(command[2])
    assert len(kept.log.time) > 50
    for name in ("configuration", "thrusts", "contact_force", "external_force_estimate"):
        np.testing.assert_array_equal(again.log[name].values, kept.log[name].values)


@pytest.mark.slow
def test_a_controllers_exception_is_shown_with_its_line_until_the_file_is_mended(
    browser: sync_api.Browser, run_studio: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "still.py"
    save_failing_controller(file, 100)
    line = file.read_text().splitlines().index('            raise ZeroDivisionError("too late")') + 1
    with run_studio(tmp_path / "out", str(file)) as studio, browser.new_context() as context:
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.goto(studio.url)
        alert = page.get_by_role("alert").filter(has_text="too late")
        alert.filter(has_text=f"still.py, line {line}").wait_for()
        save_failing_controller(file, 10**9)
        page.get_by_role("alert").wait_for(state="hidden")
        until(page, "skylimbStudio.past.end > 0.6")


def on_the_track(page: sync_api.Page, time: float) -> tuple[float, float]:
    """Where a time stands on the timeline, px."""
    box = page.locator("#track").bounding_box()
    assert box is not None
    return box["x"] + box["width"] * time / page.evaluate("skylimbStudio.timeline.end"), box["y"] + 8


def test_the_past_is_dragged_and_gone_on_from(page: sync_api.Page, studio: Any) -> None:
    until(page, "skylimbStudio.past.end > 1.5")
    before = page.locator("#track").bounding_box()
    page.mouse.move(*on_the_track(page, 1.2))
    page.mouse.down()
    page.mouse.move(*on_the_track(page, 0.8), steps=6)
    assert page.evaluate("skylimbStudio.looking") == pytest.approx(0.8, abs=0.05)
    page.mouse.move(*on_the_track(page, 0.6), steps=3)
    page.mouse.up()
    assert not studio.flight.paused  # the flight goes on while one looks back
    assert page.locator("#track").bounding_box() == before  # and nothing moves under the pointer
    assert page.locator("#status").inner_text() == "Looking back"
    seen = page.evaluate("skylimbStudio.looking")
    page.get_by_role("button", name="Go on from here").click()
    until(page, f"skylimbStudio.looking === null && skylimbStudio.past.end < {seen} + 1.0")
    until(page, "skylimbStudio.state.branches.at(-1).parent === skylimbStudio.state.branches.at(-2).number")
    number = page.evaluate("skylimbStudio.state.branches.at(-2).number")
    page.get_by_role("button", name=f"Go to: branch {number + 1},").click()
    until(page, "skylimbStudio.past.end > 1.4")


def test_keys_and_the_wheel_look_back(page: sync_api.Page, studio: Any) -> None:
    until(page, "skylimbStudio.past.end > 1.5")
    track = page.get_by_role("slider", name="Time of the flight")
    track.focus()
    page.keyboard.press("Home")
    assert page.evaluate("skylimbStudio.looking") < 0.05
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowRight")
    looking = page.evaluate("skylimbStudio.looking")
    assert looking == pytest.approx(1.1, abs=0.05)
    page.mouse.move(*on_the_track(page, 1.0))
    page.mouse.wheel(0, -100)
    until(page, f"Math.abs(skylimbStudio.looking - {looking} + 0.1) < 1e-6")
    page.keyboard.press("Enter")
    until(page, "skylimbStudio.looking === null && skylimbStudio.state.branches.length > 1")
    page.keyboard.press("Home")
    page.keyboard.press("Escape")
    assert page.evaluate("skylimbStudio.looking") is None


def test_an_act_is_undone_and_done_again(page: sync_api.Page, studio: Any) -> None:
    page.get_by_label("Search gains and keys").fill("translation normalized stiffness")
    field = page.get_by_label("controller.translation.normalized_stiffness, entry 1", exact=True)
    before = field.input_value()
    field.fill("3.25")
    field.press("Enter")
    wait_for(lambda: flown_gain(studio.session, "translation.normalized_stiffness")[0] == 3.25)
    until(page, "skylimbStudio.past.end > 1.0")
    page.locator(".mark[data-kind=gain]").wait_for(state="attached")  # one: two would be an error
    field.press("1")
    page.keyboard.press("Control+z")  # of what is being typed
    assert field.input_value() == "3.25"
    field.press("Enter")
    page.keyboard.press("Control+z")  # of what was done, with the hand still in the field
    wait_for(lambda: flown_gain(studio.session, "translation.normalized_stiffness")[0] != 3.25)
    page.get_by_label("Search gains and keys").fill("")
    wait_for(lambda: field.input_value() == before)
    page.get_by_role("button", name="Redo").click()
    wait_for(lambda: flown_gain(studio.session, "translation.normalized_stiffness")[0] == 3.25)
    wait_for(lambda: field.input_value() == "3.25")
    changed = page.get_by_role("region", name="What was changed")
    changed.get_by_role("button", name="All back to take-off").click()
    wait_for(lambda: field.input_value() == before)
    row = changed.get_by_role("button", name="controller.translation.normalized_stiffness: back to take-off")
    row.wait_for(state="hidden")


def test_scores_say_what_they_are_of_and_go_with_their_flight(page: sync_api.Page, studio: Any) -> None:
    studio.speed(6)
    wait_for(lambda: studio.session.live.time > 8.0)
    studio.speed(1)
    page.get_by_role("tab", name="Scores").click()
    panel = page.get_by_role("tabpanel", name="Scores")
    panel.get_by_role("button", name="Score now").click()
    panel.get_by_text("largest tilt").wait_for()
    of = re.search(r"until ([\d.]+) s", panel.get_by_role("status").inner_text())
    assert of is not None
    assert float(of[1]) > 7.9
    page.get_by_role("slider", name="Time of the flight").focus()
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Enter")  # a branch from a second ago: those were of another flight
    panel.get_by_text("of the flight so far").wait_for()
    assert panel.get_by_role("row").count() == 0


def fields(page: sync_api.Page) -> dict[str, str]:
    """What stands in the page's fields that can act in flight."""
    return page.evaluate(
        "() => Object.fromEntries([...document.querySelectorAll('#panel-gains input[type=number],"
        " #panel-surface input[type=number]')].map((one) => [one.id, one.value]))"
    )


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_two_pages_show_what_flies(
    page: sync_api.Page, studio: Any, browser: sync_api.Browser, seed: int
) -> None:
    draw = random.Random(seed)
    gain = "translation.normalized_stiffness"
    with silent_page(browser) as other:
        other.goto(studio.url)
        for step in range(8):
            driver = draw.choice([page, other])
            drive(driver)
            driver.get_by_role("tab", name="Gains").click()
            match draw.randrange(5) if step else 0:
                case 0 | 1:
                    driver.get_by_label("Search gains and keys").fill("translation normalized stiffness")
                    entry = draw.randrange(3)
                    field = driver.locator(f"[id='key-controller.{gain}{f'-{entry}' if entry else ''}']")
                    field.fill(f"{draw.uniform(2, 4):.2f}")
                    field.press("Enter")
                case 2:
                    driver.locator("#track").focus()
                    driver.keyboard.press("Home")
                    driver.keyboard.press("Enter")
                case 3:
                    draw.choice([page, other]).reload()
                case 4:
                    driver.get_by_role("button", name="Undo").click()
            for one in (page, other):
                until(
                    one, "document.body.dataset.ready && skylimbStudio.state.scene === skylimbStudio.number"
                )
            wait_for(lambda: all(_shows(one, studio, gain) for one in (page, other)))
    drive(page)


def _shows(page: sync_api.Page, studio: Any, gain: str) -> bool:
    shown, flown = fields(page), flown_gain(studio.session, gain)
    names = [f"key-controller.{gain}", f"key-controller.{gain}-1", f"key-controller.{gain}-2"]
    return [float(shown[name]) for name in names] == pytest.approx(flown)


def test_a_reload_comes_back_to_the_same_flight(page: sync_api.Page, studio: Any) -> None:
    flight = studio.session.live.flights[0]
    until(page, "skylimbStudio.past.end > 0.5")
    page.reload()
    page.wait_for_selector("body[data-ready]")
    until(page, "skylimbStudio.past.frames.length > 5 && skylimbStudio.past.frames[0][0] < 0.6")
    assert studio.session.live.flights[0] is flight
    assert page.evaluate("skylimbStudio.shell.seats.drives")


def test_a_lost_connection_is_said_and_comes_back_with_the_past(page: sync_api.Page) -> None:
    until(page, "skylimbStudio.past.end > 1.5")
    page.evaluate("skylimbStudio.line.socket.close()")
    until(page, "!skylimbStudio.line.open")
    until(page, "skylimbStudio.line.open && skylimbStudio.shell.online")
    until(page, "skylimbStudio.past.frames.length && skylimbStudio.past.frames[0][0] < 0.6")
    before = shown_time(page)
    until(page, f"skylimbStudio.past.end !== {before}")


def test_everything_is_named_and_can_be_reached_by_keyboard(page: sync_api.Page) -> None:
    nameless = page.evaluate(
        "() => [...document.querySelectorAll('button, input, select, canvas[tabindex]')]"
        ".filter((one) => one.checkVisibility())"
        ".filter((one) => !(one.getAttribute('aria-label') || one.textContent.trim() || one.labels?.length))"
        ".map((one) => one.outerHTML)"
    )
    assert nameless == []
    page.locator("#picture canvas").focus()
    page.keyboard.press("2")
    assert page.get_by_role("radio", name="Poke").get_attribute("aria-checked") == "true"
    page.keyboard.press("1")


def test_a_legend_shows_dashes_as_its_curves_have_them(page: sync_api.Page) -> None:
    until(page, "skylimbStudio.past.end > 0.5")
    marker = page.locator("#charts tr", has_text="roll").locator(".u-marker")
    looks = marker.evaluate_all("(all) => all.map((one) => getComputedStyle(one).backgroundImage)")
    plain = ["rgba(0, 0, 0, 0)" not in look for look in looks]
    assert plain[:2] == [True, False]  # roll, and its command
    box = marker.first.bounding_box()
    assert box is not None
    assert box["width"] > 8 * box["height"]  # a piece of a line


def test_a_signal_of_the_log_is_charted_zoomed_and_exported(page: sync_api.Page, studio: Any) -> None:
    until(page, "skylimbStudio.past.end > 1.0")
    flight = studio.session.live.flights[0]
    search = page.get_by_label("Add a signal's chart")
    search.click()
    page.keyboard.type("thrusts command")
    page.get_by_role("button", name="thrusts_command").click()
    chart = page.get_by_role("figure", name="thrusts command (N)")
    chart.scroll_into_view_if_needed()
    page.get_by_role("button", name="Pause").click()
    wait_for(lambda: studio.flight.paused)
    until(page, "skylimbStudio.state.paused")
    with page.expect_download() as told:
        chart.get_by_role("button", name="as a table").click()
    head, *rows = told.value.path().read_text().splitlines()
    assert head == '"t (s)","rotor1 (N)","rotor2 (N)","rotor3 (N)","rotor4 (N)"'
    commands = flight.recent[:, flight.slices["thrusts_command"]]
    for row in (rows[0], rows[len(rows) // 2]):
        time_, *thrusts = map(float, row.split(","))
        tick = round(time_ / studio.session.live.period)
        np.testing.assert_allclose(thrusts, commands[tick], rtol=1e-6)
    with page.expect_download() as told:
        chart.get_by_role("button", name="as a picture").click()
    assert told.value.path().read_bytes().startswith(b"\x89PNG")
    box = chart.locator(".u-over").bounding_box()
    assert box is not None
    begin, end = page.evaluate(
        "(({ min, max }) => [min, max])(skylimbStudio.charts.charts.at(-1).plot.scales.x)"
    )
    page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 30, steps=4)
    page.mouse.up()
    parts = [(time_ - begin) / (end - begin) for time_ in page.evaluate("skylimbStudio.charts.zoomed")]
    assert parts == pytest.approx([0.2, 0.6], abs=0.02)
    # Nothing has moved under the pointer.
    assert chart.locator(".u-over").bounding_box() == pytest.approx(box, abs=1.0)
    assert "N" in chart.locator(".u-value").nth(1).inner_text()  # the cursor's value, with its unit
    page.get_by_role("button", name="Follow the flight").click()
    assert page.evaluate("skylimbStudio.charts.zoomed") is None
    chart.get_by_role("button", name="keep in front").click()
    page.reload()
    page.wait_for_selector("body[data-ready]")
    assert page.locator("#charts figure").first.get_attribute("aria-label") == "thrusts command (N)"
    page.get_by_role("figure", name="thrusts command (N)").get_by_role("button", name="close").click()
    page.get_by_role("button", name="Go on", exact=True).click()


@pytest.mark.parametrize(("scheme", "rules"), [("light", ()), ("dark", ("color-contrast",))])
def test_axe_has_nothing_serious_to_say(page: sync_api.Page, scheme: Any, rules: tuple[str, ...]) -> None:
    """In the dark colours are others, and nothing else is."""
    page.emulate_media(color_scheme=scheme)
    assert serious(page, *rules) == []
    for tab in ("Poke", "Surface", "Draw", "Scores", "Keep"):
        page.get_by_role("tab", name=tab).click()
        panel = f"#panel-{tab.lower()}"
        assert page.locator(panel).is_visible()
        assert serious(page, *rules, within=("[role=tablist]", panel)) == []
    page.keyboard.press("Shift+?")
    page.get_by_role("dialog").wait_for()
    assert serious(page, *rules, within=("dialog[open]",)) == []
    page.keyboard.press("Escape")
    page.emulate_media(color_scheme="light")


@pytest.mark.parametrize("width", [360, 768, 1600])
def test_nothing_is_wider_than_the_page(page: sync_api.Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 800})
    until(page, f"document.documentElement.scrollWidth <= {width}")


def test_an_svg_file_is_drawn(page: sync_api.Page, studio: Any) -> None:
    page.get_by_role("tab", name="Draw").click()
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path d="M 1,1 L 8,8"/></svg>'
    page.locator("#svg-file").set_input_files(
        {"name": "line.svg", "mimeType": "image/svg+xml", "buffer": svg}
    )
    wait_for(lambda: studio.session.live.flights[0].experiment.trajectory.shape == "drawing")
    assert (studio.session.out / "drawings" / "drawing-1.svg").read_bytes() == svg


def test_no_words_and_the_back_of_the_surface_say_why_nothing_is_drawn(page: sync_api.Page) -> None:
    page.get_by_role("tab", name="Draw").click()
    page.locator("#draw-words").fill("  ")
    page.get_by_role("button", name="Write", exact=True).click()
    page.get_by_text("There are no words to write yet").wait_for()
    seen_from = """(side) => {
      const s = skylimbStudio, t = s.sceneView, was = t.camera.clone();
      const at = (x) => s.figures[0].drawn.localToWorld(was.position.clone().set(x, 0.01, 0.02));
      t.camera.position.copy(at(side)); t.camera.lookAt(at(0));
      const { left, top, width, height } = t.renderer.domElement.getBoundingClientRect();
      const begun = s.drawingTool.grab({ clientX: left + width / 2, clientY: top + height / 2 });
      s.drawingTool.clear();
      t.camera.copy(was);
      return begun;
    }"""
    assert page.evaluate(seen_from, -1.0)
    assert not page.evaluate(seen_from, 1.0)  # it left a stroke that nobody saw, at the front
    page.get_by_text("This is the surface's back").wait_for()


def test_a_page_of_another_site_is_refused(studio: Any, browser: sync_api.Browser) -> None:
    page = browser.new_page()
    page.goto("data:text/html,<p>another site</p>")
    closed = page.evaluate(
        f"() => new Promise((done) => {{ const s = new WebSocket('ws://127.0.0.1:{studio.port}/socket');"
        " s.onopen = () => done('open'); s.onclose = () => done('refused'); })"
    )
    assert closed == "refused"
    page.close()
