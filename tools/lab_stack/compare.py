"""Our board against the lab's own, compiled: thrusts of random cases.

    tools/lab_stack/build.sh SOURCES OUT
    python tools/lab_stack/compare.py OUT/board [--cases 10000] [--seed 1] [--write FILE]

It exits with 1 where a thrust differs by more than 1e-3 N. A ROS master is started for the board (Debian's
`python3-rosmaster`), as its controller announces topics that nobody reads here. `--write` keeps the answers
of the lab's board: with 60 cases of seed 3 they are tests/apps/ros1/board.json.
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
    """What the lab's board answers, (cases, 5)."""
    environment = {**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{PORT}", "ROS_IP": "127.0.0.1"}
    command, quiet = ["rosmaster", "--core", "-p", str(PORT)], subprocess.DEVNULL
    master = subprocess.Popen(command, env=environment, stdout=quiet, stderr=quiet)
    try:
        time.sleep(2.0)
        text = "\n".join([str(len(cases)), *(case.line() for case in cases)])
        answer = subprocess.run(
            [board], input=text, capture_output=True, text=True, env=environment, timeout=300, check=True
        )
    finally:
        master.terminate()
        master.wait()
    rows = [line.split() for line in answer.stdout.splitlines()]
    return np.array([[float(word) for word in row] for row in rows if len(row) == 5])


def main() -> int:
    """The comparison; see the top of the file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("board", type=Path)
    parser.add_argument("--cases", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", type=Path)
    asked = parser.parse_args()
    rng = np.random.default_rng(asked.seed)
    cases = [BoardCase(rng) for _ in range(asked.cases)]
    theirs, ours = compiled(asked.board, cases), np.array([case.ours() for case in cases])
    off = np.abs(theirs - ours)[:, :4].max(axis=1)
    worst = int(off.argmax())
    print(f"{len(cases)} cases, {sum(len(case.gains) == 1 for case in cases)} with gains of torques")
    print(f"largest difference {off[worst]:.1e} N, of thrusts {np.round(theirs[worst, :4], 3)}")
    print(f"lands by force: {int(theirs[:, 4].sum())}, ours {int(ours[:, 4].sum())}")
    if asked.write is not None:
        asked.write.write_text(json.dumps({"seed": asked.seed, "board": theirs.tolist()}), encoding="utf-8")
    return int((off > AGREED).any() or (theirs[:, 4] != ours[:, 4]).any())


if __name__ == "__main__":
    sys.exit(main())
