"""Exported C on random inputs: whatever comes in, every command is finite and within its limits."""

from __future__ import annotations

import functools
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import skylimb
from skylimb.flight.export import export_c

HELPERS = Path(__file__).parents[1] / "helpers"
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
SANITIZERS = ("-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]


Controller = Callable[..., list[Path]]


@pytest.fixture(scope="module")
def controller(tmp_path_factory: pytest.TempPathFactory) -> Controller:
    """Objects of a controller's C and the folder of its headers, built once for what is linked with it."""

    @functools.cache
    def made(compiler: str, name: str, flags: tuple[str, ...]) -> list[Path]:
        folder = tmp_path_factory.mktemp(name) / "c"
        export_c(skylimb.load_controller(name, skylimb.load_robot("hydrus_xi_quad")), folder)
        sources = [folder / "controller.c", folder / "controller_function.c"]
        command = [compiler, *STRICT, *flags, "-c", *map(str, sources)]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        return [folder, *(source.with_suffix(".o") for source in sources)]

    return made


def ran(
    program: str, compiler: str, built: list[Path], folder: Path, flags: tuple[str, ...], count: int
) -> list[int]:
    """What a helper in C counts in each mode, linked with a controller."""
    headers, *objects = built
    sources = [HELPERS / f"{program}.c", *objects]
    command = [compiler, *STRICT, *flags, f"-I{headers}", *map(str, sources), "-o", str(folder / program)]
    subprocess.run([*command, "-lm"], check=True, capture_output=True)
    done = subprocess.run([folder / program, str(count), "7"], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return list(map(int, done.stdout.split()))


@pytest.mark.skipif(not COMPILERS, reason="no gcc or clang on this machine")
def test_commands_stay_within_limits(controller: Controller, tmp_path: Path) -> None:
    built = controller(COMPILERS[0], "hybrid", SANITIZERS)
    modes = ran("fuzz", COMPILERS[0], built, tmp_path, SANITIZERS, 50_000)
    assert sum(modes) == 50_000
    assert min(modes) > 100


@pytest.mark.slow
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", ["hybrid", "following", "drawing"])
def test_a_million_ticks(controller: Controller, compiler: str, name: str, tmp_path: Path) -> None:
    built = controller(compiler, name, ("-O2",))
    modes = ran("fuzz", compiler, built, tmp_path, ("-O2",), 1_000_000)
    assert sum(modes) == 1_000_000
    assert min(modes) > 1000


@pytest.mark.skipif(not COMPILERS, reason="no gcc or clang on this machine")
def test_a_fault_that_lasts_ends_in_its_mode_in_time_after_any_history(
    controller: Controller, tmp_path: Path
) -> None:
    """After clocks that are set, poses that jump and late ticks; `test_sequences.py` has it of Python."""
    built = controller(COMPILERS[0], "hybrid", SANITIZERS)
    modes = ran("lasting", COMPILERS[0], built, tmp_path, SANITIZERS, 300)
    assert modes[:2] == [0, 0]
    assert sum(modes) == 300


FLAGS = {
    "-ffast-math": "build without -ffast-math",
    "-ffinite-math-only": "and -ffinite-math-only",
    "-fsingle-precision-constant": "build_without_fsingle_precision_constant",
}


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc on this machine")
def test_code_that_would_be_another_is_not_built(tmp_path: Path) -> None:
    """Gates let a NaN through, or constants lose half their digits and 1e-300 is zero."""
    made = tmp_path / "c"
    export_c(skylimb.load_controller("pid", skylimb.load_robot("hydrus_xi_quad")), made)
    for source in ("controller.c", "controller_function.c"):  # a make file may have flags for each
        for flag, why in FLAGS.items():
            built = ["gcc", "-fsyntax-only", flag, str(made / source)]
            done = subprocess.run(built, check=False, capture_output=True, text=True)
            assert (done.returncode, why in done.stderr) == (1, True), (source, flag, done.stderr)
