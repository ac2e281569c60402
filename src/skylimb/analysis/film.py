"""Draws a run's flight picture by picture and encodes it, in a process of its own (see `video`).

The process is told by its environment (MUJOCO_GL) how to draw without a window. A graphics driver that
crashes takes this process with it and nothing else.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import av
import mujoco
import numpy as np
from av.error import FFmpegError
from PIL import ImageColor

from skylimb.analysis import scene, style
from skylimb.analysis.board import board_of
from skylimb.analysis.overlay import Overlay
from skylimb.errors import OutputError
from skylimb.recording import Run

_PROBE = "<mujoco><worldbody><light/><geom size='.1'/></worldbody></mujoco>"


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
    camera = scene.place_camera(log, board)
    rgb = np.array(ImageColor.getrgb(style.colours({run.name: run})[run.name])) / 255
    inks = scene.nominal_ink(log, board), scene.trace_ink(log, rgb)
    configuration = log.configuration.values
    motion = scene.surface_motion(model, configuration)
    overlay = Overlay(run, size, speed)
    with mujoco.Renderer(model, height=size[1], width=size[0], max_geom=4000) as renderer:
        for sample in frame_samples(log.time.values, fps, speed):
            data.qpos[:] = configuration[sample]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera)
            for ink in inks:
                scene.draw_ink(renderer.scene, ink, sample, board, motion[sample] - motion)
            yield overlay.draw(renderer.render(), sample)


def encode(frames: Iterable[np.ndarray], path: Path, size: tuple[int, int], fps: int) -> int:
    """Write pictures as an MP4 that every browser plays (H.264, yuv420p), and return how many there were."""
    count = 0
    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=fps, options={"preset": "veryfast", "crf": "24"})
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
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
    """Entry point of the drawing process: LOG MP4, or --probe to find out whether drawing works at all."""
    parser = argparse.ArgumentParser(prog="film")
    parser.add_argument("--probe", action="store_true")
    parser.add_argument("log", nargs="?", type=Path)
    parser.add_argument("film", nargs="?", type=Path)
    parser.add_argument("--size", nargs=2, type=int, default=(1280, 720))
    parser.add_argument("--fps", type=int, default=20)
    parser.add_argument("--speed", type=float, default=2.0)
    asked = parser.parse_args(arguments)
    if asked.probe:
        with mujoco.Renderer(mujoco.MjModel.from_xml_string(_PROBE), 16, 16) as renderer:
            renderer.update_scene(mujoco.MjData(renderer.model))
            return 0 if renderer.render().shape == (16, 16, 3) else 1
    try:
        run = Run.load(asked.log)
        size = asked.size[0], asked.size[1]
        total = len(frame_samples(run.log.time.values, asked.fps, asked.speed))
        encode(_reported(pictures(run, size, asked.fps, asked.speed), total), asked.film, size, asked.fps)
    except (OutputError, ValueError, KeyError, FFmpegError, mujoco.FatalError) as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
