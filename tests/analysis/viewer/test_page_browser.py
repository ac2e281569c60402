"""The replay of a report in a real browser: it starts, moves, compares, and complains of nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from playwright import sync_api
from scipy.spatial.transform import Rotation

import skylimb
from chromium import PAINTED, needs_chromium, silent_page
from skylimb.analysis.notebook_run import Run
from skylimb.analysis.recording.run import UNFINISHED
from skylimb.analysis.viewer.page import FlightViewer

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def page_file(four_runs: Mapping[str, Run], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "page.html"
    shown = dict(four_runs)
    name = next(name for name, run in shown.items() if run.controller == "hybrid")
    shown[name] = replace(shown[name], log=shown[name].log.assign_attrs(status=UNFINISHED))
    path.write_text(FlightViewer(shown).page, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def looked_at(browser: sync_api.Browser, page_file: Path) -> Iterator[sync_api.Page]:
    """One page, open, for all tests that change nothing but its width."""
    with silent_page(browser, offline=True) as page:
        page.goto(page_file.as_uri())
        page.wait_for_selector("#replay[data-ready]", timeout=20_000)
        yield page


@pytest.fixture
def page(browser: sync_api.Browser, page_file: Path) -> Iterator[sync_api.Page]:
    """The page, open."""
    with silent_page(browser, offline=True) as page:
        page.goto(page_file.as_uri())
        page.wait_for_selector("#replay[data-ready]", timeout=20_000)
        yield page


def time_shown(page: sync_api.Page) -> float:
    return page.evaluate("skylimbReplay.clock.time")


def test_all_flights_stand_side_by_side_with_their_plots(looked_at: sync_api.Page) -> None:
    names = ["PID", "Impedance", "Admittance (failed)", "Hybrid (unfinished)"]
    assert looked_at.locator(".replay .name").all_inner_texts() == names
    assert looked_at.locator(".replay .uplot").count() >= 4
    drawn = looked_at.evaluate("() => { const t = skylimbReplay.sceneView; t.render(); " + PAINTED + " }")
    assert drawn > 20  # a picture, not one colour


def test_it_plays_and_stops_at_the_end(page: sync_api.Page) -> None:
    page.get_by_label("Speed").select_option("8")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("skylimbReplay.clock.time > 1", timeout=30_000)
    page.wait_for_function("!skylimbReplay.clock.playing", timeout=20_000)
    assert time_shown(page) == pytest.approx(page.evaluate("skylimbReplay.clock.end"))


def test_on_paper_a_still_stands_for_the_replay(page: sync_api.Page) -> None:
    page.evaluate("skylimbReplay.clock.set(1)")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    samples = "[...document.querySelectorAll('.replay .u-marker')]"
    printed = page.evaluate(f"{samples}.map((one) => getComputedStyle(one).printColorAdjust)")
    assert set(printed) == {"exact"}  # else paper says of no curve whose it is
    still = page.get_by_role("img", name="The flight in three dimensions, 1.00 s after take-off")
    assert still.is_visible()
    drawn = still.evaluate(
        "async (one) => { await one.decode(); const t = { canvas: one }; " + PAINTED + " }"
    )
    assert drawn > 20
    assert not page.locator(".replay .picture > canvas").is_visible()


@pytest.mark.parametrize("width", [360, 390])
def test_nothing_is_clipped_on_a_phone(looked_at: sync_api.Page, width: int) -> None:
    looked_at.set_viewport_size({"width": width, "height": 844})
    looked_at.reload()
    looked_at.wait_for_selector("#replay[data-ready]", timeout=20_000)
    beyond = looked_at.evaluate(
        "() => [...document.querySelectorAll('.replay *')].filter((one) => one.checkVisibility()"
        " && one.getBoundingClientRect().right > innerWidth + 1).map((one) => one.outerHTML.slice(0, 99))"
    )
    assert beyond == []


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
    assert page.evaluate("skylimbReplay.sceneView.cells().length") == 1
    page.get_by_role("button", name="ghosts").click()
    page.get_by_label("Flights").select_option("Hybrid")
    assert page.locator(".replay .name").all_inner_texts() == ["Hybrid (unfinished)"]
    assert "truth" in page.locator(".replay .u-legend").first.inner_text()


def test_pushes_are_shown_around_the_tip_when_they_are_wanted(
    browser: sync_api.Browser, tmp_path: Path
) -> None:
    run = skylimb.run("free_flight", "pid", set={"stop_at": 1.0})
    path = tmp_path / "page.html"
    path.write_text(FlightViewer({"pid": run}).page, encoding="utf-8")
    with silent_page(browser, offline=True) as page:
        page.goto(path.as_uri())
        page.wait_for_selector("#replay[data-ready]", timeout=20_000)
        skin = "skylimbReplay.sceneView.figures[0].pushes"
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


POINT = [0.1, 0.0, 0.0]
PUSHES = [
    {"kind": "push", "time": 0.5, "duration": 0.5, "force": [0.0, 0.0, 2.0]},
    {
        "kind": "push",
        "time": 0.2,
        "duration": 0.2,
        "force": [0.0, 3.0, 0.0],
        "link": "link2",
        "point": POINT,
    },
    {
        "kind": "gain",
        "time": 0.8,
        "key": "translation.proportional",
        "value": [1.0, 1.0, 1.0],
        "duration": 0.1,
    },
]


@pytest.fixture(scope="module")
def pushed() -> Run:
    return skylimb.run("free_flight", "pid", set={"stop_at": 1.2, "events": PUSHES})


@pytest.fixture
def pushed_page(browser: sync_api.Browser, pushed: Run, tmp_path: Path) -> Iterator[sync_api.Page]:
    path = tmp_path / "page.html"
    path.write_text(FlightViewer({"pid": pushed}).page, encoding="utf-8")
    with silent_page(browser, offline=True) as page:
        page.goto(path.as_uri())
        page.wait_for_selector("#replay[data-ready]", timeout=20_000)
        yield page


def arrow(page: sync_api.Page, number: int, time: float) -> tuple[bool, np.ndarray, np.ndarray]:
    """Whether the arrow of a push is seen at a time, where it begins, m, and what it leads along, m."""
    seen, place, turn, length = page.evaluate(
        f"""() => {{
            skylimbReplay.clock.set({time});
            const {{ events }} = skylimbReplay.sceneView.figures[0];
            const {{ arrow }} = events.find((one) => one.number === {number});
            const {{ visible, position, quaternion, reach }} = arrow;
            return [visible, position.toArray(), quaternion.toArray(), reach];
        }}"""
    )
    return seen, np.array(place), length * Rotation.from_quat(turn).apply([0.0, 1.0, 0.0])


def test_a_push_has_an_arrow_while_it_lasts(pushed: Run, pushed_page: sync_api.Page) -> None:
    for number, times in ((1, (0.1, 0.45)), (2, (0.4, 1.1))):
        assert [arrow(pushed_page, number, time)[0] for time in times] == [False, False]
    log, model = pushed.log, mujoco.MjModel.from_xml_string(pushed.log.attrs["scene"])
    data, tick = mujoco.MjData(model), int(np.searchsorted(log.time.values, 0.3))
    data.qpos[:] = log.configuration.values[tick]
    mujoco.mj_kinematics(model, data)
    body = data.body("link2")
    seen, place, along = arrow(pushed_page, 1, 0.3)
    assert seen
    assert place == pytest.approx(body.xpos + body.xmat.reshape(3, 3) @ POINT, abs=5e-3)
    assert along == pytest.approx([0.0, 0.36, 0.0], abs=1e-6)  # 12 cm/N, as the contact force's
    seen, place, along = arrow(pushed_page, 2, 0.7)
    assert seen
    assert place == pytest.approx(log.cog_position.sel(time=0.7, method="nearest").values, abs=5e-3)
    assert along == pytest.approx([0.0, 0.0, 0.24], abs=1e-6)
    switch = pushed_page.get_by_role("button", name="arrows")
    assert "pushes (blue, 12 cm/N)" in (switch.get_attribute("title") or "")
    switch.click()
    assert pushed_page.evaluate("skylimbReplay.sceneView.figures[0].arrows.visible") is False


def test_events_are_marked_under_the_time_line_and_in_the_plots(pushed_page: sync_api.Page) -> None:
    marks = pushed_page.locator(".replay .mark")
    assert [mark.get_attribute("title") for mark in marks.all()] == [
        "1: push at 0.20 s, 0.2 s: 3 N on link2",
        "2: push at 0.50 s, 0.5 s: 2 N on the centre of gravity",
        "3: gain at 0.80 s, 0.1 s: translation.proportional to [1.0, 1.0, 1.0]",
    ]
    for number, time in enumerate((0.2, 0.5, 0.8)):
        marks.nth(number).click()
        assert time_shown(pushed_page) == pytest.approx(time)
        slider, mark = (
            pushed_page.get_by_label("Time", exact=True).bounding_box(),
            marks.nth(number).bounding_box(),
        )
        assert slider is not None
        assert mark is not None
        end = pushed_page.evaluate("skylimbReplay.clock.end")
        thumb = slider["x"] + 8.0 + (slider["width"] - 16.0) * time / end  # its middle
        assert mark["x"] == pytest.approx(thumb, abs=1.5)
        assert mark["width"] == pytest.approx(
            (slider["width"] - 16.0) * (0.2, 0.5, 0.1)[number] / end, abs=1.5
        )
    # Every plot has the pale blue of a push where the second one lasts, and plain paper before the first.
    colours = pushed_page.evaluate(
        """() => skylimbReplay.plots.plots.map((plot) => [0.75, 0.1].map((time) => {
            const { left, top, width, height } = plot.bbox, x = Math.round(plot.valToPos(time, "x", true));
            const copy = Object.assign(document.createElement("canvas"), { width: 1, height });
            const pen = copy.getContext("2d", { willReadFrequently: true });
            pen.drawImage(plot.ctx.canvas, -x, -top);
            const column = pen.getImageData(0, 0, 1, height).data, found = new Map();
            for (let k = 0; k < column.length; k += 4) {
                const colour = column.slice(k, k + 4).join(" ");
                found.set(colour, (found.get(colour) ?? 0) + 1);
            }
            return [...found].sort((a, b) => b[1] - a[1])[0][0];
        }))"""
    )
    assert len(colours) >= 4
    for during, before in colours:
        red, _, blue, seen = map(int, during.split())
        assert seen > 0
        assert blue > red
        assert before == "0 0 0 0"


def test_the_marks_are_those_of_the_flights_that_are_seen(
    browser: sync_api.Browser, pushed: Run, tmp_path: Path
) -> None:
    calm = Run("calm", "hybrid", pushed.log.assign_attrs(events="[]"), {})
    path = tmp_path / "page.html"
    path.write_text(FlightViewer({"pid": pushed, "calm": calm, "again": pushed}).page, encoding="utf-8")
    with silent_page(browser, offline=True) as page:
        page.goto(path.as_uri())
        page.wait_for_selector("#replay[data-ready]", timeout=20_000)
        marks = page.locator(".replay .mark")
        assert marks.count() == 3  # what flights share stands once
        page.get_by_label("Flights").select_option("calm")
        assert marks.count() == 0
        page.get_by_label("Flights").select_option("PID")
        assert marks.count() == 3


def test_a_page_of_flights_without_events_speaks_of_none(looked_at: sync_api.Page) -> None:
    assert looked_at.locator(".replay .mark").count() == 0
    assert "pushes" not in (looked_at.get_by_role("button", name="arrows").get_attribute("title") or "")


def test_without_limits_of_thrust_there_is_nothing_to_switch(looked_at: sync_api.Page) -> None:
    assert looked_at.get_by_role("button", name="pushes").count() == 0


@pytest.mark.parametrize("width", [360, 768, 1600])
def test_nothing_is_wider_than_the_page(looked_at: sync_api.Page, width: int) -> None:
    looked_at.set_viewport_size({"width": width, "height": 700})
    looked_at.wait_for_function(f"document.documentElement.scrollWidth <= {width}", timeout=10_000)
    assert looked_at.evaluate("document.documentElement.scrollWidth") <= width


def test_a_notebook_shows_it_in_a_frame(browser: sync_api.Browser, make_run: Callable[[], Run]) -> None:
    page = browser.new_page()
    page.set_content(f"<body>{make_run().show()._repr_html_()}</body>")
    frame = page.frame_locator("iframe")
    frame.locator("#replay[data-ready]").wait_for(timeout=20_000)
    assert frame.locator(".replay .uplot").count() >= 4
    page.close()


def test_the_line_of_the_time_is_whole_in_every_plot(page: sync_api.Page) -> None:
    red = page.evaluate(
        "async () => { const drawn = [], stroke = CanvasRenderingContext2D.prototype.stroke;"
        " CanvasRenderingContext2D.prototype.stroke = function (...path) {"
        "  if (this.strokeStyle === '#d62728' && !path.length) drawn.push(this.getLineDash().length);"
        "  return stroke.apply(this, path); };"
        " for (const plot of skylimbReplay.plots.plots) {"
        "  plot.series[plot.series.length - 1].dash = [4, 2]; plot.redraw(false, false); }"
        " await new Promise((done) => setTimeout(done, 200));"  # uPlot draws a moment later
        " CanvasRenderingContext2D.prototype.stroke = stroke; return drawn; }"
    )
    assert len(red) >= 4
    assert set(red) == {0}


def test_a_key_with_alt_is_the_browsers(page: sync_api.Page) -> None:
    page.evaluate("skylimbReplay.clock.set(1)")
    page.locator(".picture canvas").press("Control+Home")
    assert time_shown(page) == 1.0
