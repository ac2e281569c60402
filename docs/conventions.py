"""Draw the frames and signs of a robot: docs/images/conventions.svg, which a test holds up to date.

    python docs/conventions.py

Three panels under each other, narrow enough for a telephone: from the side, from above, two rotors.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from html import escape
from pathlib import Path

FILE = Path(__file__).parent / "images" / "conventions.svg"

WIDTH, HEIGHT = 500, 1042
LEAN, HEADING = 6.0, 20.0
"""Of {C} from the root, and of the robot from x of W, degrees."""

STYLE = """
text { font: 17px system-ui, sans-serif; fill: var(--ink); } .title { font-weight: 700; }
.x { --c: var(--red); } .y { --c: var(--green); } .z { --c: var(--blue); } .grey { --c: var(--soft); }
.line { stroke: var(--c); stroke-width: 3; fill: none; } .fill, .name { fill: var(--c); }
.name { font-weight: 700; font-style: italic; } .thin { stroke-width: 1.5; }
.dash { stroke-dasharray: 5 4; } .page { fill: var(--page); } .soft { fill: var(--soft); }
.body { fill: var(--body); stroke: var(--soft); stroke-width: 1.5; }
.disc { fill: var(--disc); stroke: var(--soft); }
.wall { fill: var(--wall); } .star { fill: var(--ink); }
svg { --page: #fff; --ink: #1a1a1a; --soft: #555; --body: #d9d9d9; --disc: #eef2f6; --wall: #c9b28a;
  --red: #b00020; --green: #1b6e2c; --blue: #0b57b5; }
@media (prefers-color-scheme: dark) {
  svg { --page: #1e2127; --ink: #ececec; --soft: #b9bec6; --body: #4a505b; --disc: #2a2f38;
    --wall: #80693f; --red: #ff8090; --green: #6fd083; --blue: #7db8ff; }
}
"""


def drawing() -> str:
    """The picture as SVG."""
    words = "Frames and signs: world, root, centre of gravity, tool, path and rotors"
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
            f'viewBox="0 0 {WIDTH} {HEIGHT}" role="img">',
            f"<title>{words}</title>",
            f"<style>{STYLE}</style>",
            f'<rect class="page" width="{WIDTH}" height="{HEIGHT}" rx="8"/>',
            *_side(),
            *_above(),
            *_rotors(),
            "</svg>\n",
        ]
    )


def _side() -> Iterator[str]:
    """A robot before a board, x to the right and z up; y goes away from who looks."""
    yield from _text(16, 30, "From the side", "title")
    root, cog, tip = (150.0, 170.0), (170.0, 200.0), (416.0, 228.0)
    yield f'<rect class="wall" x="{tip[0] + 8}" y="60" width="16" height="246"/>'
    for x in (-72, 72):
        yield f'<rect class="body" x="{root[0] + x - 3}" y="132" width="6" height="34"/>'
        yield f'<ellipse class="disc" cx="{root[0] + x}" cy="130" rx="56" ry="5"/>'
        yield from _arrow(root[0] + x, 128, 90, 56, "z")
    yield from _text(root[0] + 84, 76, "thrust: z of {F}")
    yield f'<rect class="body" x="{root[0] - 80}" y="160" width="160" height="18" rx="5"/>'
    elbow = (312.0, 244.0)
    yield from _rod((228.0, 174.0), elbow)
    yield from _rod(elbow, tip)
    yield from _axes(*root, 0.0, ("x", "z"), 44)
    yield from _text(14, 196, "{B} root")
    yield f'<circle class="star" cx="{cog[0]}" cy="{cog[1]}" r="6"/>'
    yield from _axes(*cog, -LEAN, ("x", "z"), 56, "dash")
    yield from _text(128, 226, "{C}")
    along = math.degrees(math.atan2(elbow[1] - tip[1], tip[0] - elbow[0]))
    yield f'<circle class="fill x" cx="{tip[0]}" cy="{tip[1]}" r="8"/>'
    yield from _axes(*tip, along, ("x", "z"), 50)
    yield from _text(356, 272, "tool", anchor="middle")
    # Where the path lies.
    yield from _arrow(tip[0] + 8, 122, 0, 46, "x", "a")
    yield from _arrow(tip[0] + 8, 122, 90, 56, "z", "v")
    yield from _text(tip[0] - 4, 120, "path on a board", anchor="end")
    yield from _ruler(cog[0], tip[0], 306, "reach r")
    for x, y in (cog, tip):
        yield f'<line class="line thin dash grey" x1="{x}" y1="{y + 8}" x2="{x}" y2="306"/>'
    yield from _axes(40, 300, 0.0, ("x", "z"), 48)
    yield from _away(40, 300)
    yield from _text(24, 330, "W, y away")


def _above() -> Iterator[str]:
    """The same from above, x to the right and y up, with its heading turned from x of W."""
    top = 372.0
    yield from _text(16, top, "From above", "title")
    middle = (150.0, top + 190.0)
    for k, spin in enumerate((-1, 1, -1, 1)):
        x, y = _at(middle, 45.0 + 90.0 * k + HEADING, 92.0)
        yield from _rod(middle, (x, y), 8.0)
        yield from _disc(x, y, 46.0, spin)
    x, y = middle
    yield f'<rect class="body" x="{x - 34}" y="{y - 26}" width="68" height="52" rx="8" {_turn(middle)}/>'
    tip = _at(middle, HEADING, 262.0)
    yield from _rod(_at(middle, HEADING, 34.0), tip)
    yield (f'<rect class="wall" x="{tip[0] + 8}" y="{tip[1] - 92}" width="16" height="184" {_turn(tip)}/>')
    yield f'<circle class="fill x" cx="{tip[0]:.1f}" cy="{tip[1]:.1f}" r="8"/>'
    yield from _arrow(*tip, HEADING, 66, "x", "a")
    yield from _arrow(*_at(tip, HEADING, -4.0), 90.0 + HEADING, 70, "y", "u")
    # The heading, from x of W.
    yield f'<line class="line thin dash grey" x1="{x}" y1="{y}" x2="{x + 200}" y2="{y}"/>'
    end = _at(middle, HEADING, 160.0)
    yield f'<path class="line grey" d="M{x + 160} {y}A160 160 0 0 0 {end[0]:.1f} {end[1]:.1f}"/>'
    yield from _text(x + 172, y + 22, "heading")
    yield from _axes(*middle, HEADING, ("x", "y"), 60)
    yield from _axes(40, top + 330, 0.0, ("x", "y"), 48)
    yield from _text(24, top + 356, "W, z to you")
    yield from _text(200, top + 316, "paths turn from u to v = a × u")
    yield from _text(200, top + 338, "for direction = 1")


def _rotors() -> Iterator[str]:
    """Both senses of spin, seen against the thrust."""
    top = 772.0
    yield from _text(16, top, "Rotors, seen against their thrust", "title")
    for x, spin, said in ((110.0, 1, "spin = 1, about +z"), (370.0, -1, "spin = −1, about −z")):
        yield from _disc(x, top + 100, 62.0, spin)
        yield f'<circle class="fill z" cx="{x}" cy="{top + 100}" r="5"/>'
        yield from _text(x, top + 200, said, anchor="middle")
        yield from _bend(x, top + 100, 80.0, -spin, "grey dash", 70.0)
    yield from _text(250, top + 232, "Dashed: its drag turns the body the other way,", anchor="middle")
    yield from _text(250, top + 254, "by −spin · κ · thrust about z", anchor="middle")


def _at(start: tuple[float, float], angle: float, length: float) -> tuple[float, float]:
    """The point so far along an angle (degrees, counterclockwise) from another."""
    turn = math.radians(angle)
    return start[0] + length * math.cos(turn), start[1] - length * math.sin(turn)


def _turn(about: tuple[float, float]) -> str:
    return f'transform="rotate({-HEADING} {about[0]:.1f} {about[1]:.1f})"'


def _text(x: float, y: float, words: str, kind: str = "", anchor: str = "start") -> Iterator[str]:
    yield f'<text class="{kind}" x="{x:g}" y="{y:g}" text-anchor="{anchor}">{escape(words)}</text>'


def _arrow(
    x: float, y: float, angle: float, length: float, kind: str, name: str = "", more: str = ""
) -> Iterator[str]:
    end, neck = _at((x, y), angle, length), _at((x, y), angle, length - 10.0)
    sides = [_at(neck, angle + side, 5.0) for side in (90.0, -90.0)]
    corners = "L".join(f"{px:.1f} {py:.1f}" for px, py in (end, *sides))
    yield f'<g class="{kind}"><line class="line {more}" x1="{x:.1f}" y1="{y:.1f}" '
    yield f'x2="{neck[0]:.1f}" y2="{neck[1]:.1f}"/><path class="fill" d="M{corners}z"/>'
    if name:
        px, py = _at(end, angle, 12.0)
        yield f'<text class="name" x="{px:.1f}" y="{py + 6:.1f}" text-anchor="middle">{name}</text>'
    yield "</g>"


def _axes(
    x: float, y: float, turn: float, names: tuple[str, str], length: float, more: str = ""
) -> Iterator[str]:
    for name, angle in zip(names, (0.0, 90.0), strict=True):
        yield from _arrow(x, y, angle + turn, length, name, name, more)


def _away(x: float, y: float) -> Iterator[str]:
    """An axis that goes into the page: a circle with a cross."""
    yield f'<g class="y"><circle class="page" cx="{x}" cy="{y}" r="8"/>'
    yield f'<circle class="line" cx="{x}" cy="{y}" r="8"/>'
    yield f'<path class="line" d="M{x - 5} {y - 5}l10 10m-10 0l10 -10"/></g>'


def _rod(start: tuple[float, float], end: tuple[float, float], thick: float = 12.0) -> Iterator[str]:
    x, y = start
    length, angle = math.dist(start, end), math.degrees(math.atan2(end[1] - y, end[0] - x))
    yield f'<rect class="body" x="{x:.1f}" y="{y - 0.5 * thick:.1f}" width="{length:.1f}" '
    yield f'height="{thick:g}" rx="4" transform="rotate({angle:.2f} {x:.1f} {y:.1f})"/>'


def _disc(x: float, y: float, radius: float, spin: int) -> Iterator[str]:
    """A rotor seen against its thrust, with the sense in which it turns."""
    yield f'<circle class="disc" cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}"/>'
    yield from _bend(x, y, 0.62 * radius, spin, "z" if spin > 0 else "x", 210.0)


def _bend(x: float, y: float, radius: float, sense: int, kind: str, sweep: float) -> Iterator[str]:
    """A part of a circle with an arrow's head at its end, counterclockwise for a sense of 1."""
    start, end = 90.0 - 0.5 * sense * sweep, 90.0 + 0.5 * sense * sweep
    (x0, y0), (x1, y1) = (_at((x, y), angle, radius) for angle in (start, end))
    tip = _at((x1, y1), end + 90.0 * sense, 13.0)
    sides = [_at((x1, y1), end + turned, 6.0) for turned in (0.0, 180.0)]
    corners = "L".join(f"{px:.1f} {py:.1f}" for px, py in (tip, *sides))
    yield f'<g class="{kind}"><path class="line {"dash" * ("dash" in kind)}" d="M{x0:.1f} {y0:.1f}'
    yield f'A{radius:g} {radius:g} 0 {int(sweep > 180.0)} {int(sense < 0)} {x1:.1f} {y1:.1f}"/>'
    yield f'<path class="fill" d="M{corners}z"/></g>'


def _ruler(start: float, end: float, y: float, words: str) -> Iterator[str]:
    yield f'<path class="line thin grey" d="M{start} {y}H{end}M{start} {y - 5}v10M{end} {y - 5}v10"/>'
    yield from _text(0.5 * (start + end), y + 20, words, anchor="middle")


if __name__ == "__main__":
    FILE.write_text(drawing(), encoding="utf-8")
