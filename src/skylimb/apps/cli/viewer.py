"""Shows a recorded flight in MuJoCo's own viewer, or without a display as a page for a browser."""

from __future__ import annotations

import os
import sys
import tempfile
import time
import webbrowser
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.base.errors import OutputError

PAGE = "view.html"
"""Name of the page that shows flights again."""


def show_runs(runs: Mapping[str, Run], folder: Path, speed: float) -> None:
    """Show the flights one after the other; closing the window leaves.

    Args:
        runs: with `scene` (the model) and `configuration` (its positions over time) in their logs.
        folder: where they came from; without a display, the page that shows them is written there.
        speed: times the real speed.

    Raises:
        OutputError: when a run was recorded without its scene, or the page cannot be written.
    """
    for name, run in runs.items():
        if "configuration" not in run.log or not run.log.attrs.get("scene"):
            raise OutputError(f"run '{name}' was recorded without its scene; there is nothing to show")
    if not _has_display():
        _show_page(runs, folder, speed)
        return
    for name, run in runs.items():
        if not _show(name, run, speed):
            return


def _has_display() -> bool:
    """Whether a window can be opened; on macOS MuJoCo's viewer asks for a launcher of its own."""
    if sys.platform == "darwin":
        return False
    return sys.platform == "win32" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _show_page(runs: Mapping[str, Run], folder: Path, speed: float) -> None:
    """Write the view as one file, which needs no network; open it where a browser can be."""
    from skylimb.analysis.viewer.page import FlightViewer
    from skylimb.base.files import replace_text, writing

    page = FlightViewer(runs, speed=speed).page
    place = folder if os.access(folder, os.W_OK) else Path(tempfile.mkdtemp(prefix="skylimb-"))
    path = place / PAGE
    with writing(path):
        replace_text(path, page)
    opened = sys.platform == "darwin" and webbrowser.open(path.absolute().as_uri())
    print(f"No display here. {'Opened' if opened else 'Open'} this page in a browser:\n  {path}")


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
