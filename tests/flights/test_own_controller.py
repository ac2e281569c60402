"""A user's own controller in flight: compiled, with its gains and its signals."""

from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.errors import UnknownNameError
from skylimb.flights.drivers.native import fly_native, native_available
from skylimb.flights.flying import fly_here
from skylimb.flights.public import take_off

EXAMPLE = str(Path(__file__).parents[2] / "examples" / "own_controller.py")

SHORT = {
    "phases.hover": 0.2,
    "phases.tare": 0.2,
    "phases.settle": 0.1,
    "phases.hover_end": 0.1,
    "approach.speed": 0.2,
    "approach.retreat_speed": 0.3,
    "trajectory.shape": "hold",
    "trajectory.duration": 0.2,
}


def test_both_compiled_drivers_give_the_same_bits() -> None:
    if not native_available():
        pytest.skip("no compiler here")
    (takeoff,) = take_off("paper", (EXAMPLE,), set=SHORT)
    assert takeoff.traceable
    here, native = fly_here(takeoff), fly_native([takeoff])[0]
    assert (here.cause, here.ticks) == (native.cause, native.ticks) == ("", len(takeoff.times))
    np.testing.assert_array_equal(here.signals[: here.ticks], native.signals[: native.ticks])


def test_a_run_has_its_gains_and_its_signals_with_units() -> None:
    run = skylimb.run("paper", EXAMPLE, set={**SHORT, "controller.spin": [12.0, 12.0, 6.0]})
    assert run.status == "OK", run.cause
    signal = run.log.integral_acceleration
    assert signal.attrs == {
        "units": "m/s^2",
        "frame": "W",
        "long_name": "what the integral adds",
        "kind": "command",
    }
    assert signal.dims == ("time", "axis")
    assert run.config_units["controller.spin"] == "1/s"
    assert "spin = [\n    12.0,\n    12.0,\n    6.0,\n]" in run.config


def test_a_signal_that_is_declared_is_recorded(tmp_path: Path) -> None:
    text = (
        Path(EXAMPLE)
        .read_text(encoding="utf-8")
        .replace('        "integral_acceleration": sky', '        "integral": sky')
    )
    (tmp_path / "own.py").write_text(text, encoding="utf-8")
    with pytest.raises(UnknownNameError, match=r"'integral'; did you mean 'integral_acceleration'"):
        skylimb.run("paper", str(tmp_path / "own.py"), set=SHORT)
    (tmp_path / "own.py").write_text(text.replace("SIGNALS = {", "SIGNALS = 3 or {"), encoding="utf-8")
    with pytest.raises(skylimb.SkylimbError, match="SIGNALS should be a table"):
        skylimb.run("paper", str(tmp_path / "own.py"), set=SHORT)
