"""A run comes back from its file bit for bit, and whatever is not a run is refused clearly."""

import copy
import json
import pickle
import sys

import h5py
import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.figures import style
from skylimb.analysis.notebook_run import Runs
from skylimb.analysis.recording import FORMAT_VERSION, Run
from skylimb.analysis.scores.read_only import read_only
from skylimb.base.errors import OutputError, UnknownNameError


@pytest.fixture
def run():
    rng = np.random.default_rng(1)
    time = 0.005 * np.arange(400)
    log = xr.Dataset(
        {
            "cog_position": (
                ("time", "axis"),
                rng.standard_normal((400, 3)),
                {"units": "m", "frame": "W", "long_name": "position of the CoG", "kind": "truth"},
            ),
            "contact": (("time",), rng.integers(0, 2, 400).astype(np.int8), {"units": "1", "kind": "truth"}),
            "phase": (
                ("time",),
                np.zeros(400, np.int8),
                {"flag_values": [0, 1], "flag_meanings": "hover slide"},
            ),
            "odd": (("time",), np.where(time < 1, np.nan, np.inf), {"units": ""}),
        },
        coords={"time": ("time", time, {"units": "s"}), "axis": ["x", "y", "z"]},
        attrs={
            "controller": "hybrid",
            "status": "OK",
            "cause": "",
            "seed": 7,
            "config": "seed = 7\n",
            "versions": json.dumps({"python": "3.11"}),
            "scene": "<mujoco><!-- ° --></mujoco>\n" * 20_000,  # far beyond what a small attribute holds
            "format_version": FORMAT_VERSION,
        },
    )
    return Run("hybrid", "hybrid", log, {"status": "OK", "error_u_median": 0.1 + 0.2, "tilt_max": None})


def test_round_trip_is_exact(run, tmp_path):
    path = run.save(tmp_path / "log.nc")
    back = Run.load(path)
    xr.testing.assert_identical(back.log, run.log)
    for name, variable in run.log.variables.items():
        assert back.log[name].dtype == variable.dtype or variable.dtype.kind == "U"
    assert (back.name, back.controller, back.metrics) == (run.name, run.controller, dict(run.metrics))
    assert back.log.attrs["seed"] == 7
    assert isinstance(back.log.attrs["seed"], int)


def test_a_loaded_run_can_be_saved_again(run, tmp_path):
    again = Run.load(Run.load(run.save(tmp_path / "a.nc")).save(tmp_path / "b.nc"))
    xr.testing.assert_identical(again.log, run.log)


def test_a_number_that_is_not_there_is_named_with_the_nearest(run, tmp_path):
    told = (
        "unknown metric of run hybrid (OK) 'error_u_medain'; did you mean 'error_u_median'? (known: error_u_"
    )
    others = Run.load(run.save(tmp_path / "log.nc")), pickle.loads(pickle.dumps(run)), copy.deepcopy(run)
    for one in (run, *others, read_only(run), read_only(read_only(run))):
        with pytest.raises(KeyError) as error:
            one.metrics["error_u_medain"]
        assert isinstance(error.value, UnknownNameError)
        assert str(error.value).startswith(told)
        assert one.metrics.get("error_u_medain") is None
        assert one.metrics == run.metrics
    with pytest.raises(UnknownNameError, match="unknown metric of run hybrid"):
        run.metrics[3]
    with pytest.raises(UnknownNameError, match="unknown run 'hybird'; did you mean 'hybrid'"):
        Runs({"hybrid": run})["hybird"]
    with pytest.raises(TypeError, match="does not support item assignment"):
        read_only(run).metrics["new"] = 1.0


def test_the_file_is_compressed_netcdf4(run, tmp_path):
    log = run.log.assign(still=(("time", "axis"), np.zeros((400, 3))))
    small = Run("a", "a", run.log, {}).save(tmp_path / "a.nc").stat().st_size
    with_zeros = Run("b", "b", log, {}).save(tmp_path / "b.nc").stat().st_size
    assert with_zeros - small < 400 * 3 * 8  # less than the numbers that were added
    assert (tmp_path / "a.nc").read_bytes()[:8] == b"\x89HDF\r\n\x1a\n"


