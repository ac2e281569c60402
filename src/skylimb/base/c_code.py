"""CasADi functions as C."""

from __future__ import annotations

import functools

import casadi as ca


@functools.lru_cache(maxsize=16)
def c_source(function: ca.Function) -> str:
    """A CasADi function of scalars as a C file that needs nothing but libm and allocates nothing.

    The last ones are kept: a tick's is asked for before each of its flights, to see whether it is built, and
    writing it takes as long as flying it for a second or more.
    """
    generator = ca.CodeGenerator(f"{function.name()}.c", {"with_header": False})
    generator.add(function)
    return generator.dump()
