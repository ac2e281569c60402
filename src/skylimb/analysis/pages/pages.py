"""Pages of HTML that stand alone: one base with the style, which the template of each page extends.

A template begins with `{% extends "page_base.html" %}` and fills the blocks `style` and `content`;
`page_parts.html` has what several pages share.
"""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jinja2


def render_page(
    template: Path, filters: Mapping[str, Callable[..., Any]] | None = None, **content: Any
) -> str:
    """A page of HTML.

    Args:
        template: file of a template that extends the base.
        filters: functions that the template calls by name, besides Jinja's own.
        content: what the template shows; the base needs `title`, and `versions` by package ({} for none).

    Raises:
        jinja2.UndefinedError: when the template shows something that `content` lacks.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([template.parent, Path(__file__).parent]),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= filters or {}
    return environment.get_template(template.name).render(**content)


def inlined(path: Path, kind: str) -> str:
    """A file as a URL that holds its bytes; `kind` is its media type."""
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"
