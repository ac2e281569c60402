"""A single flight takes machine code only where building it pays."""

from collections.abc import Callable
from pathlib import Path

import pytest

from skylimb.base.c_code import c_source
from skylimb.base.errors import CompileError
from skylimb.flight import flying
from skylimb.flight.drivers import machine_code
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.compiling import met_often


def test_how_often_a_source_was_met_is_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert [met_often("native", "one", "int a;", 2) for _ in range(4)] == [False, False, True, True]
    assert not met_often("native", "one", "int b;", 2)


def test_a_cache_that_cannot_be_written_decides_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "skylimb").write_text("a file in the place of the cache")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert [met_often("native", "one", "int a;", 1) for _ in range(3)] == [False, False, False]


def test_a_flight_that_was_flown_often_is_native(
    make_takeoff: Callable[..., Takeoff], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(machine_code, "_loaded", type(machine_code._loaded)())
    if not flying.native_available():
        pytest.skip("no C compiler on this machine")
    taken: list[str] = []

    def native(takeoffs: list[Takeoff], **options: object) -> list[None]:
        taken.append("native")
        return [None]

    monkeypatch.setattr(flying, "fly_native", native)
    monkeypatch.setattr(flying, "fly_here", lambda *given: taken.append("here"))
    takeoff = make_takeoff("paper", "pid")
    for _ in range(machine_code.PAYS_AFTER + 2):
        flying.fly(takeoff)
    assert taken == ["here"] * machine_code.PAYS_AFTER + ["native"] * 2


def test_the_code_of_a_tick_is_written_once_for_all_its_flights(make_takeoff: Callable[..., Takeoff]) -> None:
    """It took a third of a flight's time, to see whether there is machine code for it."""
    one, other = (make_takeoff("paper", "pid", {"seed": seed}) for seed in (1, 2))
    assert c_source(one.tick.function) is c_source(other.tick.function)


def test_a_tick_that_can_be_built_nowhere_flies_with_another_driver(
    make_takeoff: Callable[..., Takeoff], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*given: object, **options: object) -> None:
        raise CompileError("C code can be compiled nowhere")

    monkeypatch.setattr(flying, "worth_building", lambda function: True)
    monkeypatch.setattr(flying, "native_available", lambda: True)
    monkeypatch.setattr(flying, "fly_native", refuse)
    monkeypatch.setattr(machine_code, "machine_code", refuse)
    takeoff = make_takeoff("paper", "pid")
    assert flying.fastest_tick(takeoff).function is takeoff.tick.function
    monkeypatch.setattr(flying, "fly_here", lambda *given: "here")
    assert flying.fly(takeoff) == "here"
