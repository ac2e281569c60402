"""The page that ships is made of the numbers beside it and of the catalogue that ships."""

from __future__ import annotations

import json
from pathlib import Path

from skylimb.studies.faults import load_catalogue
from skylimb.studies.faults.page import Row, faults_page

DOCS = Path(__file__).parents[3] / "docs"


def test_the_page_is_that_of_its_numbers() -> None:
    rows = [Row(**row) for row in json.loads((DOCS / "faults.json").read_text(encoding="utf-8"))]
    page = (DOCS / "faults.md").read_text(encoding="utf-8")
    assert page == faults_page(load_catalogue(), rows), "fly it anew: skylimb faults, and copy both files"


def test_a_number_stands_below_the_one_who_flew_it() -> None:
    made = [
        Row(fault, name, False, flights, flights, flights, {}, "", "")
        for fault, name, flights in (("rotor at half", "pid", 3), ("push of 4 N", "hybrid", 4))
    ]
    page = faults_page(load_catalogue(), made).splitlines()
    assert "| fault: flights within the bounds | pid, unprotected | hybrid, unprotected |  |" in page
    (pushed,) = [line for line in page if line.startswith("| push of 4 N |")]
    assert pushed.startswith("| push of 4 N |  | 4 of 4")
