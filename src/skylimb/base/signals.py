"""What a signal of a law or a controller is, as its author declares it beside the step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from skylimb.base.errors import ConfigError, unknown_name


@dataclass(frozen=True)
class Signal:
    """What a signal is; the log keeps it beside the values.

        SIGNALS = {"spring_force": Signal("N", "W", "pull of the spring")}

    Attributes:
        unit: SI, empty for a pure number.
        frame: in which a vector stands: "W" (world), "C" (hovering frame) or "root"; empty for none.
        meaning: a few words.
        kind: truth, estimate, reference, command or measurement.
    """

    unit: str = ""
    frame: str = ""
    meaning: str = "signal of the controller's own"
    kind: Literal["truth", "estimate", "reference", "command", "measurement"] = "estimate"


def declared_signals(owner: Any, what: str) -> dict[str, Signal]:
    """The signals that a user's law or controller declares as `SIGNALS`; none where it declares nothing.

    Raises:
        ConfigError: when `SIGNALS` is no table of `Signal`s.
    """
    found = getattr(owner, "SIGNALS", {})
    if not isinstance(found, Mapping) or not all(isinstance(one, Signal) for one in found.values()):
        raise ConfigError(f'{what}: SIGNALS should be a table such as {{"pull": skylimb.Signal("N", "W")}}')
    return dict(found)


def require_recorded(declared: Mapping[str, Signal], recorded: Mapping[str, Any], what: str) -> None:
    """Raise an `UnknownNameError` unless every declared signal is recorded."""
    for name in declared:
        if name not in recorded:
            raise unknown_name(f"signal in SIGNALS of {what}", name, recorded)
