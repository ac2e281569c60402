"""The tutorial's notebook runs from its first cell to its last, and what it shows is what comes out now."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).parents[1] / "examples" / "tutorial.ipynb"


def printed(notebook: Any) -> list[str]:
    """What the cells printed or showed as text; a picture's words and a dataset's sizes may differ."""
    texts = []
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            text = output.get("text") or output.get("data", {}).get("text/plain", "")
            if not text.startswith(("<Figure", "<xarray")):
                texts.append(text)
    return texts


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_the_notebook_runs_and_shows_what_is_committed() -> None:
    notebook: Any = nbformat.read(NOTEBOOK, as_version=4)
    committed = printed(notebook)
    client = NotebookClient(notebook, timeout=200, resources={"metadata": {"path": str(NOTEBOOK.parent)}})
    client.execute()
    assert printed(notebook) == committed
    pictures = [
        output
        for cell in notebook.cells
        for output in cell.get("outputs", ())
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) >= 3
