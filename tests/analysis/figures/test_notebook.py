"""How a run shows itself in a notebook."""

import numpy as np
import xarray as xr

from skylimb.analysis.notebook_run import Run


def made(status="OK", **metrics) -> Run:
    time = np.linspace(0.0, 1.0, 11)
    log = xr.Dataset(
        {
            "contact_force_normal": ("time", time, {"units": "N"}),
            "cog_position": (("time", "axis"), np.zeros((11, 3)), {"units": "m"}),
        },
        coords={"time": time, "axis": ["x", "y", "z"]},
        attrs={"experiment": "paper", "status": status, "cause": "it <fell>", "notes": '["a & b"]'},
    )
    return Run("mine", "mine", log, metrics)


def test_verdict_scores_plot_and_notes_are_shown() -> None:
    text = made(done=True, tilt_max=0.12351, missed=[])._repr_html_()
    assert "paper: mine" in text
    assert "done as commanded" in text
    assert "<td>tilt_max</td><td>0.1235</td>" in text
    assert 'src="data:image/png;base64,iVBOR' in text
    assert "a &amp; b" in text
    assert "http" not in text


def test_a_lost_flight_and_a_missed_one_say_so() -> None:
    lost = made("FAILED", tilt_max=None)._repr_html_()
    assert "FAILED: it &lt;fell&gt;" in lost
    assert "<details>" not in lost
    missed = made(done=False, missed=["the pen is off"])._repr_html_()
    assert "not done as commanded: the pen is off" in missed


def test_a_log_without_its_signals_shows_no_plot() -> None:
    assert "<img" not in Run("a", "a", xr.Dataset(), {"n": 1})._repr_html_()
