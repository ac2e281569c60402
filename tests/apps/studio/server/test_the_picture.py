"""What the studio's picture shows besides the robot: shadows, numbers, named axes, the believed surface."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from PIL import Image
from playwright import sync_api

from chromium import WORDS, needs_chromium, overlapping, serious, silent_page, until, wait_for
from skylimb.apps.studio.session import Session
from studio_page import drive

pytestmark = needs_chromium

SHADE = """() => {
    const { sceneView: view, figures: [figure] } = skylimbStudio, { sun } = view.scenes[0];
    const box = view.canvas.getBoundingClientRect(), light = sun.target.position.clone().sub(sun.position);
    const shapes = figure.bodies.slice(1).flatMap(({ children }) => children.filter((one) => one.castShadow));
    return shapes.map((one) => one.getWorldPosition(light.clone())).filter(({ z }) => z > 0.1)
        .map((place) => place.addScaledVector(light, -place.z / light.z))
        .map((shadow) => view.placeOf(0, shadow)).filter((place) => place)
        .map(([x, y]) => [x * box.width, y * box.height]);
}"""
"""Where the middles of the robot's shapes throw their shadows on the floor, px of the picture."""


HUES = """() => {
    const { past, figures: [figure] } = skylimbStudio, { contactArrow: { material }, trace, times } = figure;
    const newtons = (time) => Math.hypot(...past.at(time).subarray(...figure.layout.force));
    const rgb = trace.geometry.attributes.instanceColorStart.data.array;
    const hue = (colour) => colour.getHSL({}).h, colour = material.color.clone();
    return [[figure.force, hue(colour)],
        ...times.map((time, i) => [newtons(time), hue(colour.setRGB(...rgb.subarray(6 * i, 6 * i + 3)))])];
}"""
"""Force, N, and hue: of the contact's arrow, then of each segment of the pen's line."""


@pytest.fixture(scope="module")
def opened(studio: Any, browser: sync_api.Browser) -> Iterator[sync_api.Page]:
    """The one page of all tests, on its first visit."""
    with silent_page(browser) as page:
        page.goto(studio.url)
        drive(page)
        yield page


@pytest.fixture
def page(opened: sync_api.Page) -> sync_api.Page:
    """A flight that has just taken off, seen as on a first visit."""
    number = opened.evaluate("skylimbStudio.number")
    opened.get_by_role("button", name="Take off again").click()
    until(opened, f"skylimbStudio.state.scene === skylimbStudio.number && skylimbStudio.number > {number}")
    if opened.get_by_role("button", name="Go on", exact=True).is_visible():
        opened.get_by_role("button", name="Go on", exact=True).click()
    for name, pressed in (("Axes", "true"), ("Follow", "false")):
        switch = opened.get_by_role("button", name=name, exact=True)
        if switch.get_attribute("aria-pressed") != pressed:
            switch.click()
    opened.get_by_label("View", exact=True).last.select_option(label="whole robot")
    return opened


def test_the_whole_robot_is_in_the_first_picture(opened: sync_api.Page) -> None:
    outside = opened.evaluate(
        """() => {
            const { sceneView: view, figures: [figure] } = skylimbStudio;
            return figure.bodies.slice(1).filter((body) => body.children.length
                && !figure.surfaceObjects.includes(body.children[0]) && body.position.z > -10
                && !view.placeOf(0, body.position)).length;
        }"""
    )
    assert outside == 0


def test_a_first_visit_is_told_what_can_be_done_and_a_second_is_not(page: sync_api.Page) -> None:
    hints = page.get_by_role("group", name="First steps")
    hints.get_by_text("1 of 4. Push the robot").wait_for()
    assert serious(page) == []
    hints.get_by_role("button", name="Next").click()
    hints.get_by_text("2 of 4. Change a gain").wait_for()
    page.keyboard.press("?")  # not what it asks for
    page.keyboard.press("Escape")
    page.get_by_label("Search gains and keys").fill("translation damping ratio")
    field = page.get_by_label("controller.translation.damping_ratio, entry 1", exact=True)
    field.fill("0.65")
    field.press("Enter")
    hints.get_by_text("3 of 4. Drag on the line of time").wait_for()
    page.get_by_role("button", name="Got it").focus()
    page.keyboard.press("Enter")
    hints.wait_for(state="hidden")
    page.reload()
    page.wait_for_selector("body[data-ready]")
    page.wait_for_timeout(300)
    assert not hints.is_visible()


def photograph(page: sync_api.Page) -> np.ndarray:
    """The picture as it is seen, brightness, (height, width)."""
    shot = Image.open(io.BytesIO(page.locator("#picture canvas").screenshot()))
    return np.asarray(shot.convert("L"), dtype=float)


def paused(page: sync_api.Page, after: float) -> sync_api.Page:
    """The page with a flight that is held after some seconds, with all that is drawn of it."""
    until(page, f"skylimbStudio.past.end > {after}")
    page.get_by_role("button", name="Pause").click()
    until(page, "skylimbStudio.state.paused")
    until(page, "!skylimbStudio.fresh && !skylimbStudio.sceneView.stale")
    return page


def test_the_robot_throws_a_shadow(page: sync_api.Page) -> None:
    page.get_by_label("View", exact=True).last.select_option(label="top")
    page.get_by_role("button", name="Axes").click()  # numbers stand in the shadow
    places = paused(page, 0.2).evaluate(SHADE)
    seen = photograph(page)
    height, width = seen.shape
    darker = 0
    for x, y in places:
        if not (20 < x < width - 20 and 20 < y < height - 60):  # the edge, and the buttons below
            continue
        around = seen[round(y) - 20 : round(y) + 20, round(x) - 20 : round(x) + 20]
        darker += around[17:24, 17:24].min() < 0.9 * np.median(around)
    assert darker >= 2


