"""What goes wrong in a real browser, and the way back from it: by pointer and keyboard alone."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright import sync_api

from chromium import needs_chromium, silent_page, until, wait_for
from failing_controller import save_failing_controller
from flown_state import flown_gain
from of_kind import of_kind
from skylimb.apps.studio.messages import Set
from skylimb.flight.events import GainChange
from studio_page import drive

GAIN = "translation.normalized_stiffness"
TOKEN = "a-token-that-both-servers-have"

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def opened(studio: Any, browser: sync_api.Browser) -> Iterator[sync_api.Page]:
    """The one page of all tests."""
    with silent_page(browser) as page:
        page.goto(studio.url)
        yield page


@pytest.fixture
def page(opened: sync_api.Page) -> sync_api.Page:
    """A page that drives a flight that has just taken off."""
    drive(opened)
    take_off(opened)
    return opened


def take_off(page: sync_api.Page) -> None:
    number = page.evaluate("skylimbStudio.number")
    page.get_by_role("button", name="Take off again").click()
    until(page, f"skylimbStudio.state.scene === skylimbStudio.number && skylimbStudio.number > {number}")
    until(page, "skylimbStudio.past.end > 0.1")


def set_gain(page: sync_api.Page, value: str, key: str = GAIN) -> sync_api.Locator:
    """Type a gain's first number."""
    page.get_by_role("tab", name="Gains").click()
    page.get_by_label("Search gains and keys").fill(key.replace(".", " ").replace("_", " "))
    field = page.get_by_label(f"controller.{key}, entry 1", exact=True)
    field.click()
    page.keyboard.press("Control+a")
    page.keyboard.type(value)
    page.keyboard.press("Enter")
    return field


def test_one_key_is_brought_back_to_take_off_and_to_the_preset(page: sync_api.Page, studio: Any) -> None:
    preset = flown_gain(studio.session, GAIN)
    field = set_gain(page, "3")
    wait_for(lambda: flown_gain(studio.session, GAIN)[0] == 3.0)
    take_off(page)  # it takes off with 3 now
    set_gain(page, "3.5")
    wait_for(lambda: flown_gain(studio.session, GAIN)[0] == 3.5)
    changed = page.get_by_role("region", name="What was changed")
    changed.get_by_role("button", name=f"controller.{GAIN}: back to take-off").click()
    wait_for(lambda: flown_gain(studio.session, GAIN)[0] == 3.0)
    wait_for(lambda: field.input_value() == "3")
    changed.get_by_role("button", name=f"controller.{GAIN}: back to preset").click()
    wait_for(lambda: flown_gain(studio.session, GAIN) == preset)
    wait_for(lambda: float(field.input_value()) == preset[0])


def test_everything_is_brought_back_to_the_preset(page: sync_api.Page, studio: Any) -> None:
    keys = {GAIN: "3", "translation.damping_ratio": "0.7"}
    preset = {key: flown_gain(studio.session, key) for key in keys}
    for key, value in keys.items():
        set_gain(page, value, key)
    wait_for(lambda: all(flown_gain(studio.session, key)[0] == float(keys[key]) for key in keys))
    take_off(page)
    changed = page.get_by_role("region", name="What was changed")
    changed.get_by_role("button", name="All back to preset").click()
    wait_for(lambda: {key: flown_gain(studio.session, key) for key in keys} == preset)
    changed.get_by_role("button", name="All back to preset").wait_for(state="hidden")


def test_a_page_that_slept_shows_what_flies_and_is_not_flooded(page: sync_api.Page, studio: Any) -> None:
    until(page, "skylimbStudio.past.end > 0.5")
    page.evaluate(
        "() => { window.heard = []; const now = () => window.heard.push(performance.now());"
        " skylimbStudio.line.socket.addEventListener('message', now); }"
    )
    until(page, "window.heard.length > 2")
    before = studio.session.live.time
    change = Set(key=f"controller.{GAIN}", value=3.0, entry=0)
    threading.Timer(1.0, studio.flight.command, [change]).start()
    # A browser that gives a page no turn.
    page.evaluate("() => { const begun = performance.now(); while (performance.now() - begun < 4000); }")
    until(page, f"skylimbStudio.past.end > {before} + 2.0")
    heard = np.array(page.evaluate("window.heard"))
    slept = int(np.argmax(np.diff(heard)))
    assert heard[slept + 1] - heard[slept] > 3000.0
    assert (
        np.sum(heard[slept + 1 :] < heard[slept + 1] + 200.0) < 40
    )  # of 200 frames that were made meanwhile
    page.get_by_label("Search gains and keys").fill(GAIN.replace(".", " ").replace("_", " "))
    field = page.get_by_label(f"controller.{GAIN}, entry 1", exact=True)
    wait_for(lambda: float(field.input_value()) == flown_gain(studio.session, GAIN)[0] == 3.0)
    gap = page.evaluate(
        "Math.max(...skylimbStudio.past.frames.map((frame, i, all) => i ? frame[0] - all[i - 1][0] : 0))"
    )
    assert gap < 0.3  # the past has no hole


def test_absurd_gains_end_in_lost_and_one_press_brings_the_last_good_ones(
    page: sync_api.Page, studio: Any
) -> None:
    good = flown_gain(studio.session, "attitude.normalized_stiffness")
    until(page, "skylimbStudio.past.end > 2.5")
    set_gain(page, "4000", "attitude.normalized_stiffness")
    page.locator("#status").get_by_text("Lost").wait_for()
    page.get_by_role("button", name="Fly again with the last good gains").click()
    wait_for(lambda: not studio.session.live.over)
    wait_for(lambda: flown_gain(studio.session, "attitude.normalized_stiffness") == good)
    until(page, "!skylimbStudio.state.over && skylimbStudio.past.end > 0.5")


