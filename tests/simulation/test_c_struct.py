import ctypes
from pathlib import Path

import pytest

from skylimb.base.errors import CompileError
from skylimb.simulation import compiling
from skylimb.simulation.c_struct import address, c_declaration
from skylimb.simulation.compiling import FLAGS, compile_c, compilers

needs_compiler = pytest.mark.skipif(not compilers(), reason="no C compiler on this machine")


class Inner(ctypes.Structure):
    _fields_ = (("flag", ctypes.c_uint8), ("count", ctypes.c_int64))


class Base(ctypes.Structure):
    _fields_ = (("kind", ctypes.c_int32),)


class Outer(Base):
    _fields_ = (
        ("tick", address("Tick")),
        ("rows", address("const double*")),
        ("states", address("double*") * 2),
        ("limits", ctypes.c_double * 3 * 2),
        ("inner", Inner),
        ("inners", Inner * 2),
        ("rest", ctypes.c_void_p),
        ("last", ctypes.c_float),
    )


DECLARED = """typedef struct {
  int32_t kind;
  Tick tick;
  const double* rows;
  double* states[2];
  double limits[2][3];
  Inner inner;
  Inner inners[2];
  void* rest;
  float last;
} Outer;
"""


def test_fields_stand_in_c_as_in_python() -> None:
    text = c_declaration(Outer)
    assert text.startswith(DECLARED)
    assert f"sizeof(Outer) == {ctypes.sizeof(Outer)}" in text
    assert "} Flight;\n" in c_declaration(Outer, "Flight")


@needs_compiler
def test_c_reads_what_python_writes(tmp_path: Path) -> None:
    source = tmp_path / "read.c"
    source.write_text(
        "#include <stdint.h>\ntypedef double (*Tick)(double);\n"
        + c_declaration(Inner)
        + c_declaration(Outer, "Record")
        + """double add(const Record* r) {
  return r->tick(r->rows[1]) + r->states[1][0] + r->limits[1][2] + r->inner.count + r->inners[1].flag
    + r->last + (r->rest == 0);
}
"""
    )
    compile_c([source], tmp_path / "read.so", FLAGS)
    library = ctypes.CDLL(str(tmp_path / "read.so"))
    library.add.restype = ctypes.c_double
    twice = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(lambda value: 2.0 * value)
    numbers = (ctypes.c_double * 2)(5.0, 7.0)
    record = Outer()
    record.tick = ctypes.cast(twice, ctypes.c_void_p).value
    record.rows = ctypes.addressof(numbers)
    record.states[1] = ctypes.addressof(numbers)
    record.limits[1][2], record.inner.count, record.inners[1].flag, record.last = 100.0, 1000, 200, 0.5
    assert getattr(record.rows, "value") == ctypes.addressof(numbers)  # noqa: B009 - pyright takes it for an int
    assert library.add(ctypes.byref(record)) == 2.0 * 7.0 + 5.0 + 100.0 + 1000.0 + 200.0 + 0.5 + 1.0


@needs_compiler
def test_a_structure_of_another_size_does_not_compile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiling, "compilers", lambda: compilers()[:1])  # one that refuses it will do

    class Packed(ctypes.Structure):
        _pack_ = 1
        _layout_ = "ms"
        _fields_ = (("flag", ctypes.c_uint8), ("value", ctypes.c_double))

    source = tmp_path / "packed.c"
    source.write_text("#include <stdint.h>\n" + c_declaration(Packed))
    with pytest.raises(CompileError, match="another size"):
        compile_c([source], tmp_path / "packed.so", FLAGS)


def test_a_field_that_has_no_fixed_width_is_named() -> None:
    class Loose(ctypes.Structure):
        _fields_ = (("length", ctypes.c_wchar),)

    with pytest.raises(TypeError, match=r"Loose\.length is a c_wchar"):
        c_declaration(Loose)
