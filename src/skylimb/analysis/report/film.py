"""Draws a run's flight picture by picture and encodes it, in a process of its own (see `video`).

The environment of the process (MUJOCO_GL) says how to draw without a window. A graphics driver that
crashes takes this process with it and nothing else.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import av
import mujoco
import numpy as np
from av.error import FFmpegError
from PIL import ImageColor

from skylimb.analysis.figures import palette, scene
from skylimb.analysis.recording import Run
from skylimb.analysis.report.overlay import Overlay
from skylimb.analysis.report.places import film_mark
from skylimb.analysis.scores.board import board_of
from skylimb.base.errors import OutputError


def frame_samples(times: np.ndarray, fps: float, speed: float) -> np.ndarray:
    """The samples that a film shows: the nearest to every 1/fps s of film, shape (frames,).

    Args:
        times: of the samples, s.
        fps: pictures a second of film.
        speed: seconds of flight in a second of film.
    """
    wanted = np.arange(times[0], times[-1] + 1e-9, speed / fps)
    return np.clip(np.searchsorted(times, wanted - 1e-9), 0, len(times) - 1)


def pictures(run: Run, size: tuple[int, int], fps: float, speed: float) -> Iterator[np.ndarray]:
    """Draw the flight.

    Args:
        run: its log holds the scene (MJCF) and the configuration (qpos) over time.
        size: width and height in pixels.
        fps: pictures a second of film.
        speed: seconds of flight in a second of film.

    Yields:
        RGB pictures, shape (height, width, 3), bytes.
    """
    log = run.log
    model = scene.load_model(str(log.attrs["scene"]), size)
    data = mujoco.MjData(model)
    board = board_of(log)
    camera = scene.camera_of(log, board)
    rgb = np.array(ImageColor.getrgb(palette.colours({run.name: run})[run.name])) / 255
    configuration = log.configuration.values
    motion = scene.surface_motion(model, configuration)
    lines = scene.Lines([scene.nominal_line(log, board), scene.pen_trace(log, rgb)], board, motion)
    overlay = Overlay(run, size, speed)
    with mujoco.Renderer(model, height=size[1], width=size[0], max_geom=4000) as renderer:
        for sample in frame_samples(log.time.values, fps, speed):
            data.qpos[:] = configuration[sample]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera)
            lines.draw(renderer.scene, sample)
            yield overlay.draw(renderer.render(), sample)


def encode(
    frames: Iterable[np.ndarray],
    path: Path,
    size: tuple[int, int],
    fps: int,
    threads: int = 0,
    comment: str = "",
) -> int:
    """Write pictures as an MP4 that every browser plays (H.264, yuv420p), and return how many there were.

    Args:
        frames: RGB pictures, shape (height, width, 3), bytes.
        path: of the film.
        size: width and height in pixels.
        fps: pictures a second.
        threads: that encode; 0 for as many as there are cores.
        comment: of the whole film, in its metadata.
    """
    count = 0
    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as container:
        container.metadata["comment"] = comment
        stream = container.add_stream("libx264", rate=fps, options={"preset": "veryfast", "crf": "24"})
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        stream.codec_context.thread_count = threads
        for pixels in frames:
            count += 1
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        container.mux(stream.encode(None))
    return count


def _reported(frames: Iterable[np.ndarray], total: int) -> Iterator[np.ndarray]:
    """Tell the parent process, on standard output, how far the film is."""
    for done, frame in enumerate(frames, start=1):
        yield frame
        if done % 20 == 0 or done == total:
            print(done, total, flush=True)


def main(arguments: list[str] | None = None) -> int:
    """Entry point of the drawing process."""
    log, film, given = sys.argv[1:] if arguments is None else arguments
    how = json.loads(given)  # size, fps, speed, threads
    try:
        run = Run.load(log)
        size, fps, speed = tuple(how["size"]), how["fps"], how["speed"]
        total = len(frame_samples(run.log.time.values, fps, speed))
        frames = _reported(pictures(run, size, fps, speed), total)
        encode(frames, Path(film), size, fps, how["threads"], film_mark(run))
    except (OutputError, ValueError, KeyError, FFmpegError, mujoco.FatalError) as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
