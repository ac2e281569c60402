"""The five minutes of docs/studio.md, walked word by word with pointer and keyboard."""

from __future__ import annotations

import re
import shlex
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright import sync_api

import skylimb
from chromium import chromium, needs_chromium, silent_page, wait_for
from flown_state import flown_gain
from of_kind import of_kind
from skylimb.analysis.recording import Run
from skylimb.apps.studio.server import StudioServer
from skylimb.apps.studio.server_run import flight_of
from skylimb.apps.studio.session import Session
from skylimb.flight.events import Push

GUIDE = Path(__file__).parents[4] / "docs" / "studio.md"
GAIN = "attitude.normalized_stiffness"


def words_of_the_guide() -> set[str]:
    """What the guide says to press."""
    text = GUIDE.read_text(encoding="utf-8").split("## Five minutes to show it")[1].split("\n## ")[0]
    return {" ".join(word.split()) for word in re.findall(r"(?<!\*)\*([^*]+)\*(?!\*)", text)}


@pytest.mark.slow
@needs_chromium
def test_the_demonstration_works_word_by_word(tmp_path: Path) -> None:
    session, pressed = Session("paper", out=tmp_path), set[str]()
    with StudioServer("127.0.0.1", 0, "") as server, chromium() as browser, silent_page(browser) as page:
        flight = flight_of(server, session)
        thread = threading.Thread(target=flight.run, daemon=True)
        thread.start()
        page.set_default_timeout(30_000)
        page.goto(server.access.url)
        page.wait_for_selector("body[data-ready]")

        def press(role: Any, name: str, **more: Any) -> None:
            pressed.add(name)
            page.get_by_role(role, name=name, **more).click()

        def shown(true: Callable[[], Any]) -> None:
            """It is so, and the page shows it: what is meant for an older state is refused."""
            wait_for(true)
            wait_for(lambda: page.evaluate("skylimbStudio.state.version") >= flight._turned)
            wait_for(lambda: page.evaluate("skylimbStudio.state.scene === skylimbStudio.number"))

        def look(name: str) -> None:
            pressed.update({"View", name})
            page.get_by_label("View", exact=True).last.select_option(label=name)

        wait_for(lambda: session.live.time > 10.5)
        assert session.live.flights[0].recent[-1, session.live.flights[0].slices["contact_duty"]][0] > 0.0
        look("pen")
        look("whole robot")
        _drag_on_a_link(page)
        wait_for(
            lambda: any(push.force[2] > 0.3 for push in of_kind(session.live.flights[0].experiment, Push))
        )
        page.mouse.up()
        page.keyboard.up("Shift")
        page.locator(".mark[data-kind=push]").first.wait_for()
        press("tab", "Gains")
        pressed.add("Attitude")
        page.locator("summary", has_text="Attitude").click()
        good = flown_gain(session, GAIN)
        field = page.get_by_label(f"controller.{GAIN}, entry 1", exact=True)
        field.fill("4000")
        field.press("Enter")
        page.locator("#status").get_by_text("Lost").wait_for()
        press("button", "Fly again with the last good gains")
        shown(lambda: not session.live.over and session.live.time < 5.0)
        assert flown_gain(session, GAIN) == good
        press("button", "Undo")
        shown(lambda: session.live.over)
        press("button", "Undo")
        shown(lambda: not session.live.over and session.live.time > 8.0)
        assert flown_gain(session, GAIN) == good
        here = session.live.time  # a machine that is slow has pushed for long, so it may be lost again
        shown(lambda: session.live.time > here + 2.0 or session.live.over)
        _drag_back(page, 1.0)
        before = len(session.branches.ways)
        press("button", "Go on from here")
        shown(lambda: len(session.branches.ways) == before + 1)
        left = session.branches.ways[-1].parent
        page.get_by_role("button", name=f"Go to: branch {left + 1},").click()
        shown(lambda: session.branches.here == left)
        page.get_by_role("tab", name="Keep").click()
        page.locator("#keep-name").fill("demo")
        press("button", "Keep", exact=True)
        command = shlex.split(page.locator(".kept code").first.inner_text())
        assert command[:2] == ["skylimb", "run"]
        flight.stop()
        thread.join(30.0)
    kept, again = Run.load(tmp_path / "demo"), skylimb.run(command[2])
    for name in ("configuration", "thrusts", "contact_force"):
        np.testing.assert_array_equal(again.log[name].values, kept.log[name].values)
    assert pressed == words_of_the_guide()


def _drag_on_a_link(page: sync_api.Page) -> None:
    """Press on a link with Shift held, and pull it upward."""
    place = page.evaluate(
        "() => { const s = skylimbStudio, b = s.sceneView.canvas.getBoundingClientRect();"
        " for (let y = b.top + 40; y < b.bottom - 60; y += 4) for (let x = b.left; x < b.right; x += 4)"
        "  if ([[0, 0], [5, 0], [-5, 0], [0, 5], [0, -5]].every(([dx, dy]) =>"
        "   s.poke.linkAt({ clientX: x + dx, clientY: y + dy }))) return [x, y]; }"
    )
    page.keyboard.down("Shift")
    page.mouse.move(*place)
    page.mouse.down()
    page.mouse.move(place[0], place[1] - 30, steps=4)


def _drag_back(page: sync_api.Page, seconds: float) -> None:
    """Drag on the timeline to some seconds ago."""
    box = page.locator("#track").bounding_box()
    assert box is not None
    end, now = page.evaluate("[skylimbStudio.timeline.end, skylimbStudio.past.end]")
    for act, ago in ((page.mouse.down, 0.2), (page.mouse.up, seconds)):
        page.mouse.move(box["x"] + box["width"] * (now - ago) / end, box["y"] + 8, steps=5)
        act()
