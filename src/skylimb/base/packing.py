"""Named records to flat vectors and back: how states, gains and signals cross into a compiled function.

A record is a named tuple, a frozen dataclass, a dict or a plain tuple of records; its leaves are floats and
arrays. Strings, booleans, integers and None belong to the structure: they are kept as they stand and take no
room in the vector.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

import casadi as ca
import numpy as np

from skylimb.symbolic import is_symbolic

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
    return _rebuild(
        node, [_map(child, f"{path}.{name}" if path else name, on_leaf) for name, child in children]
    )


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
        return _map(self._template, "", lambda path, _: self._leaf(flat, path))

    def _leaf(self, flat: Any, path: str) -> Any:
        part, shape = flat[self.slices[path]], self.shapes[path]
        if is_symbolic(flat):
            return part if len(shape) < 2 else ca.reshape(part, shape[1], shape[0]).T
        return float(part[0]) if shape == () else np.reshape(part, shape)


def _symbolic_column(part: Any) -> Any:
    if is_symbolic(part):
        return ca.reshape(part.T, -1, 1)
    return ca.SX(np.ravel(np.asarray(part, dtype=float)))


def numeric(record: R) -> R:
    """The same record with every leaf a float or a NumPy array, ready for arithmetic."""
    layout = Layout(record)
    return layout.unpack(layout.pack(record))


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
