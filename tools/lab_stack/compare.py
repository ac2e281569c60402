"""Our board against the lab's own, compiled: thrusts of random cases.

    python tools/lab_stack/compare.py BOARD [--cases 10000] [--seed 1] [--gimbal-dof 0] [--write FILE]

BOARD is a program of your own: `board.cpp` beside this file, around the lab's attitude controller.
It exits with 1 where a thrust differs by more than 1e-3 N, or the angle of a rotor that the board turns by
1e-3 rad. A ROS master is started for the board (Debian's
`python3-rosmaster`), as its controller announces topics that nobody reads here. `--write` keeps the answers
of the lab's board: of seed 3 they are tests/apps/ros/board_GIMBAL_DOF.json.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "helpers"))
from board_case import BoardCase

PORT, AGREED = 11977, 1e-3


def compiled(board: Path, cases: list[BoardCase]) -> np.ndarray:
    """What the lab's board answers, a row for each case."""
    environment = {**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{PORT}", "ROS_IP": "127.0.0.1"}
    command, quiet = ["rosmaster", "--core", "-p", str(PORT)], subprocess.DEVNULL
    master = subprocess.Popen(command, env=environment, stdout=quiet, stderr=quiet)
    try:
        time.sleep(2.0)
        text = "\n".join([str(len(cases)), *(case.line() for case in cases)])
        answer = subprocess.run(
            [board, str(cases[0].gimbal_dof)],
            input=text,
            capture_output=True,
            text=True,
            env=environment,
            timeout=300,
            check=True,
        )
    finally:
        master.terminate()
        master.wait()
    rows = [line.split() for line in answer.stdout.splitlines()]
    width = 1 + cases[0].rotors * (1 + cases[0].gimbal_dof)
    return np.array([[float(word) for word in row] for row in rows if len(row) == width])


def main() -> int:
    """The comparison; see the top of the file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("board", type=Path)
    parser.add_argument("--cases", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--gimbal-dof", type=int, choices=(0, 1, 2), default=0)
    parser.add_argument("--write", type=Path)
    asked = parser.parse_args()
    rng = np.random.default_rng(asked.seed)
    cases = [BoardCase(rng, asked.gimbal_dof) for _ in range(asked.cases)]
    theirs, ours = compiled(asked.board, cases), np.array([case.ours() for case in cases])
    # The board computes in single precision: of thrusts above 100 N a hundred-thousandth counts.
    scale = np.maximum(1.0, 0.01 * np.abs(theirs).max(axis=1, keepdims=True))
    off = (np.abs(theirs - ours) / scale)[:, :-1].max(axis=1)
    worst = int(off.argmax())
    print(f"{len(cases)} cases, {sum(len(case.gains) == 1 for case in cases)} with gains of torques")
    print(f"largest difference {off[worst]:.1e} N or rad, of thrusts {np.round(theirs[worst, :-1], 3)}")
    print(f"lands by force: {int(theirs[:, -1].sum())}, ours {int(ours[:, -1].sum())}")
    if asked.write is not None:
        asked.write.write_text(json.dumps({"seed": asked.seed, "board": theirs.tolist()}), encoding="utf-8")
    return int((off > AGREED).any() or (theirs[:, -1] != ours[:, -1]).any())


if __name__ == "__main__":
    sys.exit(main())
