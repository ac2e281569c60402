"""A path with a force of its own: from stroke widths, from the way of words, or from beginning to end."""

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.control.planning.drawing import clean, nearest_first
from skylimb.control.planning.drawing_sources import text_strokes
from skylimb.control.planning.trajectories import drawing_strokes, trajectory
from skylimb.control.planning.trajectory_config import TrajectoryConfig

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100" fill="none" stroke="black">'
BOTH = f'{HEAD}<path d="M0 0 H50" stroke-width="2"/><path d="M50 0 H100" stroke-width="6"/></svg>'


@pytest.fixture
def drawn(tmp_path):
    def drawn(svg, **more):
        file = tmp_path / "it.svg"
        file.write_text(svg, encoding="utf-8")
        return TrajectoryConfig(shape="drawing", file=str(file), width=0.4, **more)

    return drawn


def test_stroke_widths_become_forces_where_they_are(drawn):
    config = drawn(BOTH, force=(0.5, 2.0), speed=0.05)
    path = trajectory(config)
    t = np.linspace(0.0, path.duration, 2000)
    u, force = path.sample(t)[0][:, 0], path.force(t)
    # Who looks along the contact axis has u to the left.
    np.testing.assert_allclose(force[u > 0.01], 0.5, atol=1e-6)
    np.testing.assert_allclose(force[u < -0.01], 2.0, atol=1e-6)
    assert force.min() >= 0.5 - 1e-9
    assert force.max() <= 2.0 + 1e-9


def test_a_width_under_a_transform_is_the_width_as_it_is_seen(drawn):
    grown = '<g transform="scale(3)"><path d="M0 0 H10" stroke-width="2"/></g>'
    thin = '<path d="M0 9 H10" stroke-width="6"/><path d="M0 20 H30" stroke-width="1"/>'
    widths = drawing_strokes(drawn(f"{HEAD}{grown}{thin}</svg>", force=(1.0, 2.0))).widths
    assert [float(each[0]) for each in widths] == pytest.approx([2.0, 2.0, 1.0])


def test_the_path_is_the_same_with_and_without_a_force(drawn):
    plain, pressed = (trajectory(drawn(BOTH, **more)) for more in ({}, {"force": (0.5, 2.0)}))
    t = np.linspace(0.0, plain.duration, 500)
    assert pressed.duration == plain.duration
    # A stroke that changes its width has a point more; it lies on the same line.
    np.testing.assert_allclose(pressed.sample(t)[0], plain.sample(t)[0], atol=1e-9)
    np.testing.assert_array_equal(plain.force(t), 0.0)


def test_words_are_thin_upward_and_wide_downward():
    (line,), (widths,) = (getattr(text_strokes("l"), name) for name in ("lines", "widths"))
    down = line[0, 1] > line[-1, 1]
    np.testing.assert_allclose(widths, 1.0 if down else 0.0, atol=1e-9)
    strokes = text_strokes("sky", "scripts")
    for line, widths in zip(strokes.lines, strokes.widths, strict=True):
        assert len(line) == len(widths)
        assert ((widths >= 0.0) & (widths <= 1.0)).all()


@pytest.mark.parametrize("order", ["given", "nearest"])
@pytest.mark.parametrize("direction", [1, -1])
def test_widths_stay_with_their_points(drawn, order, direction):
    lines = "".join(f'<path d="M{10 * i} {i} v40" stroke-width="{i + 1}"/>' for i in range(5))
    plain = drawing_strokes(drawn(f"{HEAD}{lines}</svg>", force=(1.0, 5.0)))
    other = drawing_strokes(drawn(f"{HEAD}{lines}</svg>", force=(1.0, 5.0), order=order, direction=direction))
    # By the stroke's place along u.
    of_place = {
        round(line[0, 0], 6): widths[0] for line, widths in zip(plain.lines, plain.widths, strict=True)
    }
    for line, widths in zip(other.lines, other.widths, strict=True):
        np.testing.assert_allclose(widths, of_place[round(line[0, 0], 6)])


def test_nearest_first_and_clean_keep_widths():
    points = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 3.0]])
    strokes = nearest_first(clean([points, points + np.array([5.0, 0.0, 1.0])], "it"))
    assert [each.tolist() for each in strokes.widths] == [[1.0, 3.0], [2.0, 4.0]]


def test_another_path_presses_from_beginning_to_end():
    path = trajectory(TrajectoryConfig(shape="line", length=0.3, force=(1.0, 3.0)))
    t = np.array([-1.0, 0.0, 0.5 * path.duration, path.duration, path.duration + 9.0])
    np.testing.assert_allclose(path.force(t), [1.0, 1.0, 2.0, 3.0, 3.0])


def test_one_width_says_nothing_of_two_forces(drawn):
    even = f'{HEAD}<path d="M0 0 H50"/></svg>'
    with pytest.raises(
        ConfigError, match=r"all strokes of the drawing have one width.*\[2, 2\] presses evenly"
    ):
        drawing_strokes(drawn(even, force=(1.0, 2.0)))
    (force,) = drawing_strokes(drawn(even, force=(2.0, 2.0))).widths
    np.testing.assert_allclose(force, 2.0)


@pytest.mark.parametrize(
    "more", [{"shape": "circle", "force": (1.0, 2.0)}, {"shape": "drawing", "text": "a"}]
)
def test_a_soft_pen_needs_a_drawing_and_a_force(more):
    with pytest.raises(ConfigError, match=r"brush.*needs trajectory.shape = 'drawing' and trajectory.force"):
        TrajectoryConfig(brush=0.01, **more)


@pytest.mark.parametrize("force", [(0.0, 1.0), (1.0, 99.0), (1.0, float("nan"))])
def test_a_force_out_of_range_is_refused(force):
    with pytest.raises(ConfigError, match="force"):
        TrajectoryConfig(force=force)
