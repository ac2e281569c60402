"""Named records to flat vectors and back: how states, gains and signals cross into a compiled function.

A record is a named tuple, a frozen dataclass, a dict or a plain tuple of records; its leaves are floats and
arrays. Strings, booleans, integers and None belong to the structure: they are kept as they stand and take no
room in the vector.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from operator import itemgetter
from typing import Any, Generic, TypeVar

import casadi as ca
import numpy as np

from skylimb.base.record_access import reader_of, writer_of
from skylimb.base.record_tree import children_of, is_leaf, mapped, rebuilt, shape_of
from skylimb.symbolic import as_numpy, is_symbolic, where

R = TypeVar("R")


class Layout(Generic[R]):
    """Where each leaf of a record stands in a flat vector.

    Args:
        template: a record with leaves of the right shapes; its numbers are not kept, its structure is.

    Attributes:
        size: length of the flat vector.
        slices: dotted leaf name -> slice of the flat vector.
        shapes: dotted leaf name -> shape of the leaf; matrices are stored row by row.
    """

    def __init__(self, template: R) -> None:
        self.slices: dict[str, slice] = {}
        self.shapes: dict[str, tuple[int, ...]] = {}
        self.size = 0
        self._template = template
        mapped(template, "", self._add)

    def _add(self, path: str, leaf: Any) -> Any:
        shape = shape_of(leaf)
        length = int(np.prod(shape, dtype=int))
        self.slices[path] = slice(self.size, self.size + length)
        self.shapes[path] = shape
        self.size += length
        return leaf

    def pack(self, record: R) -> Any:
        """The record's leaves as one flat vector: (size,) in NumPy, size x 1 in CasADi."""
        parts: dict[str, Any] = {}
        mapped(record, "", parts.setdefault)
        if parts.keys() != self.slices.keys():
            odd = sorted(parts.keys() ^ self.slices.keys())
            raise ValueError(f"record does not fit the layout: {', '.join(odd)}")
        if is_symbolic(*parts.values()):
            flat = [_symbolic_column(part) for part in parts.values()]
            return ca.vertcat(*flat) if flat else ca.SX(0, 1)
        return flattened(parts.values())

    def unpack(self, flat: Any) -> R:
        """A record like the template whose leaves are the vector's entries (arrays, or symbols)."""
        if is_symbolic(flat):
            return mapped(self._template, "", lambda path, _: self._symbols(flat, path))
        return self._unpacked(flat)

    @cached_property
    def _unpacked(self) -> Callable[[np.ndarray], R]:
        """What makes a record of an array of (size,)."""
        fixed, record = reader_of(self._template, "", self._taken)
        return (lambda flat: record) if fixed else record

    def _taken(self, path: str) -> tuple[bool, Callable[[np.ndarray], Any]]:
        where, shape = self.slices[path], self.shapes[path]
        if shape == ():
            return False, lambda flat: float(flat[where.start])
        return False, itemgetter(where) if len(shape) == 1 else lambda flat: flat[where].reshape(shape)

    def reader(self, flat: np.ndarray) -> Callable[[], R]:
        """A function that gives the record that an array of (size,) holds at the moment.

        Arrays of the record are views on `flat` that cannot be written to; what does not change is made once.
        """
        fixed, record = reader_of(self._template, "", lambda path: self._seen(flat, path))
        return (lambda: record) if fixed else (lambda: record(flat.tolist()))

    def _seen(self, flat: np.ndarray, path: str) -> tuple[bool, Any]:
        where, shape = self.slices[path], self.shapes[path]
        if shape == ():
            return False, itemgetter(where.start)
        view = flat[where].reshape(shape)
        view.flags.writeable = False
        return True, view

    def writer(self, flat: np.ndarray) -> Callable[[R], None]:
        """A function that writes the numbers of a record into an array of (size,).

        It raises a `ValueError` that says what it got and what the template has in its place, where a record
        has another kind, other names, other shapes, or another value of what is no number.
        """
        return writer_of(self._template, "", lambda path: (flat, self.slices[path], self.shapes[path]))

    def _symbols(self, flat: Any, path: str) -> Any:
        part, shape = flat[self.slices[path]], self.shapes[path]
        return part if len(shape) < 2 else ca.reshape(part, shape[1], shape[0]).T


def _symbolic_column(part: Any) -> Any:
    if is_symbolic(part):
        return ca.reshape(part.T, -1, 1)
    return ca.SX(np.ravel(np.asarray(part, dtype=float)))


def flattened(parts: Iterable[Any]) -> np.ndarray:
    """Numbers and arrays of numbers in a row, (n,); matrices row by row."""
    return np.concatenate([*parts, ()], axis=None, dtype=float)


def numeric(record: R) -> R:
    """The same record with every leaf a float or a NumPy array, ready for arithmetic."""
    layout = Layout(record)
    return layout.unpack(layout.pack(record))


def chosen(first: Any, one: R, other: R) -> R:
    """One record where a condition holds, else the other; in numbers and in symbols alike."""
    layout = Layout(one)
    return layout.unpack(where(first, layout.pack(one), layout.pack(other)))


def number(value: Any, shape: tuple[int, ...] = ()) -> Any:
    """A float or an array, also from CasADi's numbers, whose vectors are columns.

    Args:
        value: a number or numbers.
        shape: that is wanted; CasADi does not tell a vector of one entry from a number.
    """
    array = np.asarray(as_numpy(value), dtype=float)
    if is_symbolic(value):
        array = array.reshape(shape_of(value, shape))
    return array.item() if array.ndim == 0 else array


def with_floats(record: Any) -> Any:
    """The same record with whole numbers and truth values as floats, which stand in a vector."""
    if isinstance(record, bool | int | np.bool_ | np.integer):
        return float(record)
    if is_leaf(record):
        return record
    children = list(children_of(record))
    return rebuilt(record, [with_floats(child) for _, child in children]) if children else record


def is_numeric(record: Any) -> bool:
    """Whether a record holds numbers alone, so that a flat vector says all of it."""
    if is_leaf(record):
        return is_symbolic(record) or np.asarray(record).dtype.kind in "fiub"
    empty = isinstance(record, tuple | dict) and not record
    children = list(children_of(record))
    return empty or (bool(children) and all(is_numeric(child) for _, child in children))


def structure(record: Any) -> str:
    """What a record is besides its numbers: kinds, names, shapes and the values that are kept as they are."""
    return repr((type(record), mapped(record, "", lambda path, leaf: (path, shape_of(leaf)))))


def pack_rows(layout: Layout[R], record: R, count: int) -> np.ndarray:
    """A table of packed records, (count, layout.size), from a record whose leaves have `count` rows each."""
    table = np.empty((count, layout.size))

    def fill(path: str, leaf: Any) -> Any:
        table[:, layout.slices[path]] = np.reshape(leaf, (count, -1))
        return leaf

    mapped(record, "", fill)
    return table
