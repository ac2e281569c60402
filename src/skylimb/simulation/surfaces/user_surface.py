"""A surface of the user's own: one Python file, which `surface.kind` names.

    # saddle.py
    def height(u, v, keys):
        '''How far the surface recedes from its flat plane, m.'''
        return 0.5 * keys.bend * (u * u - v * v)

`height` serves a surface that is the graph of a smooth function. Any other one is given by
`closest(point, keys)`: the surface's point that is closest to a point (w, u, v), and the outward unit normal
there. Both are written with plain operators and `skylimb.symbolic`. `Keys`, a frozen dataclass where there is
one, has the keys that stand beside the others in the table `[surface]`.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.config import from_mapping, to_mapping
from skylimb.base.errors import UserCodeError
from skylimb.base.keys import Key, configuration
from skylimb.base.keys.fields import fields_of
from skylimb.base.keys.settings import settings_class
from skylimb.base.packing import Layout
from skylimb.base.sources import Source, read_source
from skylimb.base.user_code import UserCode
from skylimb.base.user_modules import load_module, sources_of_module
from skylimb.control.laws.user_functions import traceable
from skylimb.simulation.surfaces.curved import CurvedSurface
from skylimb.simulation.surfaces.graph import SAMPLES, Formula, arc_length, tightest_hollow
from skylimb.simulation.surfaces.shape import NativeShape, c_of_touch, meeting
from skylimb.simulation.surfaces.user_checks import require_closest, require_smooth
from skylimb.symbolic import is_symbolic

_ANY = Key("", "a key of this surface", low=-math.inf, high=math.inf)


@configuration
class UserSurface(CurvedSurface):
    """A surface of your own: a Python file with `height(u, v, keys)` or `closest(point, keys)`."""

    kind: Annotated[str, Key("", "the Python file", file=True)] = ""
    module: ClassVar[ModuleType]
    curved_along_v: ClassVar[bool] = True

    def check(self) -> None:
        """Refuse a file that gives no smooth surface within `size`."""
        super().check()
        shape, half = self.shape, (0.5 * self.size[0], 0.5 * self.size[1])
        if isinstance(shape, Formula):
            self._require_lasting(shape.function)
            require_smooth(self._what, shape.function, shape.numbers, half)
        elif isinstance(shape, _Closest):
            self._require_lasting(shape.function)
            require_closest(self._what, shape.function, shape.numbers, half)

    def _require_lasting(self, function: ca.Function) -> None:
        """Refuse a file that gives another surface when it is asked again."""
        again, rng = self.make_shape().function, np.random.default_rng(0)
        given = [rng.uniform(0.1, 1.0, function.size_in(k)) for k in range(function.n_in())]
        one, other = (made.call(given)[0].full() for made in (function, again))
        if not np.array_equal(one, other, equal_nan=True):
            raise UserCodeError(
                f"{self._what} is another one when its function is called again: it remembers nothing, and "
                "draws no random numbers; draw them above the function, with a seed"
            )

    @property
    def _what(self) -> str:
        return f"surface '{Path(self.kind).name}'"

    @property
    def sources(self) -> tuple[Source, ...]:
        """The file, and what it imports from its folder, as they were read."""
        return sources_of_module(self.module)

    @cached_property
    def keys(self) -> Any:
        """What the file's functions are handed as `keys`."""
        cls = getattr(self.module, "Keys", None)
        if cls is None:
            return ()
        with UserCode(self._what):
            return cls(**{name: getattr(self, name) for name in fields_of(cls)})

    def make_shape(self) -> Formula | _Closest:
        """The file's function in symbols."""
        what, half = self._what, (0.5 * self.size[0], 0.5 * self.size[1])
        if not hasattr(self.module, "height"):
            return _Closest(_called(self.module.closest, what, "foot and normal", (3, 3)), self.keys, half)
        height = _called(self.module.height, what, "one number", (1,))
        return Formula(lambda *given: height(*given)[0], self.keys, half)

    def describe(self) -> dict[str, Any]:
        """As every curved surface's, with the file's name as its kind."""
        return super().describe() | {"kind": Path(self.kind).name}

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (to_mapping(self, keep_none=True),)


