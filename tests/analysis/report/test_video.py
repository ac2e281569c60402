"""The video has the pictures that it should, and where none can be drawn it says so."""

import av
import mujoco
import numpy as np
import pytest
from PIL import Image

from skylimb.analysis.figures import scene
from skylimb.analysis.report import video
from skylimb.analysis.report.film import encode, frame_samples, main
from skylimb.analysis.report.overlay import Overlay
from skylimb.analysis.report.places import film_mark
from skylimb.analysis.report.video import find_renderer, write_video
from skylimb.analysis.scores.board import board_of
from skylimb.base.errors import OutputError

SIZE = (320, 180)


@pytest.fixture
def fresh_probe():
    find_renderer.cache_clear()
    yield
    find_renderer.cache_clear()


def decoded(path):
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(stream)]
        return pictures, stream


def test_samples_of_the_pictures():
    times = 0.005 * np.arange(1001)
    np.testing.assert_array_equal(frame_samples(times, fps=20, speed=2.0), np.arange(0, 1001, 20))
    np.testing.assert_array_equal(frame_samples(times[:1], fps=20, speed=1.0), [0])


def test_encoded_pictures_come_back(tmp_path):
    shades = [20, 90, 160, 230]
    pictures = [np.full((180, 320, 3), shade, np.uint8) for shade in shades]
    assert encode(iter(pictures), tmp_path / "x.mp4", SIZE, 24) == 4
    back, stream = decoded(tmp_path / "x.mp4")
    assert [round(float(picture.mean())) for picture in back] == pytest.approx(shades, abs=4)
    assert (stream.codec_context.name, stream.codec_context.pix_fmt, stream.average_rate) == (
        "h264",
        "yuv420p",
        24,
    )


def test_the_trace_grows_on_the_face_of_the_board(make_run):
    log = make_run(error=(0.0, 0.0, 0.0)).log
    drawn_line = scene.pen_trace(log, np.array([1.0, 0.0, 0.0]))
    drawn = np.sum(np.linalg.norm(drawn_line.ends[:, 1] - drawn_line.ends[:, 0], axis=1))
    tip = log.tip_position.values[log.contact.values > 0]
    assert drawn == pytest.approx(np.sum(np.linalg.norm(np.diff(tip, axis=0), axis=1)), rel=0.02)
    assert (np.diff(drawn_line.since) > 0).all()
    assert log.contact.values[drawn_line.since].all()
    view = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), 2000)
    board = board_of(log)
    assert board is not None
    lines = scene.Lines([drawn_line], board, np.zeros((log.sizes["time"], 3)))
    for since, expected in (
        (int(drawn_line.since[0]) - 1, 0),
        (int(drawn_line.since[9]), 10),
        (int(drawn_line.since[4]), 5),
    ):
        view.ngeom = 0
        lines.draw(view, since)
        assert view.ngeom == expected
    offset = (view.geoms[5].pos - drawn_line.ends[5].mean(axis=0)) @ board.normal
    assert offset == pytest.approx(scene.LIFT, rel=1e-3)


def drawn_places(lines, view, sample, others=0):
    view.ngeom = others
    lines.draw(view, sample)
    return np.array([view.geoms[index].pos for index in range(others, view.ngeom)])


@pytest.mark.parametrize("moving", [False, True])
def test_lines_are_the_same_whichever_moments_were_drawn_before(make_run, moving):
    log = make_run(error=(0.0, 0.0, 0.0)).log
    board = board_of(log)
    drawn_lines = [scene.nominal_line(log, board), scene.pen_trace(log, np.array([1.0, 0.0, 0.0]))]
    motion = np.linspace(0.0, 0.1 if moving else 0.0, log.sizes["time"])[:, None] * np.array([1.0, 0.0, 0.0])
    view = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), 2000)
    lines = scene.Lines(drawn_lines, board, motion)
    early, late = int(drawn_lines[1].since[3]), int(drawn_lines[1].since[40])
    at_once = drawn_places(scene.Lines(drawn_lines, board, motion), view, late)
    assert len(at_once) == len(drawn_lines[0].since) + 41
    for sample in (early, late):
        grown = drawn_places(lines, view, sample)
    np.testing.assert_array_equal(grown, at_once)
    # More of the model's own geoms in front of them, and back again.
    np.testing.assert_array_equal(drawn_places(lines, view, late, others=7), at_once)
    np.testing.assert_array_equal(drawn_places(lines, view, late), at_once)
    few = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), 20)
    assert len(drawn_places(scene.Lines(drawn_lines, board, motion), few, late)) == 20


def test_a_line_moves_with_its_surface_from_when_it_was_drawn(make_run):
    log = make_run(error=(0.0, 0.0, 0.0)).log
    board = board_of(log)
    drawn_line = scene.pen_trace(log, np.array([1.0, 0.0, 0.0]))
    motion = np.arange(log.sizes["time"])[:, None] * np.array([1e-4, 0.0, 0.0])
    view = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), 2000)
    lines, since = scene.Lines([drawn_line], board, motion), int(drawn_line.since[5])
    first, later = drawn_places(lines, view, since), drawn_places(lines, view, since + 100)
    np.testing.assert_allclose(later[5] - first[5], [0.01, 0.0, 0.0], atol=1e-6)


