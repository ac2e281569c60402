"""Reading back what a run or a comparison left, and what produced it."""

import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.recording import Run, load_runs
from skylimb.analysis.recording.versions import versions
from skylimb.base.errors import OutputError


def make(name):
    log = xr.Dataset(
        {"tilt": ("time", np.zeros(4))}, coords={"time": np.arange(4.0)}, attrs={"controller": name}
    )
    return Run(name, name, log, {})


def test_one_run(tmp_path):
    make("hybrid").save(tmp_path / "log.nc")
    assert list(load_runs(tmp_path)) == ["hybrid"]


def test_a_comparison_keeps_the_order_of_its_table(tmp_path):
    for name in ("pid", "hybrid", "admittance"):
        make(name).save(tmp_path / name / "log.nc")
    assert list(load_runs(tmp_path)) == ["admittance", "hybrid", "pid"]
    (tmp_path / "metrics.csv").write_text('run,status\npid,OK\nhybrid,"FAILED, lost"\n')
    assert list(load_runs(tmp_path)) == ["pid", "hybrid", "admittance"]


def test_folders_without_runs(tmp_path):
    with pytest.raises(OutputError, match="holds no run"):
        load_runs(tmp_path)
    with pytest.raises(OutputError, match="does not exist"):
        load_runs(tmp_path / "nowhere")
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match="is a file, not a folder"):
        load_runs(tmp_path / "file")


def test_versions_name_what_computes_and_nothing_private(tmp_path):
    found = versions()
    assert {"python", "platform", "skylimb", "mujoco", "casadi", "numpy"} <= set(found)
    assert found["numpy"] == np.__version__
    assert not any("/" in value for value in found.values())
