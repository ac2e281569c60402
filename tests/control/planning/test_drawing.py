from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.base.sources import read_source
from skylimb.control.planning.drawing import Strokes, clean, fitted, nearest_first
from skylimb.control.planning.drawing_sources import svg_strokes, text_strokes
from skylimb.control.planning.svg_lines import svg_lines

EXAMPLE = Path(__file__).parents[3] / "examples" / "skylimb.svg"
HEAD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100" width="100" height="100" '
PEN = 'stroke="black" fill="none"'


@pytest.fixture
def read():
    """Strokes of an SVG with the given elements, read in this process."""

    def read(elements: str, head: str = HEAD + ">") -> Strokes:
        return clean(svg_lines(f"{head}{elements}</svg>".encode(), "it"), "it")

    return read


def lines(*points):
    return [np.array(line, dtype=float) for line in points]


def test_lines_and_paths_keep_their_order_and_turn_upright(read):
    found = read(f'<line x1="1" y1="2" x2="3" y2="2" {PEN}/><polyline points="9,9 9,5 4,5" {PEN}/>')
    expected = lines([[1, -2], [3, -2]], [[9, -9], [9, -5], [4, -5]])
    for line, want in zip(found.lines, expected, strict=True):
        np.testing.assert_allclose(line, want)


def test_a_closed_outline_ends_where_it_began(read):
    (polygon,) = read('<polygon points="0,0 4,0 4,3"/>').lines
    np.testing.assert_allclose(polygon[[0, -1]], 0.0)
    (path,) = read('<path d="M1 1 h2 v2 h-2 z"/>').lines
    np.testing.assert_allclose(path, [[1, -1], [3, -1], [3, -3], [1, -3], [1, -1]])


@pytest.mark.parametrize(
    "transform",
    [
        "",
        "translate(50 0) scale(-1 1)",
        "scale(1 -1)",
        "skewX(20) translate(3 3)",
        "rotate(40) scale(2 3)",
    ],
)
@pytest.mark.parametrize(
    ("shape", "centre", "radii"),
    [
        ('<circle cx="10" cy="20" r="5"', (10.0, 20.0), (5.0, 5.0)),
        ('<ellipse cx="10" cy="20" rx="8" ry="3"', (10.0, 20.0), (8.0, 3.0)),
    ],
)
def test_round_shapes_stay_on_their_curve_under_transforms(read, transform, shape, centre, radii):
    from svgelements import Matrix

    matrix: Any = Matrix(transform)
    (line,) = read(f'<g transform="{transform}">{shape} {PEN}/></g>').lines
    backward = ~matrix
    there = np.array([tuple(backward.point_in_matrix_space((x, -y))) for x, y in line])
    size = np.ptp(line, axis=0).max()
    middles = 0.5 * (there[1:] + there[:-1])
    for points in (there, middles):
        away = np.abs(np.linalg.norm((points - centre) / radii, axis=1) - 1.0) * max(radii)
        assert away.max() < 1e-3 * size
    np.testing.assert_allclose(line[0], line[-1], atol=1e-9)
    assert len(line) > 20


def test_curves_arcs_and_rounded_rectangles_are_flattened_finely(read):
    found = read(f'<path d="M0 0 C 0 40 40 40 40 0 Q 60 -30 80 0 A 10 10 0 0 1 100 0" {PEN}/>')
    (line,) = found.lines
    turns = np.diff(np.unwrap(np.arctan2(*np.diff(line, axis=0).T[::-1])))
    assert np.sum(np.abs(turns) > 0.35) <= 2  # only at the joints between the curves
    (rectangle,) = read(f'<rect x="5" y="5" width="30" height="20" rx="4" {PEN}/>').lines
    assert len(rectangle) > 20
    np.testing.assert_allclose(rectangle.min(axis=0), [5, -25], atol=1e-9)


def test_uses_count_and_definitions_alone_do_not(read):
    found = read(f'<defs><path id="p" d="M0 0 L1 1" {PEN}/></defs><use href="#p" x="10"/>')
    (line,) = found.lines
    np.testing.assert_allclose(line, [[10, 0], [11, -1]])


def test_what_cannot_be_seen_is_not_drawn(read):
    found = read(
        f'<rect width="90" height="90" fill="none"/><g display="none"><line x2="50" {PEN}/></g>'
        f'<line x1="1" y1="1" x2="2" y2="1" {PEN}/>'
    )
    assert len(found.lines) == 1


def test_strokes_are_joined_where_ends_meet(read):
    found = read(
        f'<line x1="0" y1="0" x2="9" y2="0" {PEN}/><line x1="9" y1="0" x2="9" y2="9" {PEN}/>'
        f'<line x1="0" y1="9" x2="5" y2="9" {PEN}/>'
    )
    assert [len(line) for line in found.lines] == [3, 2]