def user_surface(file: str) -> type[UserSurface]:
    """The kind of surface that a Python file makes; the same one as long as its files are the same.

    Raises:
        ConfigError: when the file is missing, fails, or says nothing of a surface.
    """
    read_source(file)  # which names the nearest file where there is none
    module = load_module(Path(file), ())
    if hasattr(module, "height") == hasattr(module, "closest"):
        both = "both" if hasattr(module, "height") else "neither"
        raise UserCodeError(
            f"surface '{file}' should define height(u, v, keys) or closest(point, keys); it has {both}"
        )
    return _kind(module, f"surface '{Path(file).name}'")


@functools.lru_cache(maxsize=64)
def _kind(module: ModuleType, what: str) -> type[UserSurface]:
    """Every surface's keys and those of the module's `Keys` in one configuration."""
    members: dict[str, Any] = {"module": module, "__module__": __name__, "__annotations__": {}}
    members["__doc__"] = module.__doc__
    with UserCode(what):
        keys = getattr(module, "Keys", None)
        fields = () if keys is None else dataclasses.fields(settings_class(keys, "Keys", what))
        for field in (field for field in fields if field.init):
            if hasattr(UserSurface, field.name):
                raise UserCodeError(f"{what}: every surface has '{field.name}': give this key another name")
            kind, key = fields_of(keys)[field.name]
            members["__annotations__"][field.name] = Annotated[kind, key or _ANY]
            members[field.name] = dataclasses.field(
                default=field.default, default_factory=field.default_factory, kw_only=True
            )
        return configuration(type("UserSurface", (UserSurface,), members))


def _again(mapping: dict[str, Any]) -> UserSurface:
    return from_mapping(user_surface(mapping["kind"]), mapping, "surface")


def _called(function: Any, what: str, wanted: str, sizes: tuple[int, ...]) -> Any:
    """A user's function that gives vectors of these sizes in symbols, each error in a line."""

    def parts(*given: Any) -> dict[str, Any]:
        found = function(*given)
        found = found if isinstance(found, tuple | list) else (found,)
        columns = [ca.vec(part if is_symbolic(part) else ca.SX(np.asarray(part, float))) for part in found]
        shown = [part.numel() for part in columns]
        if shown != list(sizes):
            raise UserCodeError(
                f"{what}: {function.__name__} should return {wanted}, of {' and '.join(map(str, sizes))}; it "
                f"returned {' and '.join(map(str, shown))}"
            )
        return {function.__name__: ca.vertcat(*columns)}

    return lambda *given: ca.vertsplit(next(iter(traceable(parts, what)(*given).values())))


class _Closest(NativeShape):
    """A shape whose closest point is written in symbols.

    Args:
        closest: (point, keys) -> foot and normal as six symbols.
        keys: a record of the numbers in it.
        half_extent: half of what is looked at along u and v, m.
    """

    def __init__(self, closest: Any, keys: Any, half_extent: tuple[float, float]) -> None:
        layout = Layout(keys)
        p, point = ca.SX.sym("numbers", layout.size), ca.SX.sym("point", 3)
        found = ca.vertcat(*closest(point, layout.unpack(p)))
        foot, normal = found[:3], found[3:]
        touch = ca.vertcat(normal, ca.dot(point - foot, normal))
        self.function = ca.Function("shape", [p, point], [ca.densify(touch)], {"cse": True})
        self._numbers, self._half = layout.pack(keys), half_extent

    @property
    def numbers(self) -> np.ndarray:
        return self._numbers

    @property
    def source(self) -> str:
        return c_of_touch(self.function)

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """Where a ray along w meets it, m."""
        u, v = np.broadcast_arrays(np.asarray(u, dtype=float), np.asarray(v, dtype=float))
        return meeting(
            self.closest, lambda w: np.stack([w, u, v], axis=-1), np.array([1.0, 0.0, 0.0]), u.shape
        )

    def unrolled(self, u: ArrayLike) -> np.ndarray:
        grid = np.linspace(-self._half[0], self._half[0], SAMPLES)
        steps = np.hypot(np.diff(grid), np.diff(self.height(grid, 0.0)))
        return arc_length(u, grid, np.nan_to_num(steps))

    @property
    def tightest_hollow(self) -> float:
        """Smallest radius of a hollow, m, by differences on a dense sample."""
        u, v = (np.linspace(-half, half, 401) for half in self._half)
        h = self.height(u[:, None], v)
        hu, hv = np.gradient(h, u, v)
        (huu, huv), hvv = np.gradient(hu, u, v), np.gradient(hv, v, axis=1)
        return tightest_hollow(np.stack([h, hu, hv, huu, huv, hvv]))
