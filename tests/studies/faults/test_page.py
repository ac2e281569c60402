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
