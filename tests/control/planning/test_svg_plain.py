"""What an SVG file shows in a browser is drawn, where a browser shows it."""

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.control.planning.svg_lines import svg_lines

PEN = 'stroke="black" fill="none"'
BOX = f'<rect width="1" height="1" {PEN}/>'
LINE = f'<path d="M0 0h9" {PEN}/>'
ROUND = f'<circle cx="5" cy="5" r="4" {PEN}/>'


def boxes(elements, head='viewBox="0 0 100 100"'):
    """Left, top, right and bottom of each outline, y down."""
    names = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
    lines = svg_lines(f"<svg {names} {head}>{elements}</svg>".encode(), "it")
    sides = [[*line[:, :2].min(axis=0), *line[:, :2].max(axis=0)] for line in lines]
    return [[left, -top, right, -bottom] for left, bottom, right, top in sides]


@pytest.mark.parametrize(
    ("elements", "expected"),
    [
        (f'<symbol id="s" viewBox="0 0 10 10">{ROUND}</symbol>'
         '<use href="#s" x="30" y="20" width="60" height="60"/>', [36, 26, 84, 74]),
        (f'<symbol id="s" viewBox="0 0 10 10">{ROUND}</symbol><use href="#s"/>', [10, 10, 90, 90]),
        (f'<symbol id="s" viewBox="0 0 10 10" preserveAspectRatio="xMinYMin">{ROUND}</symbol>'
         '<use xlink:href="#s" x="30" y="20" width="60" height="30"/>', [33, 23, 57, 47]),
        (f'<symbol id="s">{ROUND}</symbol><use href="#s" x="30%" y="20%"/>', [31, 21, 39, 29]),
        (f'<symbol id="a" viewBox="0 0 1 1">{BOX}</symbol><symbol id="s" viewBox="0 0 10 10">'
         '<use href="#a" x="2" y="2" width="6" height="6"/></symbol>'
         '<use href="#s" x="30" y="20" width="60" height="60"/>', [42, 32, 78, 68]),
        (f'<defs><svg id="s" viewBox="0 0 10 10" width="20" height="20">{ROUND}</svg></defs>'
         '<use href="#s" x="30" y="20" width="50" height="50"/>', [35, 25, 75, 65]),
        (f'<svg x="30" y="20">{ROUND}</svg>', [31, 21, 39, 29]),
        (f'<svg x="30" y="20" width="60" height="60" viewBox="0 0 2 2">{BOX}</svg>', [30, 20, 60, 50]),
        (f'<ellipse cx="50" cy="50" rx="20" {PEN}/>', [30, 30, 70, 70]),
        (f'<ellipse cx="50" cy="50" rx="auto" ry="10%" {PEN}/>', [40, 40, 60, 60]),
    ],
)  # fmt: skip
def test_a_shape_is_where_and_as_large_as_it_is_shown(elements, expected):
    (box,) = boxes(elements)
    np.testing.assert_allclose(box, expected, atol=0.02)


def test_equal_and_other_sizes_of_a_symbol_stand_side_by_side():
    uses = "".join(
        f'<use href="#s" x="{x}" width="{size}" height="{size}"/>' for x, size in ((0, 6), (10, 20), (40, 6))
    )
    found = boxes(f'<symbol id="s" viewBox="0 0 1 1">{BOX}</symbol>{uses}')
    np.testing.assert_allclose(found, [[0, 0, 6, 6], [10, 0, 30, 20], [40, 0, 46, 6]], atol=1e-9)


@pytest.mark.parametrize(
    "head", ['viewBox="0 0 400 240" width="8in" height="4.8in"', 'width="400" height="240"']
)
def test_percentages_are_of_the_viewport_also_behind_an_inner_one(head):
    inner = f'<svg viewBox="0 0 10 10" width="20" height="20">{ROUND}</svg>'
    (_, ellipse, rect) = boxes(
        f'{inner}<ellipse cx="150" cy="50%" rx="10%" ry="10%" {PEN}/>'
        f'<rect x="10%" y="10%" width="50%" height="50%" {PEN}/>',
        head,
    )
    unit = (rect[2] - rect[0]) / 200.0
    np.testing.assert_allclose(rect, unit * np.array([40, 24, 240, 144]))
    np.testing.assert_allclose(ellipse, unit * np.array([110, 96, 190, 144]), atol=0.1)


def test_a_percentage_of_a_radius_is_of_the_diagonal():
    (box,) = boxes(f'<circle cx="50%" cy="50%" r="10%" {PEN}/>', 'viewBox="0 0 300 100"')
    radius = 0.1 * np.hypot(300, 100) / np.sqrt(2.0)
    np.testing.assert_allclose(box, [150 - radius, 50 - radius, 150 + radius, 50 + radius], atol=0.02)


@pytest.mark.parametrize(
    "hidden",
    [
        f'<symbol id="s">{ROUND}</symbol>',
        f'<mask id="m">{ROUND}</mask>',
        f'<marker id="m">{ROUND}</marker>',
        '<circle r="5" fill="transparent"/>',
        '<circle r="5" fill="rgba(0,0,0,0)"/>',
        '<circle r="5" fill-opacity="0"/>',
        '<circle r="5" fill="none" stroke="red" stroke-opacity="0"/>',
        "<text> <tspan> </tspan></text>",
    ],
)
def test_what_a_browser_does_not_show_is_not_drawn(hidden):
    assert boxes(hidden + LINE) == [[0, 0, 9, 0]]


@pytest.mark.parametrize(
    ("elements", "words"),
    [
        (f'<line x1="1em" x2="2em" {PEN}/>', "x1 = '1em' in a line element, a unit that depends on a font"),
        (f'<circle r="3 vw" {PEN}/>', "r = '3 vw' in a circle element"),
        (
            f'<g transform="scale(2)" transform-origin="5 5">{LINE}</g>',
            r"transform-origin = '5 5'\), which is not",
        ),
        (
            f"<style>.a{{transform:scale(2);transform-origin:center}}</style><g class='a'>{LINE}</g>",
            "'center'",
        ),
        ('<text><textPath href="#q">hi</textPath></text>', "has a text element"),
    ],
)
def test_what_would_be_drawn_elsewhere_is_refused(elements, words):
    with pytest.raises(ConfigError, match=words):
        boxes(elements + LINE)


def test_an_origin_that_moves_nothing_is_none():
    moved = f'<g transform="scale(2)" transform-origin="0 0">{LINE}</g><g transform-origin="5 5">{LINE}</g>'
    assert boxes(moved) == [[0, 0, 18, 0], [0, 0, 9, 0]]
