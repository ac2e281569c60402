"""Draw the supervisor's table on one page: docs/images/supervisor.svg, which a test holds up to date.

    python docs/supervisor.py

A lane for each mode, a line for each row: from its dots to its arrow, and on the right what it takes.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from html import escape
from pathlib import Path

from skylimb.control.supervisor.table import TABLE, Row

FILE = Path(__file__).parent / "images" / "supervisor.svg"

WIDTH, LANE, LEFT, WORDS = 980, 92, 56, 530
"""Width of the page, distance of the lanes, middle of the first one, and where the words begin, in pixels."""

LINE, GAP, LETTERS = 19, 13, 54
"""Height of a line of words, space between two rows, and letters of a line."""

STYLE = """
text { font: 15px system-ui, sans-serif; fill: var(--ink); } .name { font-weight: 700; }
.key { font-style: italic; }
.small { font-size: 13px; fill: var(--soft); } .lane { stroke: var(--lane); stroke-width: 2; }
.rule { stroke: var(--lane); } .page { fill: var(--page); } .on { fill: #fff; font-weight: 700; }
svg { --page: #fff; --ink: #1a1a1a; --soft: #4d4d4d; --lane: #d4d4d4; }
.m0 { --m: #00734f; } .m1 { --m: #0062a0; } .m2 { --m: #9a5b00; }
.m3 { --m: #a83c00; } .m4 { --m: #8b0017; }
@media (prefers-color-scheme: dark) {
  svg { --page: #1e2127; --ink: #ececec; --soft: #b9bec6; --lane: #454a54; } .on { fill: #14161a; }
  .m0 { --m: #45c99b; } .m1 { --m: #66b7f0; } .m2 { --m: #ecb04a; }
  .m3 { --m: #f08c5a; } .m4 { --m: #f27a85; }
}
.fill { fill: var(--m); } .way { stroke: var(--m); stroke-width: 2.5; fill: none; }
.back { stroke-dasharray: 5 4; } .tip { fill: var(--m); }
"""


def drawing() -> str:
    """The page as SVG."""
    lines = [*_modes(34)]
    top = 34 + 26 * len(TABLE.modes) + 50
    body, bottom = _rows(top)
    lanes = [
        f'<line class="lane" x1="{_lane(k)}" y1="{top - 14}" x2="{_lane(k)}" y2="{bottom - 4}"/>'
        for k in range(len(TABLE.modes))
    ]
    heads = [
        f'<g class="m{k}">'
        f'<rect class="fill" x="{_lane(k) - 43}" y="{top - 40}" width="86" height="26" rx="6"/>'
        f'<text class="on" x="{_lane(k)}" y="{top - 22}" text-anchor="middle">{name}</text></g>'
        for k, name in enumerate(TABLE.modes)
    ]
    more = [
        f'<text class="small" x="14" y="{bottom + 18 + 18 * k}">{line}</text>'
        for k, line in enumerate(_NOTES)
    ]
    height = bottom + 16 + 18 * len(_NOTES)
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img">',
            "<title>The supervisor: its modes, and its table row by row</title>",
            f"<style>{STYLE}</style>",
            f'<rect class="page" width="{WIDTH}" height="{height}" rx="8"/>',
            *lines,
            *lanes,
            *body,
            *heads,
            *more,
            "</svg>\n",
        ]
    )


_NOTES = (
    "Each tick the first row from above that matches says the mode; where none does, the mode stays.",
    "Dots: the modes that a row looks at. Arrow: the mode that follows. Dashed: the only way back.",
)


def _lane(mode: int) -> int:
    return LEFT + LANE * mode


def _modes(top: int) -> Iterator[str]:
    """The modes and what each does."""
    for k, (name, meaning) in enumerate(TABLE.modes.items()):
        y = top + 26 * k
        yield f'<g class="m{k}"><circle class="fill" cx="20" cy="{y - 5}" r="6"/></g>'
        yield f'<text x="36" y="{y}"><tspan class="name">{name}</tspan>'
        yield f'<tspan x="130">{escape(meaning)}</tspan></text>'


def _rows(top: int) -> tuple[list[str], int]:
    """Every row of the table, and where they end."""
    found, y = list[str](), top
    for number, row in enumerate(TABLE.rows, 1):
        words = [*_words(row)]
        found.append(f'<line class="rule" x1="14" y1="{y}" x2="{WIDTH - 14}" y2="{y}"/>')
        found += _way(row, y + (LINE * len(words) + GAP) // 2)
        for k, line in enumerate(words):
            found.append(f'<text x="{WORDS}" y="{y + LINE * (k + 1)}">{line}</text>')
        found.append(f'<text class="small" x="{WORDS - 12}" y="{y + LINE}" text-anchor="end">{number}</text>')
        y += LINE * len(words) + GAP
    return found, y


def _way(row: Row, y: int) -> Iterator[str]:
    """From the dots of a row to its arrow."""
    names = list(TABLE.modes)
    sources, target = [names.index(name) for name in row.source], names.index(row.to)
    ahead = 1 if target > sources[0] else -1
    end = _lane(target) - 3 * ahead
    back = "" if ahead > 0 else " back"
    yield f'<g class="m{target}">'
    yield f'<line class="way{back}" x1="{_lane(sources[0])}" y1="{y}" x2="{end}" y2="{y}"/>'
    yield f'<path class="tip" d="M{end + 4 * ahead} {y}l{-13 * ahead} -7v14z"/></g>'
    for source in sources:
        yield f'<g class="m{source}"><circle class="fill" cx="{_lane(source)}" cy="{y}" r="6"/></g>'


def _words(row: Row) -> Iterator[str]:
    """What a row takes: its bits by name, each with its meaning where there is one only."""
    names = [*row.when, *(f"not {name}" for name in row.unless)]
    said = (
        f"{', '.join(names)}: {TABLE.bits[row.when[0]]}" if len(names) == 1 and row.when else ", ".join(names)
    )
    for k, line in enumerate(textwrap.wrap(said, LETTERS)):
        name, colon, rest = line.partition(":") if not k else ("", "", line)
        rest = re.sub("`(.*?)`", r'<tspan class="key">\1</tspan>', escape(rest))
        yield f'<tspan class="name">{escape(name)}</tspan>{colon}{rest}'


if __name__ == "__main__":
    FILE.write_text(drawing(), encoding="utf-8")
