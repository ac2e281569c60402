"""Records as trees: a named tuple, a frozen dataclass, a dict or a plain tuple has children by name.

Leaves are floats, arrays and symbols; strings, booleans, integers and None belong to the structure.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from skylimb.symbolic import is_symbolic


def _is_vector(node: Any) -> bool:
    plain = isinstance(node, tuple | list) and not hasattr(node, "_fields")
    return (
        plain
        and len(node) > 0
        and all(isinstance(entry, float | int) and not isinstance(entry, bool) for entry in node)
    )


def is_leaf(node: Any) -> bool:
    """Whether a node is a number, an array, a symbol or a plain list of numbers."""
    return isinstance(node, float | np.ndarray | np.floating) or is_symbolic(node) or _is_vector(node)


def children_of(node: Any) -> Iterator[tuple[str, Any]]:
    """The nodes below one, by name; none of a leaf."""
    if hasattr(node, "_fields"):
        yield from zip(node._fields, node, strict=True)
    elif dataclasses.is_dataclass(node) and not isinstance(node, type):
        yield from ((field.name, getattr(node, field.name)) for field in dataclasses.fields(node))
    elif isinstance(node, dict):
        yield from node.items()
    elif isinstance(node, tuple):
        yield from ((str(index), child) for index, child in enumerate(node))


def rebuilt(node: Any, children: list[Any]) -> Any:
    """A node of the same kind with other children, in their order."""
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


def mapped(node: Any, path: str, on_leaf: Callable[[str, Any], Any]) -> Any:
    """The same tree with other leaves: what a function makes of the dotted name and the leaf that was."""
    if is_leaf(node):
        return on_leaf(path, node)
    children = list(children_of(node))
    if not children:
        return node
    return rebuilt(node, [mapped(child, below(path, name), on_leaf) for name, child in children])


def below(path: str, name: str) -> str:
    """The dotted name of a child."""
    return f"{path}.{name}" if path else name


def shape_of(leaf: Any, wanted: tuple[int, ...] = ()) -> tuple[int, ...]:
    """Of a leaf; a symbolic column is a vector, one entry a number.

    Args:
        leaf: a number or numbers.
        wanted: what one symbolic entry is where one entry is wanted, such as a vector of one.
    """
    if is_symbolic(leaf):
        rows, columns = leaf.shape
        if rows == columns == 1 and set(wanted) <= {1}:
            return wanted
        return () if rows == columns == 1 else (rows,) if columns == 1 else (rows, columns)
    return np.shape(leaf)