def test_every_kind_of_signal_comes_back(run, tmp_path):
    log = run.log.assign(
        touching=(("time",), run.log.contact.values > 0, {"units": ""}),
        word=(("axis",), np.array(["a", "b°", ""])),
        count=(("time",), np.arange(400)),
        single=((), 2.5),
        nothing=(("none", "axis"), np.zeros((0, 3))),
        beside=(("plain", "axis"), np.arange(6.0).reshape(2, 3)),
    ).assign_coords(place=("axis", [1.0, 2.0, 3.0]), middle=0.5)
    log.attrs |= {"contact_axis": [1.0, 0.0, 0.0], "sliding_axes": ["y", "z"], "tared": 1}
    back = Run.load(Run("a", "hybrid", log, {}).save(tmp_path / "log.nc"))
    xr.testing.assert_identical(back.log, log)
    assert back.log.touching.dtype == bool
    assert back.log["count"].dtype == np.int64


def test_what_no_record_can_hold_is_named(run, tmp_path):
    log = run.log.assign(turn=(("time",), np.full(400, 1j)))
    with pytest.raises(OutputError, match="variable 'turn' holds complex128; a record has numbers"):
        Run("a", "a", log, {}).save(tmp_path / "log.nc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of a file")
def test_a_full_disk_is_one_line_and_leaves_nothing(run, tmp_path):
    import resource

    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (5_000, old[1]))
        with pytest.raises(OutputError, match=r"^cannot write '.*log.nc': File too large$"):
            run.save(tmp_path / "log.nc")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)
    assert list(tmp_path.iterdir()) == []


def test_dimensions_are_those_of_netcdf(run, tmp_path):
    path = run.save(tmp_path / "log.nc")
    with h5py.File(path) as file:
        found = {name: item for name, item in file.items() if isinstance(item, h5py.Dataset)}
        assert found["time"].is_scale
        assert [found["cog_position"].dims[axis][0].name for axis in (0, 1)] == ["/time", "/axis"]
        assert found["phase"].dims[0][0] == found["time"]
        assert [found[name].attrs["_Netcdf4Dimid"] for name in ("time", "axis")] == [0, 1]


def test_xarray_opens_the_file_and_what_it_writes_is_read(run, tmp_path):
    log = run.log.assign(nothing=(("none", "axis"), np.zeros((0, 3)))).assign_coords(middle=0.5)
    path = Run("a", "hybrid", log, {}).save(tmp_path / "log.nc")
    opened = xr.load_dataset(path, engine="h5netcdf")
    xr.testing.assert_identical(opened.drop_attrs(), log.drop_attrs())
    assert opened.cog_position.attrs == log.cog_position.attrs
    opened.to_netcdf(tmp_path / "again.nc", engine="h5netcdf", encoding={"odd": {"scale_factor": 2.0}})
    xr.testing.assert_identical(Run.load(tmp_path / "again.nc").log.drop_attrs(), log.drop_attrs())


def test_attributes_as_c_writes_them(run, tmp_path):
    path = run.save(tmp_path / "log.nc")
    with h5py.File(path, "a") as file:
        file["odd"].attrs["units"] = np.bytes_("m/s")
        file["odd"].attrs["frame"] = h5py.Empty("S1")
        file["odd"].attrs["step"] = np.array([2], np.int8)
    assert Run.load(path).log.odd.attrs == {"units": "m/s", "frame": "", "step": 2}


def test_a_file_that_unpacks_to_too_much_is_refused(run, tmp_path):
    path = run.save(tmp_path / "log.nc")
    with h5py.File(path, "a") as file:
        file.create_dataset("vast", (10**6, 1000), "f8", compression="gzip")
    with pytest.raises(OutputError, match=r"log\.nc' .*: it says that it unpacks to 8 GB, more than 4 GB"):
        Run.load(path)


def test_a_folder_stands_for_its_log(run, tmp_path):
    run.save(tmp_path / "log.nc")
    assert Run.load(tmp_path).name == "hybrid"