def test_words_lie_apart_and_a_switch_takes_them_away(page: sync_api.Page) -> None:
    boxes = paused(page, 0.2).evaluate(WORDS, "skylimbStudio")
    assert len(boxes) > 6
    assert overlapping(boxes) == []
    with_words = photograph(page)
    page.get_by_role("button", name="Axes").click()
    until(page, "!skylimbStudio.sceneView.stale")
    assert page.evaluate(WORDS, "skylimbStudio") == []
    without = photograph(page)
    left, top, width, height = (round(value) for value in boxes[-1])  # of the surface's frame
    part = (slice(max(0, top), top + height), slice(max(0, left), left + width))
    assert np.mean(np.abs(with_words[part] - without[part]) > 20) > 0.05


PRESSES = "skylimbStudio.figures[0].force > 0.1"
STOPS = f"""() => new Promise((done, none) => {{
  const last = Date.now() + 60000;
  const look = () => {{
    if (Date.now() > last) none(new Error("nothing presses"));
    else if (!document.body.dataset.ready || !({PRESSES} && skylimbStudio.figures[0].count > 5))
      requestAnimationFrame(look);
    else done(document.querySelector("button.play").click());
  }};
  look();
}})"""
"""Pauses from within the page: a click from outside may come when the flight is over."""


def stop_while_it_presses(page: sync_api.Page) -> None:
    """Hold a flight that has just begun at a moment at which its pen presses."""
    while True:
        page.evaluate(STOPS)
        until(page, "skylimbStudio.state.paused")
        if page.evaluate(PRESSES):
            break
        page.get_by_role("button", name="Go on", exact=True).click()  # the pen has let go just then
        until(page, "!skylimbStudio.state.paused")
    until(page, "!skylimbStudio.fresh && !skylimbStudio.sceneView.stale")


def test_the_force_colours_arrow_and_line_and_its_number_covers_no_words(
    run_studio: Any, browser: sync_api.Browser, tmp_path: Any
) -> None:
    with run_studio(tmp_path, experiment="paper") as studio, silent_page(browser) as page:
        page.goto(studio.url)
        page.get_by_label("Speed, 0.1 to 20 times").focus()
        for _ in range(2):
            page.keyboard.press("PageUp")  # some 3 times: the pen presses for some seconds
        stop_while_it_presses(page)
        number = page.locator("#felt span")
        number.wait_for()
        picture, box = page.locator("#picture canvas").bounding_box(), number.bounding_box()
        assert picture is not None
        assert box is not None
        own = [box["x"] - picture["x"], box["y"] - picture["y"], box["width"], box["height"]]
        assert overlapping([own, *page.evaluate(WORDS, "skylimbStudio")]) == []
        arrow, *line = page.evaluate(HUES)
        for newtons, hue in (arrow, *line):
            assert hue == pytest.approx(0.62 * (1.0 - min(1.0, newtons / 5.0)), abs=1e-3)
        assert len({round(hue, 2) for _, hue in line}) > 1


def test_views_are_chosen_with_the_keyboard(page: sync_api.Page) -> None:
    place = "skylimbStudio.sceneView.camera.position.toArray()"
    for name in ("front", "side", "top", "pen", "whole robot"):
        page.locator("#picture canvas").focus()
        for _ in range(5):
            page.keyboard.press("ArrowLeft")
        before = page.evaluate(place)
        page.get_by_label("View", exact=True).last.focus()
        page.keyboard.type(name)
        until(page, f"Math.hypot(...{place}.map((x, i) => x - {before}[i])) > 0.05")


def test_the_camera_follows_the_robot(page: sync_api.Page) -> None:
    until(page, "skylimbStudio.past.end > 0.2")
    page.get_by_role("button", name="Follow").click()
    seen = (
        "(({ figures: [{ centre }], sceneView: { camera } }) =>"
        " [centre.toArray(), camera.position.clone().sub(centre).toArray()])(skylimbStudio)"
    )
    start, before = page.evaluate(seen)
    page.locator("#picture canvas").focus()
    page.keyboard.press("2")
    page.keyboard.down("ArrowUp")  # a push
    wait_for(lambda: np.linalg.norm(np.subtract(page.evaluate(seen)[0], start)) > 0.02)
    page.keyboard.up("ArrowUp")
    assert page.evaluate(seen)[1] == pytest.approx(before, abs=1e-6)
    page.keyboard.press("1")


def test_the_believed_surface_stands_where_the_mission_flies_to(tmp_path: Any) -> None:
    session = Session("paper", set={"surface_error": [0.05, 0.0, 0.02]}, out=tmp_path)
    (scene,) = session.live.scene()["flights"]
    frame, true = scene["frame"], scene["surface"]
    off = [believed - place for believed, place in zip(frame["origin"], true["origin"], strict=True)]
    assert off == pytest.approx([0.05, 0.0, 0.02])
    assert [axis["name"] for axis in frame["axes"]] == ["x contact", "y path", "z path"]
    assert frame["axes"][0]["vector"] == [1.0, 0.0, 0.0]


def test_robots_beside_each_other_have_their_own_colours(
    run_studio: Any, browser: sync_api.Browser, tmp_path: Any
) -> None:
    with run_studio(tmp_path, "pid", "hybrid") as studio, silent_page(browser) as page:
        page.goto(studio.url)
        page.wait_for_selector("body[data-ready]")
        tints = page.evaluate(
            "skylimbStudio.figures.map((one) => one.materials.map(([material]) => material.color.getHex()))"
        )
        assert len(tints) == 2
        assert all(one != other for one, other in zip(*tints, strict=True))
