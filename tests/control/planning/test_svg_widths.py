"""How wide the strokes of a drawing are."""

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.control.planning.svg_lines import svg_lines

WIDE = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 100"><g fill="none" stroke="red">'


@pytest.mark.parametrize(
    ("words", "width"),
    [
        ("stroke-width='3'", 3.0),
        ("stroke-width='2mm'", 2.0 / 25.4 * 96.0),
        ("style='stroke-width:5%'", 0.05 * np.hypot(200.0, 100.0) / np.sqrt(2.0)),
        ("stroke-width='4' transform='scale(3 1)'", 4.0 * np.sqrt(3.0)),
        ("stroke-width='4' transform='scale(3)' vector-effect='non-scaling-stroke'", 4.0),
    ],
)
def test_a_stroke_is_as_wide_as_it_is_shown(words: str, width: float) -> None:
    (line,) = svg_lines(f"{WIDE}<path {words} d='M0 0H9'/></g></svg>".encode(), "it")
    assert line[0, 2] == pytest.approx(width, rel=1e-6)


def test_a_stroke_without_width_is_not_drawn() -> None:
    (line,) = svg_lines(
        f"{WIDE}<path d='M0 0H9'/><path stroke-width='0' d='M0 5H9'/></g></svg>".encode(), "it"
    )
    np.testing.assert_array_equal(line[:, 1], 0.0)


@pytest.mark.parametrize("width", ["wide", "-2", "2em", "1e999", "nan", "inherit"])
def test_a_width_that_is_none_is_refused(width: str) -> None:
    with pytest.raises(ConfigError, match=f"it has stroke-width = '{width}', which is no width"):
        svg_lines(f"{WIDE}<path stroke-width='{width}' d='M0 0H9'/></g></svg>".encode(), "it")
