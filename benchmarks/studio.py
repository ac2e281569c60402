"""How well the studio keeps time: late ticks, updates, how soon a gain acts, the first picture, memory.

    python benchmarks/studio.py --seconds 60        (3600 for an hour; --write for docs/reports/studio.md)

The studio runs as a user's would, in a process of its own, with its page open in a headless Chromium that
draws in software. First nobody touches anything; then a client without a picture changes a gain every second.
Both are done again with the page closed, which tells what drawing takes from the flight; and beside all of it
another process only sleeps for 5 ms at a time: as late as it wakes, everything here is. Then many flights are
flown at 20 times the real speed, to see whether memory grows from one to the next. It exits with 1 when a
figure falls short of what is wanted.
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
PAGE = Path(__file__).parents[1] / "docs" / "reports" / "studio.md"
BEGIN, END = "<!-- pace: written by benchmarks/studio.py -->", "<!-- end of pace -->"
FLIGHTS = 40
"""To see whether memory grows."""

SETTLING = 5.0
"""Seconds that aren't counted: the page has just been opened."""


@dataclass
class Found:
    """What was measured; rates in 1/s, times in s, memory in MB.

    `late` and `asleep` are of a thousand, of the flight's ticks and of times that the other process slept:
    with the page and nobody's hand, with the page and changes, and both without the page.
    """

    first_picture: float = 0.0
    numbers: int = 0
    late: list[float] = field(default_factory=list)
    asleep: list[float] = field(default_factory=list)
    flown: int = 0
    updates: float = 0.0
    pictures: float = 0.0
    answers: list[float] = field(default_factory=list)
    answers_alone: list[float] = field(default_factory=list)
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


class Client:
    """A page without a picture."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self._over = False

    def say(self, what: str, **content: Any) -> None:
        """Have something done."""
        self._connection.send(json.dumps({"do": what, **content}))

    def event(self, name: str) -> dict[str, Any]:
        """The next event of a name; frames are confirmed."""
        while True:
            message = self._connection.recv(timeout=20)
            if not isinstance(message, str):
                self.say("got", frame=int.from_bytes(message[4:8], "little"))
                continue
            content = json.loads(message)
            if content["event"] == "state":
                self._over = content["over"]
            if content["event"] == name:
                return content

    def pace(self) -> dict[str, Any]:
        """The newest count of ticks; a flight that is over takes off again."""
        last = self.event("pace")
        if self._over:
            self.say("restart")
            self.event("restarted")
        return last


SLEEPER = """
import sys, time
due, ticks, late = time.perf_counter(), 0, 0
while ticks < float(sys.argv[1]) / 0.005:
    due, ticks = due + 0.005, ticks + 1
    time.sleep(max(0.0, due - time.perf_counter()))
    behind = time.perf_counter() - due
    late += behind > 0.015
    due += behind if behind > 0.1 else 0.0
