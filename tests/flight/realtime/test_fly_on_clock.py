"""A flight on the wall clock is that of `skylimb.run`; where the machine is too slow it is broken off."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.analysis.report.controller_replay import differences
from skylimb.apps.cli.main import main
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.realtime import timing
from skylimb.flight.realtime.fly_on_clock import fly_on_clock
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.timing import bare_timing


class FakeTime:
    """A clock that stands still but for sleeping, and for work where a tick is to be slow."""

    def __init__(self, slow: tuple[int, int] = (0, 0), work: float = 0.0) -> None:
        self.time, self.slow, self.work, self.ticks = 0, slow, round(work * 1e9), 0

    def pacer(self, period: float) -> Pacer:
        outer = self

        class Worked(Pacer):
            def wait(self, k: int) -> float:
                if outer.slow[0] <= k < outer.slow[1]:
                    outer.time += outer.work
                return super().wait(k)

        return Worked(period, lambda: self.time, self.sleep, spin=0.0)

    def sleep(self, seconds: float) -> None:
        self.time += round(seconds * 1e9)


@pytest.mark.parametrize("controller", ["hybrid", "following"])
def test_in_time_it_is_the_flight_of_run(controller: str) -> None:
    flown = fly_on_clock("paper", controller, set=HOLD, pacer=FakeTime().pacer)
    run = skylimb.run("paper", controller, set={**HOLD, "supervisor.on": False})
    assert flown.run.status == "OK", flown.run.cause
    assert flown.run.log.sizes == {**run.log.sizes}
    for name in run.log.data_vars:
        np.testing.assert_allclose(flown.run.log[name], run.log[name], atol=1e-9, err_msg=str(name))
    assert flown.timing.overruns == 0
    assert flown.faults == {}
    assert not flown.run.log.retreating.any()
    assert flown.run.metrics.keys() == run.metrics.keys()


def test_a_slow_stretch_is_held_and_made_good() -> None:
    flown = fly_on_clock("paper", "hybrid", set=HOLD, pacer=FakeTime((60, 66), 0.009).pacer)
    held = flown.run.log.tick_held.values
    where = np.flatnonzero(held)
    # Tick 60 is 4 ms late and flies; those after it are missed until the time is made good.
    assert where.tolist() == list(range(61, 69))
    np.testing.assert_array_equal(
        flown.run.log.thrusts_command.values[where], flown.run.log.thrusts_command.values[where - 1]
    )
    assert flown.run.status == "OK", flown.run.cause
    assert flown.timing.overruns >= held.sum()
    assert flown.faults == {"missed tick": int(held.sum())}
    replayed = skylimb.replay(flown.run)
    found = [one for one in differences(flown.run, replayed) if not one.same]
    assert found == []


def test_a_machine_that_is_too_slow_breaks_the_flight_off() -> None:
    flown = fly_on_clock(
        "paper", "hybrid", set=HOLD, limits=Limits(overruns=20), pacer=FakeTime((100, 130), 0.006).pacer
    )
    log = flown.run.log
    assert log.retreating.values[-1] == 1.0
    first = int(np.argmax(log.retreating.values > 0.0))
    # Each slow tick falls 1 ms behind: from the fifth on they are missed, and 20 in a row are too many.
    assert first == 125
    away = log.root_position.values[:, 0]
    assert away[-1] < away[first] - 0.1
    assert log.contact_force_normal.values[first + 200 :].max(initial=0.0) == 0.0


@pytest.fixture
def quick_timer(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command measures the machine's own timer with a tenth of its ticks, which take two seconds."""
    monkeypatch.setattr(timing, "bare_timing", lambda period, count: bare_timing(period, count // 10))


@pytest.mark.usefixtures("no_figures", "quick_timer")
def test_the_command_says_how_it_went(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = FakeTime((60, 66), 0.009)  # whatever else this machine has to do
    on_it = functools.partial(fly_on_clock, pacer=clock.pacer)
    monkeypatch.setattr("skylimb.flight.realtime.fly_on_clock.fly_on_clock", on_it)
    words = [f"{key}={value}" for key, value in HOLD.items()]
    assert main(["fly", "paper", "--realtime", "--set", *words, "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "jitter of a bare timer" in said
    assert re.search(r"\d+ of \d+ ticks overran their 5 ms, 8 were held", said)
    assert "note: missed tick: 8 times" in said
    told = json.loads((tmp_path / "out" / "timing.json").read_text(encoding="utf-8"))
    assert set(told["seconds"]) == {"jitter", "latency"}
    assert (tmp_path / "out" / "log.nc").is_file()
    assert main(["fly", "paper"]) == 2
    assert "fly needs one of --realtime" in capsys.readouterr().err


@pytest.mark.usefixtures("no_figures", "quick_timer")
def test_overruns_of_the_command_line_leave_the_other_limits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    on_it = functools.partial(fly_on_clock, pacer=FakeTime().pacer)
    monkeypatch.setattr("skylimb.flight.realtime.fly_on_clock.fly_on_clock", on_it)
    words = [*(f"{key}={value}" for key, value in HOLD.items()), "supervisor.upset_at=0.0001"]
    out = tmp_path / "out"
    given = ["fly", "paper", "--realtime", "--overruns", "50", "--set", *words, "--out", str(out)]
    assert main(given) == 1  # every pose leans by more than that
    assert "NORMAL -> CUT: tipped over" in capsys.readouterr().err
    config = (out / "config.toml").read_text(encoding="utf-8")
    assert "overruns = 50" in config
    assert "upset_at = 0.0001" in config
