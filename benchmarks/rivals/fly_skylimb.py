"""The paper's flight with skylimb's two drivers, one and many at once; prints JSON as its neighbours do."""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from loop import prepare as prepare_python
from native import prepare as prepare_native
from native import with_seed

from skylimb.flight.drivers.native import fly_native, unavailable
from skylimb.flight.drivers.world import world

EXPERIMENT, CONTROLLER = "paper", "hybrid"


def least(repeats: int, work: Callable[[], object]) -> float:
    """Wall seconds of the fastest of some runs."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    """Measure."""
    options = json.loads(sys.argv[1])
    repeats, count = options["repeats"], options["batches"][-1]
    bench, _ = prepare_python(EXPERIMENT, CONTROLLER)
    flight = bench.ticks * bench.takeoff.period
    rate = round(1.0 / bench.takeoff.period)
    single = least(repeats, lambda: bench.closed_loop(world(bench.takeoff)))
    rows = {"Python driver": {"one": {"simulated": flight, "wall": single}, "many": []}}
    if not unavailable():
        takeoff = prepare_native(EXPERIMENT, CONTROLLER)
        takeoffs = [with_seed(takeoff, seed) for seed in range(count)]
        for threads in (1, 2):
            made = least(repeats, lambda threads=threads: fly_native(takeoffs, threads))
            rows[f"native driver, {threads} thread{'s' * (threads > 1)}"] = {
                "one": {"simulated": flight, "wall": least(repeats, lambda: fly_native([takeoff]))},
                "many": [{"flights": count, "simulated": count * flight, "wall": made}],
            }
    print(json.dumps({"control_rate": rate, "rows": rows}))


if __name__ == "__main__":
    main()
