"""Reports in a real browser: on a phone nothing is cut off, and on paper a still stands for the replay."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from playwright import sync_api

import skylimb
from chromium import beyond, needs_chromium, silent_page
from skylimb.analysis.notebook_run import Run
from skylimb.analysis.report.output import write_comparison, write_run

pytestmark = needs_chromium

EVENTS = [
    {"kind": "push", "time": 0.2, "duration": 0.3, "force": [0.0, 2.0, 0.0]},
    {"kind": "gain", "time": 0.6, "key": "translation.normalized_stiffness", "value": [3.0, 3.0, 2.0]},
]


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory, four_runs: Mapping[str, Run]) -> dict[str, Path]:
    """The report of a flight with events, and that of a comparison."""
    folder = tmp_path_factory.mktemp("reports")
    run = skylimb.run("free_flight", "hybrid", set={"stop_at": 1.0, "events": EVENTS})
    write_run(run, folder / "run")
    write_comparison(four_runs, folder / "comparison")
    return {name: folder / name / "report.html" for name in ("run", "comparison")}


@pytest.fixture
def page(browser: sync_api.Browser) -> Iterator[sync_api.Page]:
    with silent_page(browser, offline=True) as page:
        yield page


def opened(page: sync_api.Page, report: Path) -> None:
    page.goto(report.as_uri())
    page.wait_for_selector("#replay[data-ready]", timeout=60_000)


@pytest.mark.parametrize("name", ["run", "comparison"])
@pytest.mark.parametrize("width", [360, 390])
def test_nothing_is_cut_off_on_a_phone(
    page: sync_api.Page, reports: dict[str, Path], name: str, width: int
) -> None:
    page.set_viewport_size({"width": width, "height": 844})
    opened(page, reports[name])
    assert beyond(page) == []


@pytest.mark.parametrize("width", [390, 1000, 1400])
def test_the_words_above_a_table_of_many_columns_are_not_cut_off(
    page: sync_api.Page, reports: dict[str, Path], width: int
) -> None:
    """Of ten controllers the line above the numbers was as long as the table, and the page cut it off."""
    page.set_viewport_size({"width": width, "height": 844})
    opened(page, reports["run"])
    ends = page.evaluate(
        "() => { const words = document.querySelector('.scroll caption'), scroll = words.closest('.scroll');"
        " words.parentElement.style.width = '2500px';"
        " return [words.getBoundingClientRect().right, scroll.getBoundingClientRect().right]; }"
    )
    assert ends[0] <= ends[1] + 1.0


def test_what_is_printed_has_a_still_of_the_moment_that_is_shown(
    page: sync_api.Page, reports: dict[str, Path]
) -> None:
    opened(page, reports["run"])
    still = page.locator(".replay img.still")
    assert not still.is_visible()
    page.locator(".replay canvas").first.focus()
    page.keyboard.press("Shift+ArrowRight")
    printed = page.pdf(print_background=True)
    assert still.get_attribute("alt") == "The flight in three dimensions, 1.00 s after take-off"
    width = page.evaluate("document.querySelector('.replay img.still').naturalWidth")
    assert any(re.search(rb"/Width %d\b" % width, part) for part in images_of(printed))


def images_of(pdf: bytes) -> Iterator[bytes]:
    """The heads of the pictures in a PDF file, also where they stand in packed objects."""
    for part in re.split(rb"endobj", pdf):
        head, _, packed = part.partition(b"stream")
        if b"/Image" in head:
            yield head
        if b"/ObjStm" in head:
            yield zlib.decompress(packed.strip(b"\r\n").partition(b"endstream")[0])


def test_what_happened_is_a_table_and_a_push_has_its_arrow(
    page: sync_api.Page, reports: dict[str, Path]
) -> None:
    opened(page, reports["run"])
    rows = page.locator("#events ~ details").first.locator("tbody tr")
    assert [" ".join(row.split("\t")) for row in rows.all_inner_texts()] == [
        "1 0.200 0.3 push 2 N on the centre of gravity",
        "2 0.600 0.5 gain translation.normalized_stiffness to [3.0, 3.0, 2.0]",
    ]
    mark = page.locator(".replay .mark").first
    mark.click()  # goes to where the push begins
    assert page.evaluate("skylimbReplay.sceneView.figures[0].events[0].arrow.visible")
    page.locator(".replay canvas").first.focus()
    page.keyboard.press("End")
    assert not page.evaluate("skylimbReplay.sceneView.figures[0].events[0].arrow.visible")
