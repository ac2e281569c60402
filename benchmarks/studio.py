"""How well the studio keeps time: late ticks, updates, how soon a gain acts, the first picture, memory.

    python benchmarks/studio.py --seconds 60        (--seconds 3600 for an hour; --write for docs/studio.md)

The studio runs as a user's would, in a process of its own, with its page open in a headless Chromium that
draws in software. First nobody touches anything; then a second page without a picture changes a gain every
second. Then many flights are flown at 20 times the real speed, to see whether memory grows from one to the
next. It exits with 1 when a figure falls short of what is wanted.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from playwright import sync_api
from rich.console import Console
from rich.table import Table
from websockets.sync.client import ClientConnection, connect

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
GAIN = "controller.translation.normalized_stiffness"
BEFORE, AFTER = [2.5, 2.5, 1.5], [3.0, 3.0, 2.0]
GUIDE = Path(__file__).parents[1] / "docs" / "studio.md"
BEGIN, END = "<!-- pace: written by benchmarks/studio.py -->", "<!-- end of pace -->"
FLIGHTS = 40
"""To see whether memory grows."""

SETTLING = 5.0
"""Seconds that aren't counted: the page has just been opened."""


@dataclass
class Found:
    """What was measured; rates in 1/s, times in s, memory in MB by time in s."""

    first_picture: float = 0.0
    numbers: int = 0
    late: float = 0.0
    late_with_changes: float = 0.0
    flown: int = 0
    updates: float = 0.0
    pictures: float = 0.0
    answers: list[float] = field(default_factory=list)
    memory: list[float] = field(default_factory=list)

    @property
    def growth(self) -> float:
        """Of the memory, MB a flight: from the third quarter of the flights to the last, by medians."""
        quarter = len(self.memory) // 4
        before, after = self.memory[2 * quarter : 3 * quarter], self.memory[3 * quarter :]
        return (statistics.median(after) - statistics.median(before)) / quarter


