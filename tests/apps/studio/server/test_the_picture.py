"""What the studio's picture shows besides the robot: shadows, numbers, named axes, the believed surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright import sync_api

from chromium import chromium, needs_chromium, serious, silent_page
from skylimb.apps.studio.session import Session

pytestmark = needs_chromium

DIFFERENT = """(what) => {
    const view = skylimbStudio.sceneView, pixels = () => {
        view.render();
        const copy = Object.assign(document.createElement("canvas"), { width: 240, height: 160 });
        const pen = copy.getContext("2d");
        pen.drawImage(view.canvas, 0, 0, 240, 160);
        return pen.getImageData(0, 0, 240, 160).data;
    };
    const before = pixels();
    change(what, view);
    const after = pixels();
    return before.filter((value, k) => Math.abs(value - after[k]) > 20).length;
    function change(what, view) {
        if (what === "shadows") for (const { sun } of view.scenes) sun.castShadow = false;
        else document.getElementById(what).click();
    }
}"""
"""How many of the picture's numbers differ once something is switched off."""


@pytest.fixture(scope="module")
def browser() -> Iterator[sync_api.Browser]:
    with chromium() as found:
        yield found


@pytest.fixture
def page(studio: Any, browser: sync_api.Browser) -> Iterator[sync_api.Page]:
    """A first visit."""
    with silent_page(browser) as page:
        page.goto(studio.url)
        page.wait_for_selector("body[data-ready]")
        page.wait_for_timeout(500)  # it is told who drives
        if page.get_by_role("button", name="Take over").is_visible():
            page.get_by_role("button", name="Take over").click()
        page.get_by_role("button", name="Take off again").click()
        page.get_by_text("Took off again").first.wait_for()
        page.wait_for_timeout(500)
        yield page


@pytest.mark.parametrize("what", ["shadows", "axes"])
def test_it_has_shadows_and_axes(page: sync_api.Page, what: str) -> None:
    assert page.evaluate(DIFFERENT, what) > 200


def test_the_whole_robot_is_in_the_first_picture(page: sync_api.Page) -> None:
    outside = page.evaluate(
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
    page.get_by_role("button", name="Got it").focus()
    page.keyboard.press("Enter")
    hints.wait_for(state="hidden")
    page.reload()
    page.wait_for_selector("body[data-ready]")
    page.wait_for_timeout(300)
    assert not hints.is_visible()


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