def test_the_camera_stands_on_the_side_that_the_board_faces(make_run):
    log = make_run(slide=1.0).log
    board = board_of(log)
    assert board is not None
    camera = scene.camera_of(log, board)
    azimuth, elevation = np.radians([camera.azimuth, camera.elevation])
    looking = np.array(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
    )
    assert looking @ board.normal < -0.5


def test_what_is_drawn_moves_with_its_surface():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body euler='0 0 90'><joint name='surface_slide' type='slide' axis='1 0 0'/>"
        "<geom size='.1'/></body></worldbody></mujoco>"
    )
    moved = scene.surface_motion(model, np.array([[0.1], [0.3]]))
    np.testing.assert_allclose(moved, [[0, 0, 0], [0, 0.2, 0]], atol=1e-12)
    still = mujoco.MjModel.from_xml_string("<mujoco/>")
    np.testing.assert_array_equal(scene.surface_motion(still, np.zeros((2, 0))), np.zeros((2, 3)))


def test_words_are_written_on_the_picture_and_nowhere_else(make_run):
    run = make_run(slide=1.0)
    blank = np.full((720, 1280, 3), 100, np.uint8)
    early, late = (Overlay(run, (1280, 720), 2.0).draw(blank, sample) for sample in (0, 600))
    assert (blank == 100).all()
    assert (early[:, 400:] == 100).all()
    assert (early[200:500] == 100).all()
    assert (early[24:128, 24:364] != 100).any()
    assert (early != late).any()


def test_a_flight_becomes_a_film(make_run, tmp_path):
    if find_renderer() is None:
        pytest.skip("no off-screen renderer on this machine")
    run = make_run(slide=2.0, dt=0.01)
    told = []
    path = write_video(
        run, tmp_path / "x.mp4", size=SIZE, fps=10, speed=2.0, progress=lambda *step: told.append(step)
    )
    pictures, stream = decoded(path)
    expected = len(frame_samples(run.log.time.values, 10, 2.0))
    assert len(pictures) == expected == stream.frames
    assert told[-1] == (expected, expected)
    changed = np.abs(pictures[expected // 2].astype(int) - pictures[0].astype(int)).max(axis=2) > 40
    assert 0.01 < changed.mean() < 0.5
    assert pictures[0].std() > 20
    assert [path.name for path in tmp_path.iterdir()] == ["x.mp4"]
    assert film_mark(run).encode() in path.read_bytes()


def test_without_a_renderer_it_says_so(make_run, tmp_path, monkeypatch, fresh_probe):
    monkeypatch.setattr(video, "_PYTHON", ["false"])
    assert find_renderer() is None
    with pytest.raises(OutputError, match=r"no off-screen renderer works here \(tried MUJOCO_GL = "):
        write_video(make_run(slide=1.0), tmp_path / "x.mp4")
    assert list(tmp_path.iterdir()) == []


def test_a_renderer_that_crashes_on_the_way_leaves_nothing(make_run, tmp_path, monkeypatch):
    monkeypatch.setattr(video, "find_renderer", lambda: "egl")
    monkeypatch.setattr(video, "_PYTHON", ["sh", "-c", "echo 1 20; echo driver gave up >&2; kill -SEGV $$"])
    with pytest.raises(OutputError, match="driver gave up"):
        write_video(make_run(slide=1.0), tmp_path / "x.mp4")
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_filmed_is_refused(make_run, tmp_path):
    run = make_run(slide=1.0)
    with pytest.raises(OutputError, match="must be even"):
        write_video(run, tmp_path / "x.mp4", size=(321, 180))
    run.log.attrs["scene"] = ""
    with pytest.raises(OutputError, match="holds no scene"):
        write_video(run, tmp_path / "x.mp4")
    bare = make_run(slide=1.0)
    object.__setattr__(bare, "log", bare.log.drop_vars("configuration"))
    with pytest.raises(OutputError, match="holds no signal 'configuration'"):
        write_video(bare, tmp_path / "x.mp4")


def test_the_drawing_process_explains_itself(tmp_path, capsys):
    how = '{"size": [320, 180], "fps": 10, "speed": 2, "threads": 0}'
    assert main([str(tmp_path / "none.nc"), str(tmp_path / "x.mp4"), how]) == 1
    assert "none.nc' does not exist" in capsys.readouterr().err


def test_pillow_reads_the_font_of_the_overlay(make_run):
    picture = Overlay(make_run(slide=1.0), SIZE, 1.0).draw(np.zeros((180, 320, 3), np.uint8), 0)
    assert Image.fromarray(picture).size == SIZE
