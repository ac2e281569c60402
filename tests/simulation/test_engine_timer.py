import ctypes
from pathlib import Path

import mujoco
import numpy as np
import pytest

from skylimb.simulation.compiling import engine_library
from skylimb.simulation.engine_timer import without_timer

MODEL = '<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'


def clock() -> int | None:
    return ctypes.c_void_p.in_dll(ctypes.CDLL(str(engine_library())), "mjcb_time").value


def timed() -> float:
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 10)
    return float(data.timer[mujoco.mjtTimer.mjTIMER_STEP].duration)


def test_the_engine_has_no_clock_within_and_has_it_back_after() -> None:
    before = clock()
    if before is None:
        pytest.skip("these bindings hand the engine no clock")
    with without_timer():
        with without_timer():
            assert timed() == 0.0
        assert clock() is None
    assert clock() == before
    assert timed() > 0.0


def test_the_engine_writes_nothing_within(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    before = mujoco.get_mju_user_warning()
    with without_timer():
        data.qvel[:] = np.nan
        mujoco.mj_step(model, data)
    assert data.warning.number.any()
    assert list(tmp_path.iterdir()) == []
    assert mujoco.get_mju_user_warning() is before