@pytest.mark.parametrize(
    ("elements", "words"),
    [
        ("", "nothing to draw"),
        ('<path d="M 3 3"/>', "nothing to draw"),
        ('<rect width="9" height="9" fill="none"/>', "nothing to draw"),
        ('<path d="M0 0 L 1 1e400" stroke="red"/>', "not finite"),
        ('<text x="1" y="2">hi there</text>', r"'hi there'.*--text"),
        ('<image href="a.png" width="3" height="3"/>', "picture"),
    ],
)
def test_what_cannot_be_drawn_is_refused(read, elements, words):
    with pytest.raises(ConfigError, match=words):
        read(elements)


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "is empty"), ("no xml", "not a readable SVG"), ("<svg", "not a readable"), ("<html/>", "no svg")],
)
def test_what_is_no_svg_file_is_refused(tmp_path, text, words):
    file = tmp_path / "bad.svg"
    file.write_text(text)
    with pytest.raises(ConfigError, match=words):
        svg_strokes(read_source(file), str(file))


def test_a_missing_file_names_the_nearest(tmp_path):
    (tmp_path / "spiral.svg").write_text("<svg/>")
    with pytest.raises(ConfigError, match=r"did you mean '.*spiral\.svg'"):
        svg_strokes(read_source(tmp_path / "spirals.svg"), str(tmp_path / "spirals.svg"))


def test_the_example_reads():
    strokes = svg_strokes(read_source(EXAMPLE), str(EXAMPLE))
    assert len(strokes.lines) >= 6
    assert any(len(line) > 50 for line in strokes.lines)


def test_words_stand_upright_and_run_to_the_right():
    strokes = text_strokes("Lo")
    first = strokes.lines[0]
    assert first[0][1] > first[1][1]  # the L begins at its top
    starts = [line[:, 0].mean() for line in strokes.lines]
    assert starts == sorted(starts)
    assert len(text_strokes("Lo", "scripts").lines) >= 1


def test_unknown_fonts_letters_and_blanks_are_refused():
    with pytest.raises(UnknownNameError, match="did you mean 'futural'"):
        text_strokes("hi", "futurals")
    with pytest.raises(ConfigError, match="has no 'é'"):
        text_strokes("café")
    with pytest.raises(ConfigError, match="nothing to draw"):
        text_strokes("  ")


def test_fitting_keeps_proportions_centres_and_mirrors_u():
    strokes = clean(lines([[10, 0], [14, 2]], [[10, 2], [11, 2]]), "it")
    wide = fitted(strokes, 0.4)
    low, high = wide.bounds
    np.testing.assert_allclose([*low, *high], [-0.2, -0.1, 0.2, 0.1])
    np.testing.assert_allclose(wide.lines[0][0], [0.2, -0.1])  # the file's left is +u
    for box in ((0.4, 0.05), (0.0, 0.05)):
        np.testing.assert_allclose(np.ptp(np.array(fitted(strokes, *box).bounds), axis=0), [0.1, 0.05])


def test_sizes_that_cannot_be_are_refused():
    upright = clean(lines([[1, 0], [1, 5]]), "it")
    with pytest.raises(ConfigError, match="give its height"):
        fitted(upright, 0.6)
    np.testing.assert_allclose(fitted(upright, 0.6, 0.2).length, 0.2)
    tall = clean(lines([[0, 0], [1, 100]]), "it")
    with pytest.raises(ConfigError, match="larger side"):
        fitted(tall, 0.6)
    hatched = clean(lines([[x, y] for y in range(1000) for x in ((0, 1000) if y % 2 else (1000, 0))]), "it")
    with pytest.raises(ConfigError, match="m of line"):
        fitted(hatched, 0.6)


def test_a_stroke_needs_points_that_are_numbers():
    for bad in ((), (np.zeros((1, 2)),), (np.array([[0.0, 0.0], [np.nan, 1.0]]),), (np.zeros((3, 3)),)):
        with pytest.raises(ConfigError):
            Strokes(bad)


def test_short_ways_between_strokes_on_request():
    far = clean(lines([[0, 0], [1, 0]], [[9, 0], [8, 0]], [[3, 0], [2, 0]]), "it")
    near = nearest_first(far)
    np.testing.assert_allclose([line[0, 0] for line in near.lines], [0, 2, 8])
    assert near.length == far.length


def test_reversed_strokes_begin_at_the_end():
    strokes = clean(lines([[0, 0], [1, 0]], [[5, 0], [6, 0]]), "it").reversed()
    np.testing.assert_allclose(strokes.lines[0], [[6, 0], [5, 0]])
