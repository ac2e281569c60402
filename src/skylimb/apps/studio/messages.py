"""What a page may say: each command's fields, types and ranges, checked before anything happens."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from skylimb.apps.studio.beside import MOST_FLIGHTS
from skylimb.base.errors import ConfigError

LONGEST = 600_000
"""Bytes of the longest message, a drawing."""

_MOST_POINTS = 20_000
"""Of all strokes of a drawing together."""

Metres = Annotated[float, Meta(ge=-100.0, le=100.0)]
Newtons = Annotated[float, Meta(ge=-50.0, le=50.0)]
Tilt = Annotated[float, Meta(ge=-1.4, le=1.4)]
KeyName = Annotated[str, Meta(min_length=1, max_length=120, pattern=r"^[A-Za-z0-9_.\-]+$")]
ControllerName = Annotated[str, Meta(min_length=1, max_length=200)]
FlightNumber = Annotated[int, Meta(ge=0, lt=MOST_FLIGHTS)]
Number = Annotated[float, Meta(ge=-1e12, le=1e12)]
Whole = Annotated[int, Meta(ge=-(2**63), le=2**63 - 1)]
Words = Annotated[str, Meta(max_length=400)]
Row = Annotated[list[Number], Meta(max_length=64)]
Value = bool | Whole | Number | Words | None | Annotated[list[Number | Row], Meta(max_length=200)]
"""Of a key: a switch, a number, a text, a vector, a list of points, or none."""


class Command(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="do", kw_only=True):
    """What one page wants done.

    Attributes:
        seen: version of the state that the page saw; one that is not given is not compared.
    """

    seen: Whole | None = None


class Pause(Command, tag="pause", frozen=True):
    """Hold the flight, or let it go on."""

    paused: bool


class Speed(Command, tag="speed", frozen=True):
    """Times the real speed."""

    times: Annotated[float, Meta(ge=0.1, le=20.0)]


class Step(Command, tag="step", frozen=True):
    """Fly one tick of a flight that is paused."""


class Restart(Command, tag="restart", frozen=True):
    """Take off again."""


class Change(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a key of the experiment, or a gain of one flight or of all that have it, is to be.

    Attributes:
        entry: the one that is meant, of a vector; the others stay.
    """

    key: KeyName
    value: Value
    flight: FlightNumber | None = None
    entry: Annotated[int, Meta(ge=0, le=63)] | None = None


class Rewind(Command, tag="rewind", frozen=True):
    """Go back to a time (s) and fly on from there, with changes that act from then on."""

    time: Annotated[float, Meta(ge=0.0, le=1e5)]
    changes: Annotated[list[Change], Meta(max_length=200)] = []


class Undo(Command, tag="undo", frozen=True):
    """Go back to the moment before the last act."""


class Redo(Command, tag="redo", frozen=True):
    """Go to where the flight was when the last act was undone."""


class Jump(Command, tag="jump", frozen=True):
    """Go to where another branch was left."""

    branch: Whole


class Set(Command, tag="set", frozen=True):
    """Change a key of the experiment, or a gain of one flight or of all that have it; whole, or one entry."""

    key: KeyName
    value: Value
    flight: FlightNumber | None = None
    entry: Annotated[int, Meta(ge=0, le=63)] | None = None


class Back(Command, tag="back", frozen=True):
    """Bring a key, or all, back to what it was at take-off, or before anybody changed it."""

    to: Literal["take-off", "preset"]
    key: KeyName | None = None


class Recover(Command, tag="recover", frozen=True):
    """Take off again with the last gains that flew well."""


class Poke(Command, tag="poke", frozen=True):
    """Push a link: at a point (m, the link's axes) with a force (N, W), until it changes or is released."""

    link: Annotated[str, Meta(min_length=1, max_length=80)]
    point: tuple[Metres, Metres, Metres]
    force: tuple[Newtons, Newtons, Newtons]


class Release(Command, tag="release", frozen=True):
    """Push no more."""


class Surface(Command, tag="surface", frozen=True):
    """Change the surface: where it is and how it's tilted, from take-off (m, W; rad); what it's made of.

    What is null stays as it is.
    """

    position: tuple[Metres | None, Metres | None, Metres | None] | None = None
    tilt: tuple[Tilt | None, Tilt | None] | None = None
    friction: Annotated[float, Meta(ge=0.0, le=5.0)] | None = None
    stiffness: Annotated[float, Meta(ge=50.0, le=1e6)] | None = None
    present: bool | None = None


class Controllers(Command, tag="controllers", frozen=True):
    """Fly one controller, or two beside each other."""

    names: Annotated[list[ControllerName], Meta(min_length=1, max_length=MOST_FLIGHTS)]


class Keep(Command, tag="keep", frozen=True):
    """Write what was flown so far."""

    name: Words = ""


class Draw(Command, tag="draw", frozen=True):
    """Draw strokes, (u, v) in m on the surface, or an SVG (its text, and its file's name), or words.

    The flight takes off again with it.
    """

    strokes: Annotated[list[list[tuple[Metres, Metres]]], Meta(max_length=400)] | None = None
    svg: Annotated[str, Meta(max_length=LONGEST)] | None = None
    name: Annotated[str, Meta(max_length=200)] = "drawing.svg"
    text: Annotated[str, Meta(min_length=1, max_length=400)] | None = None
    font: Annotated[str, Meta(max_length=40)] = ""


class Scores(Command, tag="scores", frozen=True):
    """Score the flight so far."""


class TakeOver(Command, tag="take over", frozen=True):
    """Drive; the page that drove watches."""


class Got(Command, tag="got", frozen=True):
    """The page has shown a frame, and may be sent the next."""

    frame: Annotated[int, Meta(ge=0, le=2**32 - 1)]


Commands = (
    Pause | Speed | Step | Restart | Rewind | Undo | Redo | Jump | Set | Back | Recover | Poke | Release
    | Surface | Controllers | Keep | Draw | Scores | TakeOver | Got
)  # fmt: skip

OF_A_STATE = (Rewind, Jump, Set, Back, Surface)
"""What a page means for the flight that it sees: refused where the flight has become another meanwhile.

Undo is not: who presses twice means both.
"""

_DECODER = msgspec.json.Decoder(Commands)


def read_command(message: str | bytes) -> Any:
    """The command in a message.

    Raises:
        ConfigError: when it is none, or one of its values has a wrong type or is out of range.
    """
    if not isinstance(message, str):
        raise ConfigError("a page's message must be text")
    try:
        command = _DECODER.decode(message)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise ConfigError(f"a page's message is refused: {str(error)[:200]}") from None
    if isinstance(command, Draw):
        _check_drawing(command)
    return command


def _check_drawing(command: Draw) -> None:
    if sum(one is not None for one in (command.strokes, command.svg, command.text)) != 1:
        raise ConfigError("a drawing is either strokes, or an SVG, or words")
    if command.strokes is not None and sum(map(len, command.strokes)) > _MOST_POINTS:
        raise ConfigError(f"a drawing has at most {_MOST_POINTS} points")
