"""The C declaration of a structure that Python declares with ctypes, so that the two cannot differ."""

from __future__ import annotations

import ctypes
import functools
from typing import Any

_NAMES: dict[Any, str] = {
    ctypes.c_int8: "int8_t",
    ctypes.c_uint8: "uint8_t",
    ctypes.c_int32: "int32_t",
    ctypes.c_uint32: "uint32_t",
    ctypes.c_int64: "int64_t",
    ctypes.c_uint64: "uint64_t",
    ctypes.c_float: "float",
    ctypes.c_double: "double",
    ctypes.c_void_p: "void*",
}


class _Address(ctypes.c_void_p):
    """A pointer field that knows its type in C."""

    c_type = "void*"


@functools.cache
def address(c_type: str) -> type[ctypes.c_void_p]:
    """Type of a field that holds an address in Python and is a pointer in C.

    An integer can be assigned to such a field, and None for the null pointer; `.value` reads it.

    Args:
        c_type: the whole type in C, for example "const double*", or the name of a type of pointers.
    """
    return type("Address", (_Address,), {"c_type": c_type})


def c_declaration(structure: type[ctypes.Structure], name: str = "") -> str:
    """C text that declares a structure with the same fields in the same order, under a `typedef`.

    The C compiler checks that it has the size that the structure has in Python. Before the text, C must have
    seen <stdint.h> and every type that a field names.

    Args:
        structure: fields of fixed-width integers, floats, `address`es, other structures, and arrays of those.
        name: in C; the structure's own by default.

    Raises:
        TypeError: when a field has another type.
    """
    name = name or structure.__name__
    fields = [entry for part in reversed(structure.__mro__) for entry in part.__dict__.get("_fields_", ())]
    lines = [f"  {_declared(structure, entry[0], entry[1])};" for entry in fields]
    size = f"sizeof({name}) == {ctypes.sizeof(structure)}"
    check = f'_Static_assert({size}, "{name} has another size in Python");'
    return "\n".join(["typedef struct {", *lines, f"}} {name};", check, ""])


def _declared(structure: type[ctypes.Structure], field: str, kind: Any) -> str:
    extents = ""
    while isinstance(kind, type) and issubclass(kind, ctypes.Array):
        extents += f"[{kind._length_}]"
        kind = kind._type_
    if issubclass(kind, _Address):
        c_type = kind.c_type
    elif issubclass(kind, ctypes.Structure):
        c_type = kind.__name__
    elif kind in _NAMES:
        c_type = _NAMES[kind]
    else:
        allowed = ", ".join(("address", "Structure", *_NAMES.values()))
        raise TypeError(f"{structure.__name__}.{field} is a {kind.__name__}, which is none of {allowed}")
    return f"{c_type} {field}{extents}"
