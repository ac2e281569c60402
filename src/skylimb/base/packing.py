"""Named records to flat vectors and back: how states, gains and signals cross into a compiled function.

A record is a named tuple, a frozen dataclass, a dict or a plain tuple of records; its leaves are floats and
arrays. Strings, booleans, integers and None belong to the structure: they are kept as they stand and take no
room in the vector.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from functools import cached_property, partial
from operator import itemgetter
from typing import Any, Generic, TypeVar

import casadi as ca
import numpy as np

from skylimb.symbolic import as_numpy, is_symbolic, where

R = TypeVar("R")


def _is_vector(node: Any) -> bool:
    plain = isinstance(node, tuple | list) and not hasattr(node, "_fields")
    return (
        plain
        and len(node) > 0
        and all(isinstance(entry, float | int) and not isinstance(entry, bool) for entry in node)
    )


def _is_leaf(node: Any) -> bool:
    return isinstance(node, float | np.ndarray | np.floating) or is_symbolic(node) or _is_vector(node)


def _children(node: Any) -> Iterator[tuple[str, Any]]:
    if hasattr(node, "_fields"):
        yield from zip(node._fields, node, strict=True)
    elif dataclasses.is_dataclass(node) and not isinstance(node, type):
        yield from ((field.name, getattr(node, field.name)) for field in dataclasses.fields(node))
    elif isinstance(node, dict):
        yield from node.items()
    elif isinstance(node, tuple):
        yield from ((str(index), child) for index, child in enumerate(node))


def _rebuild(node: Any, children: list[Any]) -> Any:
    if hasattr(node, "_fields"):
        return type(node)(*children)
    if dataclasses.is_dataclass(node) and not isinstance(node, type):
        # Checks in __post_init__ are for numbers; a record of symbols must not run them.
        clone = object.__new__(type(node))
        for field, child in zip(dataclasses.fields(node), children, strict=True):
            object.__setattr__(clone, field.name, child)
        return clone
    if isinstance(node, dict):
        return dict(zip(node, children, strict=True))
    return tuple(children)


def _map(node: Any, path: str, on_leaf: Callable[[str, Any], Any]) -> Any:
    if _is_leaf(node):
        return on_leaf(path, node)
    children = list(_children(node))
    if not children:
        return node
    return _rebuild(node, [_map(child, _below(path, name), on_leaf) for name, child in children])


def _below(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _shape(leaf: Any) -> tuple[int, ...]:
    if is_symbolic(leaf):
        rows, columns = leaf.shape
        return () if rows == columns == 1 else (rows,) if columns == 1 else (rows, columns)
    return np.shape(leaf)


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
        _map(template, "", self._add)

    def _add(self, path: str, leaf: Any) -> Any:
        shape = _shape(leaf)
        length = int(np.prod(shape, dtype=int))
        self.slices[path] = slice(self.size, self.size + length)
        self.shapes[path] = shape
        self.size += length
        return leaf

    def pack(self, record: R) -> Any:
        """The record's leaves as one flat vector: (size,) in NumPy, size x 1 in CasADi."""
        parts: dict[str, Any] = {}
        _map(record, "", parts.setdefault)
        if parts.keys() != self.slices.keys():
            odd = sorted(parts.keys() ^ self.slices.keys())
            raise ValueError(f"record does not fit the layout: {', '.join(odd)}")
        if is_symbolic(*parts.values()):
            flat = [_symbolic_column(part) for part in parts.values()]
            return ca.vertcat(*flat) if flat else ca.SX(0, 1)
        return np.concatenate(
            [np.ravel(np.asarray(part, dtype=float)) for part in parts.values()] or [np.zeros(0)]
        )

    def unpack(self, flat: Any) -> R:
        """A record like the template whose leaves are the vector's entries (arrays, or symbols)."""
        if is_symbolic(flat):
            return _map(self._template, "", lambda path, _: self._symbols(flat, path))
        return self._unpacked(flat)

    @cached_property
    def _unpacked(self) -> Callable[[np.ndarray], R]:
        """What makes a record of an array of (size,)."""
        fixed, record = _reader(self._template, "", self._taken)
        return (lambda flat: record) if fixed else record

    def _taken(self, path: str) -> tuple[bool, Callable[[np.ndarray], Any]]:
        where, shape = self.slices[path], self.shapes[path]
        if shape == ():
            return False, lambda flat: float(flat[where.start])
        return False, lambda flat: flat[where].reshape(shape)

    def reader(self, flat: np.ndarray) -> Callable[[], R]:
        """A function that gives the record that an array of (size,) holds at the moment.

        Arrays of the record are views on `flat` that cannot be written to; what does not change is made once.
        """
        fixed, record = _reader(self._template, "", lambda path: self._seen(flat, path))
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
        return _writer(self._template, "", lambda path: (flat, self.slices[path], self.shapes[path]))

    def _symbols(self, flat: Any, path: str) -> Any:
        part, shape = flat[self.slices[path]], self.shapes[path]
        return part if len(shape) < 2 else ca.reshape(part, shape[1], shape[0]).T


