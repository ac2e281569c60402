"""Ten thousand truncated and mutated URDFs: each loads, or is refused in a line, within two seconds.

    python benchmarks/spoilt_urdfs.py [--count 10000] [--first 0] [--seed 1]

The descriptions are those of the robots that ship. A mutation cuts the file off, puts something odd in the
place of a number or a name, or takes out, doubles or swaps a tag; one to three a file. Files are checked in
processes of their own, so that a crash of the engine is seen as one. What is slow, raises anything but a
skylimb error, says more than a line or leaves a file is listed, and the exit code is 1. `--first` leaves the
files before it out, so that ten thousand can be checked in parts.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import re
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import numpy as np

from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.base.errors import SkylimbError
from skylimb.robots import SHIPPED

SLOWEST = 2.0  # s
WORKERS = 2
ODD = ("nan", "inf", "-1", "0", "1e300", "-1e-300", "", "x", "1 2", "\N{DEGREE SIGN}", "0x10", "9" * 400)
VALUE = re.compile(r'(?<=")[^"<>]*(?=")')
TAG = re.compile(r"<[^>]+>")


def spoilt(text: str, rng: np.random.Generator) -> str:
    """One to three mutations of a URDF."""
    for _ in range(rng.integers(1, 4)):
        kind = rng.integers(6)
        pattern = VALUE if kind in (1, 2) else TAG
        spans = [match.span() for match in pattern.finditer(text)]
        if kind == 0 or len(spans) < 2:
            text = text[: rng.integers(len(text) + 1)]
            continue
        (begin, end), (other, last) = (spans[k] for k in rng.integers(len(spans), size=2))
        word, elsewhere = text[begin:end], text[other:last]
        new = {1: str(rng.choice(ODD)), 2: elsewhere, 3: "", 4: word + word, 5: elsewhere}[int(kind)]
        text = text[:begin] + new + text[end:]
    return text


def outcome(content: str) -> tuple[str, float]:
    """What checking a file comes to, in a word or two, and how long it takes, s of processor time."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "spoilt.urdf"
        path.write_text(content, encoding="utf-8")
        begin = time.process_time()
        try:
            hovers = check_robot_file(path).can_hover
            said = "can hover" if hovers else "loads, cannot hover"
        except SkylimbError as error:
            said = "refused" if "\n" not in str(error) and 0 < len(str(error)) < 1500 else "FAULT: not a line"
        except Exception as error:  # what this benchmark looks for
            said = f"FAULT: {type(error).__name__}: {error}"[:200]
        if [file.name for file in Path(folder).iterdir()] != ["spoilt.urdf"]:
            said = "FAULT: it wrote something"
        spent = time.process_time() - begin
        return (said if spent < SLOWEST else "FAULT: slow"), spent


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    texts = [path.read_text(encoding="utf-8") for path in sorted(SHIPPED.glob("*/*.urdf"))]
    rng = np.random.default_rng(given.seed)
    files = [spoilt(texts[k % len(texts)], rng) for k in range(given.count)]
    seen: Counter[str] = Counter()
    times: list[float] = []
    with concurrent.futures.ProcessPoolExecutor(WORKERS) as pool:
        futures = [pool.submit(outcome, content) for content in files[given.first :]]
        for k, future in enumerate(futures, start=given.first):
            try:
                said, spent = future.result()
            except BrokenProcessPool:
                said, spent = "FAULT: the engine crashed", 0.0
            seen[said] += 1
            times.append(spent)
            if said.startswith("FAULT"):
                print(f"file {k}: {said}", flush=True)
    for said, count in seen.most_common():
        print(f"{count:6d}  {said}")
    print(
        f"s a file: median {np.median(times):.2f}, 99 % {np.quantile(times, 0.99):.2f}, most {max(times):.2f}"
    )
    return 1 if any(said.startswith("FAULT") for said in seen) else 0


if __name__ == "__main__":
    sys.exit(main())
