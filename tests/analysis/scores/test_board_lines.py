"""The board's coordinates: which way round, what is drawn and what was meant."""

import json

import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.scores.board import Board, board_of, nominal_path, strokes

SLOPE = np.radians(20.0)


def the_board(log) -> Board:
    board = board_of(log)
    assert board is not None
    return board


def reoriented(log, **changes):
    return log.assign_attrs(surface=json.dumps(json.loads(log.attrs["surface"]) | changes))


def test_seen_from_the_robot_left_is_left(make_log):
    # The robot looks along +x, so +y is on its left whichever way the surface's own u axis runs.
    log = make_log()
    u = np.array(json.loads(log.attrs["surface"])["axis_u"])
    for axis in (u, -u):
        board = the_board(reoriented(log, axis_u=axis.tolist()))
        left, up = board.origin + 0.2 * u, board.origin + np.array([0.0, 0.0, 0.1])
        np.testing.assert_allclose(
            board.coordinates(np.stack([left, up])), [[-0.2, 0.0], [0.0, 0.1]], atol=1e-12
        )


def test_a_circle_of_the_cog_is_an_ellipse_on_a_sloped_board(make_log):
    log = make_log(error=(0.03, 0.04, 0.05))
    board = the_board(log)
    path = board.coordinates(nominal_path(log, board))
    np.testing.assert_allclose(np.ptp(path, axis=0), [0.6 / np.cos(SLOPE), 0.6], rtol=1e-5)
    np.testing.assert_allclose(path.mean(axis=0), [0.0, 0.0], atol=1e-3)
    on_plane = (nominal_path(log, board) - board.origin) @ board.normal
    np.testing.assert_allclose(on_plane, 0.0, atol=1e-12)


def test_strokes_are_the_stretches_in_touch(make_log):
    log = make_log()
    (whole,) = strokes(log)
    assert whole.stop - whole.start == int(log.contact.sum())
    middle = (whole.start + whole.stop) // 2
    log.contact[middle : middle + 5] = 0  # 25 ms: the pen hardly left
    assert strokes(log) == [whole]
    log.contact[middle : middle + 40] = 0
    assert strokes(log) == [slice(whole.start, middle), slice(middle + 40, whole.stop)]


def test_the_cut_at_a_height_lies_on_the_board(make_log):
    board = the_board(make_log())
    cut = board.cut(1.35)
    np.testing.assert_allclose(cut[:, 2], 1.35)
    np.testing.assert_allclose((cut - board.origin) @ board.normal, 0.0, atol=1e-12)
    assert np.linalg.norm(cut[-1] - cut[0]) == pytest.approx(1.0)


def test_a_curved_surface_is_met_and_unrolled(make_log):
    radius = 1.0
    u = np.linspace(-0.6, 0.6, 241)
    relief = {
        "u": u.tolist(),
        "v": [-1.0, 1.0],
        "height": np.repeat((radius - np.sqrt(radius**2 - u**2))[:, None], 2, axis=1).tolist(),
        "unrolled_u": (radius * np.arcsin(u / radius)).tolist(),
    }
    log = reoriented(make_log(), kind="cylinder", axis_u=[0.0, 1.0, 0.0], normal=[-1.0, 0.0, 0.0], **relief)
    board = the_board(log)
    points = board.project(np.array([[0.0, 0.4, 1.3], [0.0, 0.0, 1.3]]), np.array([1.0, 0.0, 0.0]))
    depth = radius - np.sqrt(radius**2 - 0.4**2)
    np.testing.assert_allclose(points, [[1.2 + depth, 0.4, 1.3], [1.2, 0.0, 1.3]], atol=1e-5)
    np.testing.assert_allclose(board.coordinates(points), [[-np.arcsin(0.4), 0.1], [0.0, 0.1]], atol=1e-5)
    np.testing.assert_allclose(board.cut(1.3, 0.4)[-1], [1.2 + depth, 0.4, 1.3], atol=1e-5)


def test_without_a_surface_the_path_stays_where_the_cog_is_sent(make_log):
    log = make_log(error=(0.0, 0.0, 0.0)).assign_attrs(surface="")
    assert board_of(log) is None
    expected = log.cog_position_reference.values[log.phase.values == 4] + [1.2, 0.0, 0.0]
    np.testing.assert_allclose(nominal_path(log, None), expected)


def test_a_law_that_leads_the_pen_has_the_pens_reference(make_log):
    log = make_log(error=(0.0, 0.0, 0.0)).assign_attrs(surface="")
    tip = log.cog_position_reference + xr.DataArray([1.1, 0.02, 0.03], dims="axis")
    log = log.assign(tip_position_reference=tip)
    sliding = log.phase.values == 4
    expected = log.cog_position_reference.values[sliding] + [1.2, 0.0, 0.0]
    np.testing.assert_allclose(nominal_path(log, None), expected)
    led = log.assign(cog_position_target=log.cog_position_reference)
    np.testing.assert_allclose(nominal_path(led, None), tip.values[sliding])
