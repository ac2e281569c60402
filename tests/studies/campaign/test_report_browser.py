"""A campaign's report in a real browser: on a phone nothing is cut off; units, and no sign of zero."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from chromium import beyond, chromium, needs_chromium, silent_page
from skylimb.studies.campaign import run_campaign

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def report(write_spec_to: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of three controllers in few draws."""
    home = tmp_path_factory.mktemp("campaign")
    spec = write_spec_to(home, draws=3, controllers='["pid", "hybrid", "impedance"]')
    run_campaign(spec, home / "out", workers=0)
    return home / "out" / "report.html"


@pytest.mark.parametrize("width", [360, 390])
def test_nothing_is_cut_off_on_a_phone(report: Path, width: int) -> None:
    with chromium() as browser, silent_page(browser, offline=True) as page:
        page.set_viewport_size({"width": width, "height": 844})
        page.goto(report.as_uri())
        page.get_by_role("heading", name="Numbers").wait_for()
        assert beyond(page) == []
        heads = page.locator(".values").first.locator("thead th").all_inner_texts()
        assert [head.strip() for head in heads if head.strip()] == ["PID", "Hybrid", "Impedance"]
        words = page.locator("main").inner_text()
        assert re.findall(r"(?<![\d.])[-\u2212]0(?:\.0+)?(?![\d.])", words) == []
        for text, unit in (("|y error|, median", "m"), ("largest tilt", "rad")):
            row = page.locator("tr", has_text=text).first
            assert row.locator(".unit").inner_text() == unit
        assert "Beside a value stands its rank: 1 the best" in " ".join(words.split())
