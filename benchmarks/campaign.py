"""Time `skylimb campaign` over the paper's flight: flights a minute, over worker processes, and their memory.

    python benchmarks/campaign.py                (about five minutes; --flights 100 for a first look)

The command is run as a user runs it. The rate is that of the store's growth between the first and the last
tenth, so that the workers' start is not in it; the time of the whole is. One worker flies before and after
two do, since a machine's speed drifts.
"""

from __future__ import annotations

import argparse
import sqlite3
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from skylimb.studies.campaign.folder import STORE_FILE

MINUTES_WANTED, FLIGHTS_WANTED = 2.5, 1000
SCALING_WANTED = 1.85
MEMORY_WANTED = 400.0  # MB

SPEC = """experiment = "paper"
controllers = ["pid", "impedance", "admittance", "hybrid"]
draws = {draws}
logs = "none"
"""
"""The paper's own flight under its four controllers, with other noise in every draw."""


@dataclass(frozen=True)
class Flown:
    """A campaign.

    Attributes:
        flights: how many.
        seconds: of the whole command.
        rate: flights a second while all workers fly.
        memory: most that any worker has had, MB; 0 where the system does not tell.
    """

    flights: int
    seconds: float
    rate: float
    memory: float


@dataclass(frozen=True)
class Figures:
    """What was measured.

    Attributes:
        one: with one worker.
        two: with two.
    """

    one: Flown
    two: Flown

    @property
    def scaling(self) -> float:
        """Rate of two workers over that of one."""
        return self.two.rate / self.one.rate


def fly(flights: int, workers: int) -> Flown:
    """Fly a campaign as a command, and watch it."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        (folder / "paper.toml").write_text(SPEC.format(draws=-(-flights // 4)), encoding="utf-8")
        command = [sys.executable, "-m", "skylimb", "campaign", "paper.toml", "--out", "out"]
        start = time.perf_counter()
        process = subprocess.Popen(
            [*command, "--workers", str(workers)],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        grown, most = [(0.0, 0)], 0.0
        while process.poll() is None:
            time.sleep(0.25)
            done = _kept(folder / "out" / STORE_FILE)
            if done > grown[-1][1]:
                grown.append((time.perf_counter() - start, done))
                most = max(most, _memory(process.pid))
        seconds = time.perf_counter() - start
        said = process.communicate()[0]
        if process.returncode:
            raise SystemExit(f"the campaign failed: {said}")
    total = grown[-1][1]
    steady = [(at, done) for at, done in grown if 0.1 * total <= done <= 0.9 * total]
    if len(steady) < 2:
        raise SystemExit(f"{flights} flights are too few to tell a rate")
    rate = (steady[-1][1] - steady[0][1]) / (steady[-1][0] - steady[0][0])
    return Flown(4 * -(-flights // 4), seconds, rate, most)


def measure(flights: int) -> Figures:
    """One worker, two, and one again."""
    share = max(flights // 6, 24)
    before, two, after = fly(share, 1), fly(flights, 2), fly(share, 1)
    mean = 2.0 / (1.0 / before.rate + 1.0 / after.rate)
    one = Flown(2 * share, before.seconds + after.seconds, mean, max(before.memory, after.memory))
    return Figures(one, two)


def _kept(store: Path) -> int:
    """Flights in a campaign's store; 0 before it is there and after the end."""
    try:
        with closing(sqlite3.connect(f"{store.as_uri()}?mode=rw", uri=True)) as database:
            return database.execute("SELECT count(row) FROM flights").fetchone()[0]
    except sqlite3.OperationalError:
        return 0


def _memory(coordinator: int) -> float:
    """Most memory that a worker process of a coordinator has had, MB; from /proc, so on Linux alone."""
    most = 0
    for listing in Path(f"/proc/{coordinator}/task").glob("*/children"):
        try:
            children = listing.read_text().split()
        except OSError:
            continue
        for child in children:
            try:
                if b"spawn_main" not in Path(f"/proc/{child}/cmdline").read_bytes():
                    continue
                status = Path(f"/proc/{child}/status").read_text()
            except OSError:
                continue
            peak = [line.split()[1] for line in status.splitlines() if line.startswith("VmHWM")]
            most = max(most, *map(int, peak), 0)
    return most / 2**10


def main() -> int:
    """Print what was measured; 1 when it falls short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--flights", type=int, default=FLIGHTS_WANTED)
    options = parser.parse_args()
    found = measure(options.flights)
    minutes = found.two.seconds / 60.0 * FLIGHTS_WANTED / found.two.flights
    Console(highlight=False).print(
        f"{found.two.flights} flights with two workers: {found.two.seconds:.0f} s, "
        f"{60 * found.two.rate:.0f} a minute while all fly ({FLIGHTS_WANTED}: {minutes:.2f} min, wanted at "
        f"most {MINUTES_WANTED})\none worker: {60 * found.one.rate:.0f} a minute; two over one "
        f"{found.scaling:.2f} (wanted at least {SCALING_WANTED})\n"
        f"memory of a worker: {found.two.memory:.0f} MB (wanted at most {MEMORY_WANTED:.0f})"
    )
    good = (
        minutes <= MINUTES_WANTED
        and found.scaling >= SCALING_WANTED
        and max(found.one.memory, found.two.memory) <= MEMORY_WANTED
    )
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
