"""Replays a recorded flight in MuJoCo's own viewer."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from skylimb.errors import OutputError
from skylimb.recording.run import Run


def replay(runs: Mapping[str, Run], folder: Path, speed: float) -> None:
    """Show the flights one after the other; closing the window leaves.

    Args:
        runs: with `scene` (the model) and `configuration` (its positions over time) in their logs.
        folder: where they came from, to name the files that show the flight without a display.
        speed: times the real speed.

    Raises:
        OutputError: when a run was recorded without its scene.
    """
    for name, run in runs.items():
        if "configuration" not in run.log or not run.log.attrs.get("scene"):
            raise OutputError(f"run '{name}' was recorded without its scene; there is nothing to replay")
    if not _has_display():
        made = [*sorted(folder.glob("report.html")), *sorted(folder.glob("**/video.mp4"))]
        print(
            "No display here. These show the flight in a browser:"
            if made
            else f"No display here, and no report in {folder}: skylimb report {folder}"
        )
        print("".join(f"  {path}\n" for path in made), end="")
        return
    for name, run in runs.items():
        if not _show(name, run, speed):
            return


def _has_display() -> bool:
    """Whether a window can be opened; on macOS MuJoCo's viewer asks for a launcher of its own."""
    if sys.platform == "darwin":
        return False
    return sys.platform == "win32" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _show(name: str, run: Run, speed: float) -> bool:
    """Play one flight; False when the window was closed before its end."""
    import mujoco
    import mujoco.viewer

    model = mujoco.MjModel.from_xml_string(str(run.log.attrs["scene"]))
    data = mujoco.MjData(model)
    times = run.log["time"].values
    configurations = run.log["configuration"].values
    print(f"{name}: {times[-1]:.1f} s at {speed:g} times the real speed; close the window to leave")
    with mujoco.viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False) as window:
        start = time.monotonic()
        while window.is_running():
            now = (time.monotonic() - start) * speed
            if now > times[-1]:
                return True
            data.qpos[:] = configurations[min(int(np.searchsorted(times, now)), len(times) - 1)]
            mujoco.mj_forward(model, data)
            window.sync()
            time.sleep(1.0 / 60.0)
    return False