def test_a_number_that_is_none_changes_nothing(page: sync_api.Page, studio: Any) -> None:
    flown = flown_gain(studio.session, GAIN)
    for typed, obeyed in {"e": 0.7, "-1": 0.71, "1e999": 0.72, "nan": 0.73}.items():
        field = set_gain(page, typed)
        page.keyboard.press("Tab")
        wait_for(lambda field=field: not field.input_value() or float(field.input_value()) == flown[0])
        set_gain(page, str(obeyed), "translation.damping_ratio")  # what comes next is obeyed
        wait_for(lambda obeyed=obeyed: flown_gain(studio.session, "translation.damping_ratio")[0] == obeyed)
        assert flown_gain(studio.session, GAIN) == flown
    changes = of_kind(studio.session.live.flights[0].experiment, GainChange)
    assert all(one.key != GAIN for one in changes)


def test_a_reload_in_the_middle_of_a_branch_shows_what_flies(page: sync_api.Page, studio: Any) -> None:
    until(page, "skylimbStudio.past.end > 1.5")
    before = len(studio.session.branches.ways)
    page.get_by_role("slider", name="Time of the flight").focus()
    page.keyboard.press("Home")
    page.keyboard.press("Enter")
    page.reload()
    wait_for(lambda: len(studio.session.branches.ways) == before + 1)
    until(page, "document.body.dataset.ready && skylimbStudio.state.scene === skylimbStudio.number")
    until(page, f"skylimbStudio.state.branches.length === {len(studio.session.branches.ways)}")
    until(page, f"skylimbStudio.state.here === {studio.session.branches.here}")
    until(page, "skylimbStudio.shell.seats.drives")


def test_who_watches_can_press_nothing_that_changes_the_flight(
    run_studio: Callable[..., Any], browser: sync_api.Browser, tmp_path: Path
) -> None:
    with run_studio(tmp_path, token=TOKEN) as studio, silent_page(browser) as page:
        page.goto(studio.server.access.watching_url)
        until(page, "document.body.dataset.ready && skylimbStudio.past.end > 0.2")
        can = page.evaluate(
            "() => [...document.querySelectorAll('.drives button, .drives input, .drives select')]"
            ".filter((one) => one.checkVisibility() && !one.closest('[inert]') && !one.matches(':disabled'))"
            ".map((one) => one.outerHTML.slice(0, 90))"
        )
        assert can == []
        assert not page.get_by_role("button", name="Take over").is_visible()
        flight = studio.session.live.flights[0]
        page.locator("#picture canvas").focus()
        page.keyboard.press("r")
        page.get_by_text("You watch").first.wait_for()
        assert studio.session.live.flights[0] is flight


@pytest.mark.slow
def test_after_a_syntax_error_the_page_says_which_version_flies(
    browser: sync_api.Browser, run_studio: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "still.py"
    save_failing_controller(file, 10**9)
    good = file.read_text(encoding="utf-8")
    with run_studio(tmp_path / "out", str(file)) as studio, browser.new_context() as context:
        page = context.new_page()
        page.goto(studio.url)
        until(page, "document.body.dataset.ready && skylimbStudio.past.end > 0.2")
        file.write_text(good + "def broken(:\n", encoding="utf-8")
        alert = page.get_by_role("alert").filter(has_text="What flies is still.py as it was at")
        alert.wait_for(timeout=60_000)
        file.write_text(good, encoding="utf-8")
        alert.wait_for(state="hidden", timeout=60_000)


@contextmanager
def served(port: int, out: Path) -> Iterator[subprocess.Popen[str]]:
    """A studio as a user starts it, on a port and with a token that stay the same."""
    command = [sys.executable, "-m", "skylimb", "studio", "free_flight", "--no-browser"]
    command += ["--port", str(port), "--token", TOKEN, "--out", str(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        yield process
        process.kill()


@pytest.mark.slow
def test_a_page_outlives_a_killed_server_and_hears_the_farewell_of_the_next(
    browser: sync_api.Browser, tmp_path: Path
) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with browser.new_context() as context:
        page = context.new_page()
        with served(port, tmp_path) as process:
            page.goto(f"http://127.0.0.1:{port}/?token={TOKEN}")
            until(page, "document.body.dataset.ready && skylimbStudio.past.end > 0.5")
            page.evaluate("window.before = skylimbStudio.figures")
            os.kill(process.pid, signal.SIGKILL)
            until(page, "!skylimbStudio.line.open")
            wait_for(lambda: "onnect" in page.locator("#status").inner_text())
            page.locator("#picture canvas").press("r")
            page.locator("#notes").get_by_text("No connection: nothing is done until it is back.").wait_for()
        with served(port, tmp_path) as process:
            until(page, "skylimbStudio.line.open && skylimbStudio.shell.seats.drives")
            until(page, "skylimbStudio.figures !== window.before && skylimbStudio.past.end > 0.3")
            assert "Another studio answers" in page.locator("#notes").inner_text()
            assert "Flying" in page.locator("#status").inner_text()
            process.terminate()
            wait_for(lambda: "is kept in" in page.locator("#status").inner_text())
            assert process.wait(60) == 0
    assert list(tmp_path.glob("*/log.nc"))
