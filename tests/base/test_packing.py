from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pytest

from skylimb.base.packing import Layout, flattened, number, numeric, pack_rows
from skylimb.control.missions.reference import zero_reference


class Inner(NamedTuple):
    vector: Any
    matrix: Any
    scalar: Any


RECORD = {
    "inner": Inner(np.arange(3.0), np.arange(6.0).reshape(2, 3), 7.0),
    "gains": (1.0, 2.0),
    "on": True,
    "none": (),
}


def test_round_trip_keeps_values_shapes_and_structure() -> None:
    layout = Layout(RECORD)
    back = layout.unpack(layout.pack(RECORD))
    assert layout.size == 3 + 6 + 1 + 2
    assert back["on"] is True
    assert back["none"] == ()
    np.testing.assert_array_equal(back["inner"].matrix, RECORD["inner"].matrix)
    np.testing.assert_array_equal(back["gains"], [1.0, 2.0])


def test_what_travels_flat_is_in_a_row_whatever_its_shape_and_kind() -> None:
    transposed = np.arange(6.0).reshape(2, 3).T
    flat = flattened((1.0, True, np.float64(2.0), transposed, [3, 4.0], np.zeros(0)))
    np.testing.assert_array_equal(flat, [1.0, 1.0, 2.0, 0.0, 3.0, 1.0, 4.0, 2.0, 5.0, 3.0, 4.0])
    assert flat.dtype == float
    assert flattened(()).shape == (0,)


def test_entries_of_a_reference_are_those_that_its_layout_has() -> None:
    later = zero_reference(2, 1)._replace(reach=3.0)
    reference = zero_reference(2, 1)._replace(heading=2.0, ahead=(later, later))
    np.testing.assert_array_equal(flattened(reference.entries), Layout(reference).pack(reference))


def test_symbols_stand_where_numbers_stand() -> None:
    layout = Layout(RECORD)
    flat = ca.SX.sym("x", layout.size)
    again = layout.pack(layout.unpack(flat))
    traced = ca.Function("f", [flat], [again])
    values = np.arange(float(layout.size))
    np.testing.assert_array_equal(traced(values).full().ravel(), values)


def test_rows_are_packed_records() -> None:
    layout = Layout(Inner(np.zeros(3), np.zeros((2, 3)), 0.0))
    rng = np.random.default_rng(1)
    many = Inner(rng.random((5, 3)), rng.random((5, 2, 3)), rng.random(5))
    table = pack_rows(layout, many, 5)
    one = Inner(*(leaf[3] for leaf in many))
    np.testing.assert_array_equal(table[3], layout.pack(one))


def test_a_record_that_does_not_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="extra"):
        Layout({"a": 1.0}).pack({"a": 1.0, "extra": 2.0})


def test_numeric_turns_tuples_into_arrays() -> None:
    assert isinstance(numeric({"k": (1.0, 2.0)})["k"], np.ndarray)


def test_one_entry_of_casadis_is_what_is_wanted_in_its_place() -> None:
    one = ca.DM([2.0])
    assert isinstance(number(one), float)
    assert number(one, (1,)).shape == (1,)
    assert number(one, (3,)) == 2.0, "a wrong shape is seen by whoever wants it"
    flat = np.zeros(2)
    template: tuple[Any, Any] = np.zeros(1), 0.0
    Layout(template).writer(flat)((one, one))
    np.testing.assert_array_equal(flat, [2.0, 2.0])
