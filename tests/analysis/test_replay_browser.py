"""The replay of a report in a real browser: it starts, moves, compares, and complains of nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from playwright import sync_api

import skylimb
from chromium import PAINTED, chromium, needs_chromium, silent_page
from skylimb.analysis.replay.page import Replay
from skylimb.recording import Run

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def page_file(four_runs: Mapping[str, Run], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(Replay(four_runs).page, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def browser() -> Iterator[sync_api.Browser]:
    with chromium() as found:
        yield found


@pytest.fixture
def page(browser: sync_api.Browser, page_file: Path) -> Iterator[sync_api.Page]:
    """The page, open."""
    with silent_page(browser, offline=True) as page:
        page.goto(page_file.as_uri())
        page.wait_for_selector("#replay[data-ready]", timeout=20_000)
        yield page


def time_shown(page: sync_api.Page) -> float:
    return page.evaluate("skylimbReplay.clock.time")


def test_all_flights_stand_side_by_side_with_their_plots(page: sync_api.Page) -> None:
    names = ["PID", "Impedance", "Admittance (failed)", "Hybrid"]
    assert page.locator(".replay .name").all_inner_texts() == names
    assert page.locator(".replay .uplot").count() >= 4
    drawn = page.evaluate("() => { const t = skylimbReplay.theatre; t.render(); " + PAINTED + " }")
    assert drawn > 20  # a picture, not one colour


def test_it_plays_and_stops_at_the_end(page: sync_api.Page) -> None:
    page.get_by_label("Speed").select_option("8")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("skylimbReplay.clock.time > 1", timeout=30_000)
    page.wait_for_function("!skylimbReplay.clock.playing", timeout=20_000)
    assert time_shown(page) == pytest.approx(page.evaluate("skylimbReplay.clock.end"))


@pytest.mark.slow
def test_the_keyboard_moves_the_time(page: sync_api.Page) -> None:
    page.locator(".replay canvas").first.focus()
    for key in ("ArrowRight", "ArrowRight", "Shift+ArrowRight", "ArrowLeft"):
        page.keyboard.press(key)
    assert time_shown(page) == pytest.approx(1.1)
    page.keyboard.press("End")
    assert time_shown(page) == pytest.approx(page.evaluate("skylimbReplay.clock.end"))


def test_a_click_on_a_plot_goes_to_that_time(page: sync_api.Page) -> None:
    over = page.locator(".replay .u-over").first
    box = over.bounding_box()
    assert box is not None
    over.click(position={"x": 0.5 * box["width"], "y": 20.0})
    assert time_shown(page) == pytest.approx(0.5 * page.evaluate("skylimbReplay.clock.end"), rel=0.1)


def test_ghosts_are_one_picture_and_one_flight_has_all_its_curves(page: sync_api.Page) -> None:
    page.get_by_role("button", name="ghosts").click()
    assert page.evaluate("skylimbReplay.theatre.cells().length") == 1
    page.get_by_role("button", name="ghosts").click()
    page.get_by_label("Flights").select_option("Hybrid")
    assert page.locator(".replay .name").all_inner_texts() == ["Hybrid"]
    assert "truth" in page.locator(".replay .u-legend").first.inner_text()


def test_pushes_are_shown_around_the_tip_when_they_are_wanted(
    browser: sync_api.Browser, tmp_path: Path
) -> None:
    run = skylimb.run("free_flight", "pid", set={"stop_at": 1.0})
    path = tmp_path / "page.html"
    path.write_text(Replay({"pid": run}).page, encoding="utf-8")
    with silent_page(browser, offline=True) as page:
        page.goto(path.as_uri())
        page.wait_for_selector("#replay[data-ready]", timeout=20_000)
        skin = "skylimbReplay.theatre.stages[0].pushes"
        assert page.evaluate(f"{skin}.object.visible") is False
        page.get_by_role("button", name="pushes").click()
        assert page.evaluate(f"{skin}.object.visible") is True
        page.keyboard.press("End")
        tip = page.evaluate(f"{skin}.object.position.toArray()")
        assert tip == pytest.approx(run.log.tip_position.values[-1].tolist(), abs=0.02)
        pushes = page.evaluate(f"{skin}.at(1)")
        corners = np.reshape(page.evaluate(f"Array.from({skin}.skin.attributes.position.array)"), (-1, 3))
        assert np.linalg.norm(corners, axis=1).max() == pytest.approx(0.03 * max(pushes), rel=1e-3)
        assert max(pushes) > 10.0
        page.get_by_role("button", name="pushes").click()
        assert page.evaluate(f"{skin}.object.visible") is False


def test_without_limits_of_thrust_there_is_nothing_to_switch(page: sync_api.Page) -> None:
    assert page.get_by_role("button", name="pushes").count() == 0


@pytest.mark.parametrize("width", [360, 768, 1600])
def test_nothing_is_wider_than_the_page(page: sync_api.Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 700})
    page.wait_for_function(f"document.documentElement.scrollWidth <= {width}", timeout=10_000)


def test_a_notebook_shows_it_in_a_frame(browser: sync_api.Browser, make_run: Callable[[], Run]) -> None:
    page = browser.new_page()
    page.set_content(f"<body>{make_run().show()._repr_html_()}</body>")
    frame = page.frame_locator("iframe")
    frame.locator("#replay[data-ready]").wait_for(timeout=20_000)
    assert frame.locator(".replay .uplot").count() >= 4
    page.close()
