"""Calls into a user's own Python: an error there is one line that names the file and the line.

Every call of a user's function goes through `UserCode` or `guarded`. The error that comes out names the
deepest line of the traceback that stands in a user's own file, and the remedy where it is known. The whole
traceback hangs on it as its cause: `skylimb --debug` prints it.
"""

from __future__ import annotations

import functools
import inspect
import linecache
import re
import sys
import sysconfig
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any, Literal, NamedTuple, TypeVar

from skylimb.base.errors import SkylimbError, UserCodeError, did_you_mean, nearest

F = TypeVar("F", bound=Callable[..., Any])

_NOT_THE_USERS = (
    str(Path(__file__).parents[1]),
    *(sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")),
)
_LONGEST_LINE = 200
_PACKAGES = ("site-packages", "dist-packages")

_NO_FLOAT = "an SX is no float"

_REMEDIES = (
    (
        _NO_FLOAT,
        "float(), the functions of math and writing into a NumPy array need numbers, this is known only in "
        "flight; use skylimb.symbolic",
    ),
    (
        "truth value of a CasADi",
        "this is known only in flight: in place of if, and, or, not, min and max use "
        "skylimb.symbolic.where(condition, if_true, if_false)",
    ),
    (
        "to_int not defined|cannot be interpreted as an integer|must be integers or slices, not (SX|MX)",
        "an index or a count is needed before the flight; skylimb.symbolic.where chooses between values",
    ),
    (
        "Implicit conversion of symbolic",
        "NumPy arrays take no symbols: put entries together with vector, matrix, stack of skylimb.symbolic",
    ),
    ("not iterable by design", "take the entries by their index, as in x[0], x[1], x[2]"),
    (
        "incompatible dimensions|Dimension mismatch",
        "vectors are columns here: A @ v multiplies a matrix by one, skylimb.symbolic has dot and cross",
    ),
    ("does not support numpy|has no attribute", "skylimb.symbolic has the operations that can be compiled"),
)
"""What a message of CasADi's says, and what to do about it."""

_READ_ONLY = "what is given cannot be written to: work on a copy, as in `x = x + dx` in place of `x += dx`"


_RELATIVE = "files beside it are imported by their names, as in `from tools import filtered`, without a dot"

_SPEAK_FOR_THEMSELVES = (_NO_FLOAT, "truth value of a CasADi", "Implicit conversion of symbolic")
"""Messages in whose place the remedy alone is shown."""


class Place(NamedTuple):
    """A line of a user's file."""

    file: str
    line: int

    @property
    def source(self) -> str:
        """The line's text; empty where the file cannot be read."""
        linecache.checkcache(self.file)  # in a notebook a file is edited between two flights
        return linecache.getline(self.file, self.line).strip()

    def __str__(self) -> str:
        text = f", `{self.source[:_LONGEST_LINE]}`" if self.source else ""
        return f"{_short(self.file)}, line {self.line}{text}"


class UserCode:
    """Describes what goes wrong inside of the block, which calls a user's code.

    An error that skylimb's own checks raise, or that the user raises as a `SkylimbError`, passes as it is.

    Args:
        what: that is called, for example "translation law 'spring.py'".
        function: that is called, named where the error is in none of its lines, as of a wrong argument.
    """

    def __init__(self, what: str, function: Callable[..., Any] | None = None) -> None:
        self.what, self._function = what, function

    def __enter__(self) -> UserCode:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> Literal[False]:
        if isinstance(error, Exception | SystemExit):  # sys.exit is an error of theirs as well
            described_error = described_user_error(self.what, error, self._function)
            if described_error is not error:
                raise described_error from error
        return False


def guarded(function: F, what: str) -> F:
    """A user's function whose errors are described in one line; see `UserCode`."""

    @functools.wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        with UserCode(what, function):
            return function(*given, **named)

    return call  # type: ignore[return-value]  # the same signature


def returned(function: Callable[..., Any], *given: Any) -> tuple[Any, Place | None]:
    """What a user's function returns, and the line that returned it; None where it is nobody's file."""
    place: Place | None = None

    def watch(frame: FrameType, event: str, _: Any) -> None:
        nonlocal place
        if event == "return" and is_users(frame.f_code.co_filename):
            place = Place(frame.f_code.co_filename, frame.f_lineno)

    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        return function(*given), place
    finally:
        sys.setprofile(before)


def described_user_error(
    what: str, error: Exception | SystemExit, function: Callable[..., Any] | None = None
) -> Exception:
    """An error in a user's code in one line; the error itself where it says all already."""
    frames = _frames(error)
    place = next((place for place in reversed(frames) if is_users(place.file)), None)
    if isinstance(error, UserCodeError):
        return error
    if isinstance(error, SkylimbError) and (place is None or place == frames[-1]):
        return error
    code = getattr(inspect.unwrap(function), "__code__", None) if function and not place else None
    if code and is_users(code.co_filename):
        place = Place(code.co_filename, code.co_firstlineno)
    where = f" in {place}" if place else ""
    return UserCodeError(f"{what} fails{where}: {described(error)}")


def place_of(error: BaseException) -> Place | None:
    """The deepest line of a user's own file in which an error, or what caused it, was raised."""
    deepest = error.__cause__ or error
    frames = _frames(deepest) if isinstance(deepest, Exception) else []
    return next((place for place in reversed(frames) if is_users(place.file)), None)


def described(error: Exception | SystemExit) -> str:
    """What went wrong, in one line, with the remedy where it is known."""
    if isinstance(error, SkylimbError):
        return " ".join(str(error).split())
    # NumPy has words of its own for a symbol that is no float.
    error = error.__cause__ if str(error.__cause__) == _NO_FLOAT else error  # type: ignore[assignment]
    text = " ".join(str(error).split())
    if isinstance(error, SyntaxError):
        text = error.msg
    text = re.sub(r"^(Error in \S+ at )?\S*/casadi/\S+:\d+:\s*", "", text)
    symbols = "casadi" in str(error).lower() or re.search(r"\b(SX|MX|SXElem)\b", text)
    for pattern, remedy in _REMEDIES if symbols else ():
        if re.search(pattern, text):
            return remedy if pattern in _SPEAK_FOR_THEMSELVES else f"{text}; {remedy}"
    text = f"{text}; {_READ_ONLY}" if isinstance(error, ValueError) and "read-only" in text else text
    if isinstance(error, ImportError) and "relative import" in text:
        text = f"{text}; {_RELATIVE}"
    if isinstance(error, AttributeError):
        text += _other_attributes(error)
    return f"{type(error).__name__}: {text}".removesuffix(": ")


def _other_attributes(error: AttributeError) -> str:
    """The nearest attribute that is there, and all fields of a record; empty where the error says enough."""
    name, owner = error.name, error.obj
    if not name or owner is None or "did you mean" in str(error).lower():
        return ""
    fields = [known for known in getattr(owner, "_fields", ()) if isinstance(known, str)]
    near = nearest(name, fields) or nearest(name, [known for known in dir(owner) if known[:1] != "_"])
    return did_you_mean(near) + (f" (known: {', '.join(fields)})" if fields else "")


def is_users(file: str) -> bool:
    """Whether a file is a user's own: none of skylimb's, of Python's or of an installed package."""
    if file.startswith("<") and not file.startswith("<ipython"):
        return False
    return not file.startswith(_NOT_THE_USERS) and not any(name in Path(file).parts for name in _PACKAGES)


def _frames(error: BaseException) -> list[Place]:
    places = [Place(frame.filename, frame.lineno or 0) for frame in traceback.extract_tb(error.__traceback__)]
    if isinstance(error, SyntaxError) and error.filename:
        places.append(Place(error.filename, error.lineno or 0))
    return places


def _short(file: str) -> str:
    """The path from the working directory where the file lies in it."""
    path = Path(file)
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else file