print(1000 * late / ticks)
"""
"""As late as a tick that is late by 5 ms: that may be flown 10 ms early."""


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
            with connect(second_page, origin=origin, max_size=2**24) as connection:
                second = Client(connection)
                found.numbers = second.event("hello")["scene"]["layout"]["size"]
                second.say("take over")
                _count_frames(page)
                _watch(found, second, seconds / 4)
                found.updates = page.evaluate("window.counted") / (seconds / 4)
                found.pictures = float(page.evaluate("document.body.dataset.framesPerSecond") or 0)
                found.answers = _watch(found, second, seconds / 4, True)
                page.close()
                _watch(found, second, seconds / 4)
                found.answers_alone = _watch(found, second, seconds / 4, True)
                found.memory = list(_flights(second, process.pid))
        chromium.close()
    return found


def _count_frames(page: sync_api.Page) -> None:
    page.evaluate(
        "() => { window.counted = 0;"
        " skylimbStudio.line.addEventListener('frame', () => { window.counted++; }); }"
    )


def _watch(found: Found, second: Client, seconds: float, changing: bool = False) -> list[float]:
    """Count late ticks for some seconds, in which a gain may change each second; when each acted, s."""
    command = [sys.executable, "-c", SLEEPER, str(seconds)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as sleeper:
        begun, first = time.perf_counter(), second.event("pace")
        last, value, answers = first, AFTER, list[float]()
        while time.perf_counter() - begun < seconds:
            if changing:
                value = AFTER if value is BEFORE else BEFORE
                answers.append(_change(second, value))
                time.sleep(1.0)
            last = second.pace()
        assert sleeper.stdout is not None
        found.asleep.append(float(sleeper.stdout.read()))
    flown = last["flown"] - first["flown"]
    found.late.append(1000.0 * (last["late"] - first["late"]) / max(1, flown))
    found.flown += flown
    return answers


def _change(second: Client, value: list[float]) -> float:
    """Change a gain; the time until that is flown, s."""
    sent = time.perf_counter()
    second.say("set", key=GAIN, value=value)
    while (state := second.event("state"))["gains"][0].get(GAIN.removeprefix("controller.")) != value:
        if state["over"]:  # just before it: that was refused
            second.say("restart")
            second.event("restarted")
            sent = time.perf_counter()
            second.say("set", key=GAIN, value=value)
    return time.perf_counter() - sent


def _flights(second: Client, process: int) -> Iterator[float]:
    """Memory after each of many flights, MB."""
    second.say("speed", times=20)
    for _ in range(FLIGHTS):
        second.say("restart")
        second.event("restarted")
        for _ in range(4):
            second.say("set", key=GAIN, value=AFTER)
            second.event("pace")
        yield _memory(process)


def _memory(process: int) -> float:
    """Resident memory, MB."""
    status = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    line = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


Row = tuple[str, str, str, bool]
"""What was measured, its value, what is wanted (empty where nothing is), whether it holds."""


def rows_of(found: Found) -> list[Row]:
    """What was measured beside what is wanted."""
    quiet, _, alone, _ = found.late
    late = [f"{flown:.2f} ({slept:.2f})" for flown, slept in zip(found.late, found.asleep, strict=True)]
    first, more = found.first_picture, found.growth
    usual, undrawn = (1e3 * statistics.median(times) for times in (found.answers, found.answers_alone))
    slowest = 1e3 * max(found.answers)
    return [
        ("Ticks late by more than 5 ms, of 1000", late[0], "at most 1", quiet <= 1),
        ("... while a gain changes every second", late[1], "", True),
        ("... without a page that draws", late[2], "at most 1", alone <= 1),
        ("... without it, while a gain changes", late[3], "", True),
        ("Updates that reach the page, 1/s", f"{found.updates:.1f}", "at least 20", found.updates >= 20),
        ("Numbers in an update", f"{found.numbers}", "at least 60", found.numbers >= 60),
        ("Pictures that it draws, in software, 1/s", f"{found.pictures:.1f}", "", True),
        ("A gain acts after, ms, median", f"{usual:.1f}", "", True),
        ("... without a page that draws", f"{undrawn:.1f}", "", True),
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
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    lines = [
        f"{os.cpu_count()} processors (load {os.getloadavg()[0]:.0f}), {seconds:.0f} s, {found.flown} ticks:",
        "",
        "| | measured | wanted |",
        "|---|---|---|",
        *(
            f"| {name} | {value} | {f'{wanted}: {_judged(wanted, good)} ' if wanted else ''}|"
            for name, value, wanted, good in rows
        ),
    ]
    PAGE.write_text("\n".join([before + BEGIN, "", *lines, "", END + after]), encoding="utf-8")


def _judged(wanted: str, good: bool) -> str:
    return "" if not wanted else "holds" if good else "FALLS SHORT"


def main() -> int:
    """Read the command line, measure, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--experiment", default="paper")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--write", action="store_true", help="put the table into docs/reports/studio.md")
    given = parser.parse_args()
    found = measure(given.experiment, given.seconds)
    rows = rows_of(found)
    if given.write:
        write(found, rows, given.seconds)
    return report(found, rows, given.seconds)


if __name__ == "__main__":
    raise SystemExit(main())
