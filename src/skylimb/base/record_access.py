"""Records of numbers made and taken apart fast, tick by tick: what is known of them is worked out once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from skylimb.base.record_tree import below, children_of, is_leaf, rebuilt, shape_of
from skylimb.symbolic import is_symbolic


def reader_of(node: Any, path: str, leaf: Callable[[str], tuple[bool, Any]]) -> tuple[bool, Any]:
    """Whether a record is always the same, and the record itself, or a function that makes it of numbers."""
    if is_leaf(node):
        return leaf(path)
    parts = [reader_of(child, below(path, name), leaf) for name, child in children_of(node)]
    if all(fixed for fixed, _ in parts):
        return True, rebuilt(node, [part for _, part in parts]) if parts else node
    known = [part for _, part in parts]
    moving = [(k, part) for k, (fixed, part) in enumerate(parts) if not fixed]
    rebuild = node._make if hasattr(node, "_fields") else partial(rebuilt, node)

    def record(numbers: Any) -> Any:
        children = known.copy()
        for k, part in moving:
            children[k] = part(numbers)
        return rebuild(children)

    return False, record


def writer_of(
    node: Any, path: str, leaf: Callable[[str], tuple[np.ndarray, slice, tuple[int, ...]]]
) -> Callable[[Any], None]:
    """Writes what stands in the place of a node, after a look at its kind."""
    if is_leaf(node):
        flat, where, shape = leaf(path)

        vector = len(shape) == 1

        def write(value: Any) -> None:
            if type(value) is not np.ndarray or value.shape != shape:
                value = _array(value, path, shape)
            flat[where] = value if vector else value.ravel()

        return write
    parts = [(name, writer_of(child, below(path, name), leaf)) for name, child in children_of(node)]

    names, writers, kind = [name for name, _ in parts], [write for _, write in parts], type(node)

    def write_same(value: Any) -> None:
        if value is not node and value != node:
            entries = [_named(list(one)) if isinstance(one, dict) else repr(one) for one in (value, node)]
            raise _odd(path, *entries)

    def write_parts(value: Any) -> None:
        if type(value) is not kind:
            raise _odd(path, _kind(value), _kind(node))
        known = (len(value) == len(names)) if isinstance(value, tuple) else dict(children_of(value))
        if known is False or (known is not True and known.keys() != set(names)):
            raise _odd(path, _named([name for name, _ in children_of(value)]), _named(names))
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
        array = array.reshape(shape_of(value, shape))
    if array.shape != shape:
        raise _odd(path, _sized(array.shape), _sized(shape))
    return array


def _odd(path: str, got: str, expected: str) -> ValueError:
    return ValueError(f"{path}{path and ': '}got {got}, expected {expected}")


def _named(names: Sequence[str]) -> str:
    return f"the entries {', '.join(names)}" if names else "no entries"


def _sized(shape: tuple[int, ...]) -> str:
    return f"shape {shape}" if shape else "a number"


def _kind(value: Any) -> str:
    return "None" if value is None else type(value).__name__
