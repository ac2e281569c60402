"""The loop's benchmark compares like with like: its replay ends where the flight did, to the bit."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


def test_a_replay_of_recorded_controls_and_forces_ends_in_the_same_bits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    loop = import_module("loop")
    bench, _ = loop.prepare("free_flight", "hybrid")
    controls, end = loop.record_controls(bench)
    assert (
        np.abs(controls[:, bench.takeoff.plant.model.nu :]).max() > 0.0
    )  # of rotors on their bodies: without them it would end elsewhere
    data = bench.takeoff.data()
    bench.replay(data, controls)
    np.testing.assert_array_equal(np.concatenate([data.qpos, data.qvel]), end)
