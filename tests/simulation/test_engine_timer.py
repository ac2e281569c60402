import ctypes

import mujoco
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
