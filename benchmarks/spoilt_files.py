"""Ten thousand truncated and mutated descriptions: each loads, or is refused in a line, within ten seconds.

    python benchmarks/spoilt_files.py [--count 10000] [--first 0] [--seed 1] [--kinds urdf mjcf sdf]

In turn a URDF, an MJCF and an SDF are spoilt. The URDFs are those of the robots that ship and load without
their flight file, some in the laboratory's style, and multirotors with an arm, a stick and arms that turn,
one of two rotors; the MJCFs are scenes of all robots that ship, and of one with an arm, as the engine writes
them down; the SDF is a quadrotor with motor plugins and an arm. A mutation cuts the file off, puts something
odd in the place of a number or a name, or takes out, doubles or swaps a tag; one to three a file. Files are
checked, and their report is written, in processes of their own, so that a crash of the engine is seen as
one, and a file that takes a minute of processor time as well. What is slow, raises anything but a skylimb
error, says more than a line or leaves a file is listed, and the exit code is 1.
`--first` leaves the files before it out, so that ten thousand can be checked in parts;
`--keep FOLDER` keeps what is at fault.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import re
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "helpers"))

import numpy as np

from armed_robots import multirotor_with_arm
from lab_style import lab_urdf
from sdf_quad import whole_sdf
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.report import report_text
from skylimb.base.errors import SkylimbError
from skylimb.robots import SHIPPED, list_robots, load_robot
from skylimb.simulation.scene import scene_spec
from skylimb.simulation.surfaces import Board

SLOWEST, STUCK = 10.0, 60
"""What a file may take, and what ends its process, s of processor time."""
WORKERS, TOGETHER = 2, 200
ODD = ("nan", "inf", "-1", "0", "1e300", "-1e-300", "", "x", "1 2", "\N{DEGREE SIGN}", "0x10", "9" * 400)
VALUE = re.compile(r'(?<=")[^"<>]*(?=")|(?<=>)[^<>\n]+(?=<)')
TAG = re.compile(r"<[^>]+>")
KINDS = ("urdf", "mjcf", "sdf")
ENDINGS = {"urdf": "urdf", "mjcf": "xml", "sdf": "sdf"}


def whole(folder: Path) -> dict[str, list[str]]:
    """The descriptions before they are spoilt, by kind."""
    arm = multirotor_with_arm(folder / "arm.urdf")
    files = [*sorted(SHIPPED.glob("*/*.urdf")), arm]
    files.append(multirotor_with_arm(folder / "stick.urdf", joints=(), stick=0.45, rotors=6, cant=0.3))
    files.append(multirotor_with_arm(folder / "turning.urdf", joints=(), stick=0.45, turning=1.5))
    few = {"rotors": 2, "layers": (0.15,), "mount": "0.1 0 0", "mass": 0.8}
    files.append(multirotor_with_arm(folder / "few.urdf", joints=(), stick=0.45, turning=1.5, **few))
    for gimbal in ("fixed", "revolute", "continuous"):
        files.append(folder / f"{gimbal}.urdf")
        files[-1].write_text(lab_urdf(gimbal=gimbal), encoding="utf-8")
    urdfs = [file.read_text(encoding="utf-8") for file in files]
    urdfs = [text for text in urdfs if outcome("urdf", text)[0] != "refused"]
    scenes = []
    for description in (
        *(load_robot(name).description for name in list_robots()),
        check_robot_file(arm).description,
    ):
        spec = scene_spec(description, Board(), 1e-3, 5)[0]
        spec.compile()
        scenes.append(spec.to_xml())
    return {
        "urdf": urdfs,
        "mjcf": scenes,
        "sdf": [whole_sdf()],
    }


def spoilt(text: str, rng: np.random.Generator) -> str:
    """One to three mutations of a description."""
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


def outcome(kind: str, content: str) -> tuple[str, float]:
    """What checking a file comes to, in a word or two, and how long it takes, s of processor time."""
    signal.setitimer(signal.ITIMER_PROF, STUCK)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"spoilt.{ENDINGS[kind]}"
        path.write_text(content, encoding="utf-8")
        begin = time.process_time()
        try:
            report = check_robot_file(path)
            report_text(report)
            said = "can hover" if report.can_hover else "loads, cannot hover"
        except SkylimbError as error:
            said = "refused" if "\n" not in str(error) and 0 < len(str(error)) < 1500 else "FAULT: not a line"
        except Exception as error:  # what this benchmark looks for
            said = f"FAULT: {type(error).__name__}: {error}"[:200]
        spent = time.process_time() - begin
        if [file.name for file in Path(folder).iterdir()] != [path.name]:
            said = "FAULT: it wrote something"
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    return (said if said.startswith("FAULT") or spent < SLOWEST else f"FAULT: slow, {spent:.1f} s"), spent


def outcomes(files: list[tuple[str, str]]) -> Iterator[tuple[str, float]]:
    """What each file comes to; those that a crash took along are checked again, each alone."""
    for first in range(0, len(files), TOGETHER):
        batch = files[first : first + TOGETHER]
        with concurrent.futures.ProcessPoolExecutor(WORKERS) as pool:
            futures = [pool.submit(outcome, *file) for file in batch]
            concurrent.futures.wait(futures)
        for file, future in zip(batch, futures, strict=True):
            yield alone(file) if isinstance(future.exception(), BrokenProcessPool) else future.result()


def alone(file: tuple[str, str]) -> tuple[str, float]:
    """What a file comes to in a process that checks no other."""
    with concurrent.futures.ProcessPoolExecutor(1) as pool:
        try:
            return pool.submit(outcome, *file).result()
        except BrokenProcessPool:
            return f"FAULT: it crashed, or took {STUCK} s", 0.0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--keep", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        texts = whole(Path(folder))
    rng = np.random.default_rng(given.seed)
    files = []
    for k in range(given.count):
        kind, turn = given.kinds[k % len(given.kinds)], k // len(given.kinds)
        files.append((kind, spoilt(texts[kind][turn % len(texts[kind])], rng)))
    seen: Counter[tuple[str, str]] = Counter()
    times: list[float] = []
    for k, (said, spent) in enumerate(outcomes(files[given.first :]), start=given.first):
        kind, content = files[k]
        seen[kind, said.partition(":")[0]] += 1
        times.append(spent)
        if said.startswith("FAULT"):
            print(f"file {k}: {kind}: {said}", flush=True)
            if given.keep is not None:
                given.keep.mkdir(parents=True, exist_ok=True)
                (given.keep / f"{k}.{ENDINGS[kind]}").write_text(content, encoding="utf-8")
    for (kind, said), count in sorted(seen.items()):
        print(f"{count:6d}  {kind}: {said}")
    print(
        f"s a file: median {np.median(times):.2f}, 99 % {np.quantile(times, 0.99):.2f}, most {max(times):.2f}"
    )
    return 1 if any(said == "FAULT" for _, said in seen) else 0


if __name__ == "__main__":
    sys.exit(main())
