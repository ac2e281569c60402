"""`run.plot()` and `compare(...).plot()` draw a figure of the report, or a signal."""

import pytest
import xarray as xr
from matplotlib.figure import Figure

from skylimb.analysis.notebook_run import Run, Runs
from skylimb.base.errors import UnknownNameError


def run(name: str) -> Run:
    log = xr.Dataset(
        {
            "push": (("time", "axis"), [[1.0, 2.0, 3.0]] * 4, {"units": "N"}),
            "tilt": ("time", [1.0] * 4, {"units": "rad"}),
        },
        {"time": [0.0, 1.0, 2.0, 3.0], "axis": ["x", "y", "z"]},
    )
    return Run(name, name, log)


def test_a_signal_is_drawn_over_time() -> None:
    figure = run("pid").plot("push")
    assert isinstance(figure, Figure)
    (axes,) = figure.axes
    assert axes.get_ylabel() == "push (N)"
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["x", "y", "z"]
    assert len(axes.lines) == 3


def test_runs_are_drawn_below_each_other() -> None:
    runs = Runs({"pid": run("pid"), "hybrid": run("hybrid")})
    assert len(runs.plot("tilt").axes) == 2
    with pytest.raises(UnknownNameError, match=r"unknown figure or signal 'tlt'; did you mean 'tilt'"):
        runs.plot("tlt")
