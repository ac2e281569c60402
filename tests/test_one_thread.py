"""Workers stand beside each other: linear algebra has one thread in each."""

import ctypes
import sys
from pathlib import Path

import pytest
import scipy.linalg

ASKED = [f"{kind}openblas_get_num_threads{ending}" for kind in ("", "scipy_") for ending in ("", "64_")]


@pytest.mark.skipif(sys.platform != "linux", reason="what a process has loaded is read as Linux shows it")
def test_linear_algebra_has_one_thread() -> None:
    assert scipy.linalg.eigvals([[2.0]]) == 2.0  # NumPy and SciPy bring a library each
    mapped = Path("/proc/self/maps").read_text().splitlines()
    libraries = [ctypes.CDLL(path) for path in {one.split()[-1] for one in mapped if "openblas" in one}]
    threads = [getattr(one, name)() for one in libraries for name in ASKED if hasattr(one, name)]
    if not threads:
        pytest.skip("linear algebra is another library's here")
    assert set(threads) == {1}