@contextmanager
def studio(experiment: str, out: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A studio in a process of its own, and its address."""
    command = [sys.executable, "-m", "skylimb", "studio", experiment, "--no-browser", "--out", out]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    line = process.stdout.readline()
    try:
        yield process, line.split()[2]
    finally:
        process.terminate()
        process.wait(timeout=20)


def event(page: ClientConnection, name: str) -> dict[str, Any]:
    """The next event of a name."""
    while True:
        message = page.recv(timeout=20)
        if isinstance(message, str):
            content = json.loads(message)
            if content["event"] == name:
                return content


def measure(experiment: str, seconds: float) -> Found:
    """Open the studio, watch it for some seconds."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise SystemExit(f"studio.py: none of {', '.join(BROWSERS)} is installed")
    found = Found()
    with sync_api.sync_playwright() as playwright, tempfile.TemporaryDirectory() as out:
        chromium = playwright.chromium.launch(executable_path=browser, args=ARGUMENTS)
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        begun = time.perf_counter()
        with studio(experiment, out) as (process, url):
            page.goto(url)
            page.wait_for_selector("body[data-ready]")
            while not page.evaluate("skylimbStudio.past.end > 0.05"):
                time.sleep(0.01)
            found.first_picture = time.perf_counter() - begun
            time.sleep(SETTLING)
            address, _, token = url.partition("?")
            second_page = address.replace("http", "ws") + f"socket?page=benchmark&{token}"
            origin: Any = address.rstrip("/")
            with connect(second_page, origin=origin, max_size=2**24) as second:
                _watch(found, page, second, process.pid, seconds)
        chromium.close()
    return found


def _watch(found: Found, page: sync_api.Page, second: ClientConnection, process: int, seconds: float) -> None:
    found.numbers = event(second, "hello")["scene"]["layout"]["size"]
    second.send('{"do": "take over"}')
    page.evaluate(
        "() => { window.counted = 0;"
        " skylimbStudio.line.addEventListener('frame', () => { window.counted++; }); }"
    )
    pictures = []
    begun, first = time.perf_counter(), event(second, "pace")
    last = first
    while time.perf_counter() - begun < seconds / 2:
        last = _pace(page, second)
        pictures.append(float(page.evaluate("document.body.dataset.framesPerSecond") or 0))
    found.late, found.flown = _late(first, last), last["flown"] - first["flown"]
    found.updates = page.evaluate("window.counted") / (time.perf_counter() - begun)
    found.pictures = statistics.median(pictures)
    begun, first = time.perf_counter(), event(second, "pace")
    value = BEFORE
    while time.perf_counter() - begun < seconds / 2:
        value = AFTER if value is BEFORE else BEFORE
        sent = time.perf_counter()
        second.send(json.dumps({"do": "set", "key": GAIN, "value": value}))
        while event(second, "state")["gains"][0].get(GAIN.removeprefix("controller.")) != value:
            pass
        found.answers.append(time.perf_counter() - sent)
        time.sleep(1.0)
        last = _pace(page, second)
    found.late_with_changes = _late(first, last)
    found.flown += last["flown"] - first["flown"]
    second.send('{"do": "speed", "times": 20}')
    for _ in range(FLIGHTS):
        second.send('{"do": "restart"}')
        event(second, "restarted")
        for _ in range(4):
            second.send(json.dumps({"do": "set", "key": GAIN, "value": AFTER}))
            event(second, "pace")
        found.memory.append(_memory(process))


def _pace(page: sync_api.Page, second: ClientConnection) -> dict[str, Any]:
    """The newest count of ticks; a flight that is over takes off again."""
    last = event(second, "pace")
    if page.evaluate("skylimbStudio.state.over"):
        second.send('{"do": "restart"}')
        event(second, "restarted")
    return last


def _late(first: dict[str, Any], last: dict[str, Any]) -> float:
    """Late ticks of a thousand."""
    return 1000.0 * (last["late"] - first["late"]) / max(1, last["flown"] - first["flown"])


def _memory(process: int) -> float:
    """Resident memory, MB."""
    status = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    line = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


Row = tuple[str, str, str, bool]
"""What was measured, its value, what is wanted (empty where nothing is), whether it holds."""


def rows_of(found: Found) -> list[Row]:
    """What was measured beside what is wanted."""
    slowest, late = 1e3 * max(found.answers), found.late
    first, more = found.first_picture, found.growth
    usual = 1e3 * statistics.median(found.answers)
    return [
        ("Ticks late by more than 5 ms, of 1000", f"{late:.2f}", "at most 1", late <= 1),
        ("... while a gain changes every second", f"{found.late_with_changes:.2f}", "", True),
        ("Updates that reach the page, 1/s", f"{found.updates:.1f}", "at least 20", found.updates >= 20),
        ("Numbers in an update", f"{found.numbers}", "at least 60", found.numbers >= 60),
        ("Pictures that it draws, in software, 1/s", f"{found.pictures:.1f}", "", True),
        ("A gain acts after, ms, median", f"{usual:.1f}", "", True),
        (f"... the slowest of {len(found.answers)}", f"{slowest:.1f}", "at most 100", slowest <= 100),
        ("From the command to a moving picture, s", f"{first:.2f}", "at most 3", first <= 3),
        ("Memory in the end, MB", f"{found.memory[-1]:.0f}", "", True),
        ("Its growth, MB a flight", f"{more:+.2f}", "at most 0.2", more <= 0.2),
    ]  # fmt: skip


def report(found: Found, rows: Sequence[Row], seconds: float) -> int:
    """Print the table; 1 when something falls short."""
    table = Table(title=f"The studio over {seconds:.0f} s, {found.flown} ticks", title_justify="left")
    for column in ("", "Measured", "Wanted", ""):
        table.add_column(column)
    for name, value, wanted, good in rows:
        table.add_row(name, value, wanted, _judged(wanted, good))
    Console(width=100).print(table)
    return 0 if all(good for *_, good in rows) else 1


def write(found: Found, rows: Sequence[Row], seconds: float) -> None:
    """Put the table into the guide."""
    text = GUIDE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    lines = [
        f"{seconds:.0f} s of `paper` with `hybrid`, {found.flown} ticks, {os.cpu_count()} processors:",
        "",
        "| | measured | wanted | |",
        "|---|---|---|---|",
        *(f"| {name} | {value} | {wanted} | {_judged(wanted, good)} |" for name, value, wanted, good in rows),
    ]
    GUIDE.write_text("\n".join([before + BEGIN, "", *lines, "", END + after]), encoding="utf-8")


def _judged(wanted: str, good: bool) -> str:
    return "" if not wanted else "holds" if good else "FALLS SHORT"


def main() -> int:
    """Read the command line, measure, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--experiment", default="paper")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--write", action="store_true", help="put the table into docs/studio.md")
    given = parser.parse_args()
    found = measure(given.experiment, given.seconds)
    rows = rows_of(found)
    if given.write:
        write(found, rows, given.seconds)
    return report(found, rows, given.seconds)


if __name__ == "__main__":
    raise SystemExit(main())
