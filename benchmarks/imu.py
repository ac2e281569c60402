"""What an IMU is worth: thrusts, force and line with rotors that turn the robot; gaps of the motion capture.

    python benchmarks/imu.py --draws 20

prints the tables of docs/reports/imu.md, which says what was flown.
"""

from __future__ import annotations

import argparse
import warnings
from typing import Any

import numpy as np

import skylimb

IMU = {"controller.estimation.smoothing.imu": True}
"""The presets say which gains they have then."""
LOST = 12.0
"""When the motion capture is lost, s: the pen slides."""


def flown(controller: str, seed: int, more: dict[str, Any]) -> skylimb.Run:
    return skylimb.run("paper", controller, seed, {"sensors.imu.on": True, **more})


def whole(controller: str, draws: int, more: dict[str, Any]) -> str:
    """Medians of whole flights: what thrusts jump by a tick, the force's deviation, losses, line."""
    rows, names = [], ("contact_force_normal_std", "contact_losses", "pen_line_rms")
    for seed in range(draws):
        run = flown(controller, seed, more)
        if not run.failed:
            jump = np.sqrt(np.mean(np.diff(run.log.thrusts_command.values, axis=0) ** 2))
            rows.append([jump, *(run.metrics[name] for name in names)])
    jump, force, losses, line = np.median(np.array(rows, dtype=float), axis=0)
    return f"{jump:.3f} | {force:.3f} | {losses:.0f} | {1e3 * line:.2f} | {len(rows)} of {draws}"


def gap(length: float, draws: int, more: dict[str, Any]) -> str:
    """How far the believed centre of gravity is off while nobody sees it, and how far the body tilts."""
    lost = {"kind": "sensor", "time": LOST, "capture": "lost", "duration": length}
    off, tilts = [], []
    for seed in range(draws):
        ends = {"supervisor.on": True, "events": [lost], "stop_at": LOST + length}
        log = flown("following", seed, {**ends, **more}).log
        if log.time.values[-1] > LOST + length - 0.1:
            blind = log.time.values >= LOST
            away = (log.cog_position_estimate - log.cog_position).values[blind]
            off.append(1e3 * np.linalg.norm(away, axis=1).max())
            tilts.append(np.degrees(log.tilt.values[blind].max()))
    if not off:
        return f"- | - | - | 0 of {draws}"
    return f"{np.median(off):.1f} | {max(off):.1f} | {max(tilts):.1f} | {len(off)} of {draws}"


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=20)
    draws = parser.parse_args().draws
    warnings.simplefilter("ignore")
    cases: dict[str, dict[str, Any]] = {"as it ships": {}, "with the IMU": IMU}
    for controller in ("following", "drawing"):
        for name, more in cases.items():
            print(f"| `{controller}` {name} | {whole(controller, draws, more)} |", flush=True)
    for length in (0.1, 0.5, 2.0):
        for name, more in cases.items():
            print(f"| {length:g} s, {name} | {gap(length, draws, more)} |", flush=True)


if __name__ == "__main__":
    main()
