"""A video of a flight, drawn off-screen; where no renderer exists it says so.

Drawing happens in a child process: how MuJoCo draws is settled by MUJOCO_GL when it is first imported, which
in this process was long ago, and a broken graphics driver may crash.
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from skylimb.analysis.recording import LOG_FILE, Run
from skylimb.base.errors import OutputError, missing_extra
from skylimb.base.files import new_file

SIZE = (960, 540)
FPS = 20
SPEED = 2.0
"""Seconds of flight in a second of film."""

PROBE_SECONDS = 120

FILM, PROBE = "skylimb.analysis.report.film", "skylimb.analysis.report.renderer_probe"
"""Modules that run in a process of their own."""
_PYTHON = (sys.executable, "-m")

FilmProgress = Callable[[int, int], None]
"""Called with (pictures done, pictures in all)."""


@cache
def find_renderer() -> str | None:
    """The value of MUJOCO_GL with which this machine can draw off-screen, or None where it can't at all.

    What the environment says is taken at its word; otherwise egl, osmesa and then a window system are
    tried, each in a process of its own.
    """
    for name in _candidates():
        try:
            probe = subprocess.run(
                [*_PYTHON, PROBE],
                env=_environment(name),
                capture_output=True,
                timeout=PROBE_SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            continue
        if probe.returncode == 0:
            return name
    return None


def _candidates() -> tuple[str, ...]:
    given = os.environ.get("MUJOCO_GL", "")
    if given:
        return (given,)
    return ("egl", "osmesa", "glfw") if sys.platform.startswith("linux") else ("glfw",)


def write_video(
    run: Run,
    path: str | Path,
    *,
    size: tuple[int, int] = SIZE,
    fps: int = FPS,
    speed: float = SPEED,
    progress: FilmProgress | None = None,
) -> Path:
    """Draw a run's flight as an MP4 file with the growing trace of its pen.

    Args:
        run: its log needs `configuration` and the attribute `scene`.
        path: a file that doesn't exist yet.
        size: width and height in pixels, even numbers.
        fps: pictures a second of film.
        speed: seconds of flight in a second of film.
        progress: called with how far the film is.

    Returns:
        The path written.

    Raises:
        OutputError: if the file exists, the log holds no scene, or this machine has no renderer.
    """
    with tempfile.TemporaryDirectory() as folder:
        log = run.save(Path(folder) / LOG_FILE)
        return film_record(run, log, path, size=size, fps=fps, speed=speed, progress=progress)


def film_record(
    run: Run,
    log: Path,
    path: str | Path,
    *,
    size: tuple[int, int] = SIZE,
    fps: int = FPS,
    speed: float = SPEED,
    progress: FilmProgress | None = None,
    threads: int = 0,
) -> Path:
    """The same of a run whose record lies in a file already.

    Args:
        run: what the record holds.
        log: the record.
        path: as for `write_video`.
        size: as for `write_video`.
        fps: as for `write_video`.
        speed: as for `write_video`.
        progress: as for `write_video`.
        threads: of a renderer in software; 0 leaves them to it.

    Raises:
        OutputError: as for `write_video`.
    """
    missing = [
        name for name in ("configuration", "tip_position", "cog_position") if name not in run.log.variables
    ]
    if missing or not run.log.attrs.get("scene"):
        what = f"signal '{missing[0]}'" if missing else "scene"
        raise OutputError(f"no video of '{run.name}': its log holds no {what}")
    if size[0] % 2 or size[1] % 2 or min(size) < 2:
        raise OutputError(
            f"no video of '{run.name}': width and height must be even, got {size[0]} x {size[1]}"
        )
    if importlib.util.find_spec("av") is None:
        raise OutputError(f"no video of '{run.name}': {missing_extra('av')}")
    renderer = find_renderer()
    if renderer is None:
        tried = ", ".join(_candidates())
        raise OutputError(
            f"no video of '{run.name}': no off-screen renderer works here (tried MUJOCO_GL = {tried})"
        )
    with new_file(path) as aside:
        how = json.dumps({"size": size, "fps": fps, "speed": speed, "threads": threads})
        command = [*_PYTHON, FILM, str(log), str(aside), how]
        _draw(command, _environment(renderer, threads), run.name, progress)
    return Path(path)


def _draw(command: list[str], environment: dict[str, str], name: str, progress: FilmProgress | None) -> None:
    with tempfile.TemporaryFile("w+") as complaints:
        process = subprocess.Popen(
            command, env=environment, stdout=subprocess.PIPE, stderr=complaints, text=True
        )
        try:
            for line in process.stdout or ():
                done, total = map(int, line.split())
                if progress is not None:
                    progress(done, total)
        except BaseException:
            process.kill()
            raise
        finally:
            code = process.wait()
        complaints.seek(0)
        lines = complaints.read().strip().splitlines()
    if code != 0:
        reason = lines[-1] if lines else f"the drawing process ended with code {code}"
        raise OutputError(f"no video of '{name}': {reason}")


def _environment(renderer: str, threads: int = 0) -> dict[str, str]:
    """The child's environment: how to draw, and where this package lies however it was found here."""
    home = str(Path(__file__).parents[3])
    path = os.pathsep.join(part for part in (home, os.environ.get("PYTHONPATH", "")) if part)
    environment = {**os.environ, "MUJOCO_GL": renderer, "PYTHONPATH": path}
    if threads:
        environment.setdefault("LP_NUM_THREADS", str(threads))  # of Mesa's renderer without a graphics card
    return environment
