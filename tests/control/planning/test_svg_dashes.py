"""Dashes of an SVG file: as a browser draws them, in every unit and under every transform."""

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.control.planning.svg_lines import svg_lines


def drawn(element: str, view: str = 'viewBox="0 0 100 100" width="100" height="100"') -> list[np.ndarray]:
    """Lines of an SVG with one element, x and y down as in the file."""
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {view}>{element}</svg>'
    return [line[:, :2] * [1.0, -1.0] for line in svg_lines(text.encode(), "mine.svg")]


def spans(element: str, **more: str) -> list[tuple[float, float]]:
    """Where along x the lines begin and end."""
    return [(round(float(line[0, 0]), 6), round(float(line[-1, 0]), 6)) for line in drawn(element, **more)]


LINE = '<path d="M0 5 H20" stroke="red" fill="none" {}/>'


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ('stroke-dasharray="5 3"', [(0, 5), (8, 13), (16, 20)]),
        ('style="stroke-dasharray:5,3"', [(0, 5), (8, 13), (16, 20)]),
        ('stroke-dasharray="4"', [(0, 4), (8, 12), (16, 20)]),
        ('stroke-dasharray="6 2 1"', [(0, 6), (8, 9), (15, 17), (18, 20)]),
        ('stroke-dasharray="5 3" stroke-dashoffset="2"', [(0, 3), (6, 11), (14, 19)]),
        ('stroke-dasharray="5 3" stroke-dashoffset="-2"', [(2, 7), (10, 15), (18, 20)]),
        ('stroke-dasharray="5% 3%"', [(0, 5), (8, 13), (16, 20)]),
        ('stroke-dasharray="1 1" pathLength="4"', [(0, 5), (10, 15)]),
        ('stroke-dasharray="30"', [(0, 20)]),
        *((f'stroke-dasharray="{word}"', [(0, 20)]) for word in ("none", "0", "0 0", "-1 2", "words", "")),
    ],
)
def test_a_pattern_cuts_a_line(words: str, expected: list[tuple[float, float]]) -> None:
    assert spans(LINE.format(words)) == expected


def test_a_pattern_is_that_of_the_element_before_its_transform() -> None:
    element = f'<g transform="scale(2 9)">{LINE.format("")}</g>'.replace("<g", '<g stroke-dasharray="5 3"')
    assert spans(element) == [(0, 10), (16, 26), (32, 40)]
    millimetres = spans(
        LINE.format('stroke-dasharray="5 3"'), view='viewBox="0 0 20 20" width="40" height="40"'
    )
    assert millimetres == [(0, 10), (16, 26), (32, 40)]


def test_dashes_go_around_corners_and_follow_curves() -> None:
    corner = drawn('<path d="M0 0 H10 V10" stroke="red" fill="none" stroke-dasharray="12 2"/>')
    assert [line.tolist() for line in corner] == [[[0, 0], [10, 0], [10, 0], [10, 2]], [[10, 4], [10, 10]]]
    arcs = drawn('<circle cx="50" cy="50" r="10" stroke="red" fill="none" stroke-dasharray="4 2"/>')
    way = [float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in arcs]
    assert len(way) == 11
    assert way[:10] == pytest.approx([4.0] * 10, rel=2e-3)
    assert np.linalg.norm(np.vstack(arcs) - 50.0, axis=1) == pytest.approx(10.0, abs=3e-3)


def test_each_outline_begins_anew_and_what_is_filled_alone_has_no_dashes() -> None:
    two = LINE.format('stroke-dasharray="15 3"').replace("H20", "H20 M0 8 H20")
    assert spans(two) == [(0, 15), (18, 20)] * 2
    filled = '<path d="M0 5 H20 V9" fill="red" stroke="none" stroke-dasharray="5 3"/>'
    assert len(drawn(filled)) == 1


def test_a_pattern_of_dust_is_refused_in_time() -> None:
    with pytest.raises(ConfigError, match=r"mine\.svg has \d+ strokes, more than"):
        drawn(LINE.format('stroke-dasharray="1e-9"'))
    with pytest.raises(ConfigError, match=r"mine\.svg has \d+ strokes, more than"):
        drawn(LINE.format('stroke-dasharray="1e-300"'))
