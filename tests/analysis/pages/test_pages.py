"""Pages of HTML share one base."""

import re
from pathlib import Path

import jinja2
import pytest

from skylimb.analysis.pages.pages import inlined, render_page

PACKAGE = Path(__file__).parents[3] / "src" / "skylimb"


def page_of(folder: Path, text: str, **content) -> str:
    template = folder / "template.html"
    template.write_text('{% extends "page_base.html" %}{% block content %}' + text + "{% endblock %}")
    return render_page(template, title="A < B", **content)


def test_a_page_stands_alone_and_keeps_words_apart_from_markup(tmp_path):
    text = page_of(tmp_path, "<p>{{ words }}</p>", words="<b>&", versions={"skylimb": "1"})
    assert text.startswith("<!doctype html>")
    assert "<title>A &lt; B</title>" in text
    assert "<p>&lt;b&gt;&amp;</p>" in text
    assert "--ink:" in text
    assert "skylimb 1" in text
    assert re.search(r"(src|href)=.http|@import|<script", text) is None


def test_what_is_missing_is_an_error(tmp_path):
    with pytest.raises(jinja2.UndefinedError, match="words"):
        page_of(tmp_path, "{{ words }}", versions={})


def test_a_page_has_filters_of_its_own(tmp_path):
    template = tmp_path / "t.html"
    template.write_text('{% extends "page_base.html" %}{% block content %}{{ 2 | twice }}{% endblock %}')
    assert "\n4" in render_page(template, {"twice": lambda x: 2 * x}, title="", versions={})


def test_every_page_of_the_package_extends_the_base():
    # Parts of pages, and what a notebook shows in its own page.
    parts = ("page_base.html", "page_parts.html", "notebook.html")
    templates = [
        path
        for path in PACKAGE.rglob("*.html")
        if path.name not in parts and path.parent.parent.name != "studio"
    ]
    assert len(templates) >= 4
    for path in templates:
        text = path.read_text(encoding="utf-8")
        assert text.startswith('{% extends "page_base.html" %}'), path
        assert "<html" not in text, path
    code = [path for path in PACKAGE.rglob("*.py") if "<html" in path.read_text(encoding="utf-8")]
    assert code == []


def test_a_file_is_put_into_the_page(tmp_path):
    (tmp_path / "x.png").write_bytes(b"\x89PNG")
    assert inlined(tmp_path / "x.png", "image/png") == "data:image/png;base64,iVBORw=="