def test_properties(run):
    assert (run.status, run.cause, run.failed) == ("OK", "", False)
    assert run.config == "seed = 7\n"
    assert run.versions == {"python": "3.11"}
    lost = Run("x", "x", run.log.assign_attrs(status="FAILED", cause="tilt"), {})
    assert (lost.status, lost.cause, lost.failed) == ("FAILED", "tilt", True)


def test_signal_by_name_and_the_nearest_for_a_slip(run):
    assert run.signal("cog_position").attrs["units"] == "m"
    with pytest.raises(
        UnknownNameError, match=r"unknown signal 'cog_positon'; did you mean 'cog_position'\?"
    ):
        run.signal("cog_positon")


def test_saving_does_not_overwrite(run, tmp_path):
    (tmp_path / "log.nc").write_text("mine")
    with pytest.raises(OutputError, match="exists already"):
        run.save(tmp_path / "log.nc")
    assert (tmp_path / "log.nc").read_text() == "mine"


def test_metrics_that_are_not_numbers_are_refused(run, tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        Run("a", "a", run.log, {"tilt_max": float("nan")}).save(tmp_path / "log.nc")
    assert list(tmp_path.iterdir()) == []


def test_missing_file(tmp_path):
    with pytest.raises(OutputError, match=r"nothing\.nc' does not exist"):
        Run.load(tmp_path / "nothing.nc")


def test_foreign_and_damaged_files(run, tmp_path):
    text = tmp_path / "text.nc"
    text.write_text("not a record")
    with pytest.raises(OutputError, match="is not a readable NetCDF-4 file"):
        Run.load(text)
    foreign = tmp_path / "foreign.nc"
    xr.Dataset({"a": ("time", np.zeros(3))}).to_netcdf(foreign, engine="h5netcdf")
    with pytest.raises(OutputError, match="not a skylimb run"):
        Run.load(foreign)
    whole = run.save(tmp_path / "whole.nc").read_bytes()
    cut = tmp_path / "cut.nc"
    cut.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(OutputError, match="is not a readable NetCDF-4 file"):
        Run.load(cut)


def test_a_newer_format_is_refused(run, tmp_path):
    path = run.save(tmp_path / "log.nc")
    with xr.load_dataset(path, engine="h5netcdf") as log:
        log.attrs["format_version"] = FORMAT_VERSION + 1
    newer = tmp_path / "newer.nc"
    log.to_netcdf(newer, engine="h5netcdf")
    with pytest.raises(OutputError, match=f"has format version {FORMAT_VERSION + 1}"):
        Run.load(newer)


def test_a_run_says_in_five_lines_what_it_is(tmp_path) -> None:
    log = xr.Dataset({"tilt": ("time", [0.1, 0.2])}, {"time": [0.0, 2.0]}, {"experiment": "paper"})
    scored = {"done": False, "missed": ["the pen is off"], "tilt_max": 0.2, "error_u_median": None}
    run = Run("mine", "pid", log, scored)
    lines = repr(run).splitlines()
    assert lines[:4] == [
        "Run 'mine': OK; finished, not done as commanded: the pen is off",
        "  controller pid, experiment paper",
        "  scores: tilt_max = 0.2",
        "  log: 1 signals over 2.00 s",
    ]
    assert len(lines) == 5
    read = Run.load(run.save(tmp_path / "log.nc"))
    assert repr(read).splitlines()[4] == f"  file: {tmp_path / 'log.nc'}"


@pytest.mark.parametrize(
    ("status", "mark", "told"),
    [
        ("FAILED", "failed", "FAILED; fell"),
        ("UNFINISHED", "unfinished", "UNFINISHED; fell"),
        ("STOPPED", "", "STOPPED; fell"),
        ("OK", "", "OK; finished"),
    ],
)
def test_a_run_says_once_how_it_ended(status, mark, told) -> None:
    """A stopped flight said that it had finished, a lost one FAILED twice."""
    log = xr.Dataset(
        {"tilt": ("time", [0.1, 0.2])}, {"time": [0.0, 2.0]}, {"status": status, "cause": "fell"}
    )
    run = Run("mine", "pid", log)
    assert run.mark == mark
    assert repr(run).splitlines()[0] == f"Run 'mine': {told}"
    assert style.marked("pid", run) == ("PID" if run.stopped or status == "OK" else f"PID ({mark})")