def _reader(node: Any, path: str, leaf: Callable[[str], tuple[bool, Any]]) -> tuple[bool, Any]:
    """Whether a record is always the same, and the record itself, or a function that makes it of numbers."""
    if _is_leaf(node):
        return leaf(path)
    parts = [_reader(child, _below(path, name), leaf) for name, child in _children(node)]
    if all(fixed for fixed, _ in parts):
        return True, _rebuild(node, [part for _, part in parts]) if parts else node
    known = [part for _, part in parts]
    moving = [(k, part) for k, (fixed, part) in enumerate(parts) if not fixed]
    rebuild = node._make if hasattr(node, "_fields") else partial(_rebuild, node)

    def record(numbers: Any) -> Any:
        children = known.copy()
        for k, part in moving:
            children[k] = part(numbers)
        return rebuild(children)

    return False, record


def _writer(
    node: Any, path: str, leaf: Callable[[str], tuple[np.ndarray, slice, tuple[int, ...]]]
) -> Callable[[Any], None]:
    """Writes what stands in the place of a node, after a look at its kind."""
    if _is_leaf(node):
        flat, where, shape = leaf(path)

        vector = len(shape) == 1

        def write(value: Any) -> None:
            if type(value) is not np.ndarray or value.shape != shape:
                value = _array(value, path, shape)
            flat[where] = value if vector else value.ravel()

        return write
    parts = [(name, _writer(child, _below(path, name), leaf)) for name, child in _children(node)]

    names, writers, kind = [name for name, _ in parts], [write for _, write in parts], type(node)

    def write_same(value: Any) -> None:
        if value is not node and value != node:
            raise _odd(path, repr(value), repr(node))

    def write_parts(value: Any) -> None:
        if type(value) is not kind:
            raise _odd(path, _kind(value), _kind(node))
        known = (len(value) == len(names)) if isinstance(value, tuple) else dict(_children(value))
        if known is False or (known is not True and known.keys() != set(names)):
            got = ", ".join(name for name, _ in _children(value)) or "nothing"
            raise _odd(path, got, ", ".join(names))
        children = value if known is True else [known[name] for name in names]
        for write, child in zip(writers, children, strict=True):
            write(child)

    return write_parts if parts else write_same


def _array(value: Any, path: str, shape: tuple[int, ...]) -> np.ndarray:
    try:
        array = np.asarray("" if value is None else value, dtype=float)  # NumPy takes None for NaN
    except (TypeError, ValueError):
        raise _odd(path, _kind(value), _sized(shape)) from None
    if is_symbolic(value):  # CasADi's vectors are columns
        array = array.reshape(_shape(value))
    if array.shape != shape:
        raise _odd(path, _sized(array.shape), _sized(shape))
    return array


def _odd(path: str, got: str, expected: str) -> ValueError:
    return ValueError(f"{path}{path and ': '}got {got}, expected {expected}")


def _sized(shape: tuple[int, ...]) -> str:
    return f"shape {shape}" if shape else "a number"


def _kind(value: Any) -> str:
    return "None" if value is None else type(value).__name__


def _symbolic_column(part: Any) -> Any:
    if is_symbolic(part):
        return ca.reshape(part.T, -1, 1)
    return ca.SX(np.ravel(np.asarray(part, dtype=float)))


def numeric(record: R) -> R:
    """The same record with every leaf a float or a NumPy array, ready for arithmetic."""
    layout = Layout(record)
    return layout.unpack(layout.pack(record))


def chosen(first: Any, one: R, other: R) -> R:
    """One record where a condition holds, else the other; in numbers and in symbols alike."""
    layout = Layout(one)
    return layout.unpack(where(first, layout.pack(one), layout.pack(other)))


def number(value: Any) -> Any:
    """A float or an array, also from CasADi's numbers, whose vectors are columns."""
    array = np.asarray(as_numpy(value), dtype=float)
    return array.item() if array.ndim == 0 or (is_symbolic(value) and array.size == 1) else array


def with_floats(record: Any) -> Any:
    """The same record with whole numbers and truth values as floats, which stand in a vector."""
    if isinstance(record, bool | int | np.bool_ | np.integer):
        return float(record)
    if _is_leaf(record):
        return record
    children = list(_children(record))
    return _rebuild(record, [with_floats(child) for _, child in children]) if children else record


def is_numeric(record: Any) -> bool:
    """Whether a record holds numbers alone, so that a flat vector says all of it."""
    if _is_leaf(record):
        return is_symbolic(record) or np.asarray(record).dtype.kind in "fiub"
    empty = isinstance(record, tuple | dict) and not record
    children = list(_children(record))
    return empty or (bool(children) and all(is_numeric(child) for _, child in children))


def structure(record: Any) -> str:
    """What a record is besides its numbers: kinds, names, shapes and the values that are kept as they are."""
    return repr((type(record), _map(record, "", lambda path, leaf: (path, _shape(leaf)))))


def pack_rows(layout: Layout[R], record: R, count: int) -> np.ndarray:
    """A table of packed records, (count, layout.size), from a record whose leaves have `count` rows each."""
    table = np.empty((count, layout.size))

    def fill(path: str, leaf: Any) -> Any:
        table[:, layout.slices[path]] = np.reshape(leaf, (count, -1))
        return leaf

    _map(record, "", fill)
    return table
