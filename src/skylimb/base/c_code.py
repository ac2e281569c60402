"""CasADi functions as C."""

from __future__ import annotations

import casadi as ca


def c_source(function: ca.Function) -> str:
    """A CasADi function of scalars as a C file that needs nothing but libm and allocates nothing."""
    generator = ca.CodeGenerator(f"{function.name()}.c", {"with_header": False})
    generator.add(function)
    return generator.dump()
