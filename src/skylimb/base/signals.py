"""What a signal of a law or a controller is, as its author declares it beside the step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from skylimb.base.errors import ConfigError, UserCodeError, unknown_name
from skylimb.base.signal_table import SIGNALS, Kind


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
    kind: Kind = "estimate"


_OF_THE_LOG = {
    "time", "axis", "quaternion", "rotor", "joint", "vectoring", "unrolled", "configuration_velocity",
    "thrusts_command", "joint_angles_command", "vectoring_angles_command",
}  # fmt: skip
"""The log's axes, the command, and what the log does not keep."""
_OF_LAWS = "estimate", "command"
FORCE_REFERENCE = "contact_force_reference"
"""What a law that presses records besides: the force that it takes for commanded."""
FORCE_COMMANDED = "contact_force_commanded"
"""What the experiment commands; the loop records it, and no law may."""
_LONGEST = 100


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


def require_free(recorded: Mapping[str, Any], what: str) -> None:
    """Raise a `UserCodeError` where a law or a controller records what is not its own.

    Its signals may be estimates and commands that everybody knows, or have names of their own. Truth,
    measurements, the mission's references and the command itself are the loop's.
    """
    for name, value in recorded.items():
        known, shape = SIGNALS.get(name), np.shape(value)
        if name in _OF_THE_LOG or not (known is None or known.kind in _OF_LAWS or name == FORCE_REFERENCE):
            raise UserCodeError(
                f"{what} records '{name}', a name that the loop records itself; choose another"
            )
        if not name.isidentifier() or len(name) > _LONGEST:
            raise UserCodeError(
                f"{what} records '{name[:_LONGEST]}'; the name of a signal is at most {_LONGEST} letters, "
                "digits and _"
            )
        if known and (shape != (3,) if known.dims == ("axis",) else len(shape) != len(known.dims)):
            raise UserCodeError(
                f"{what} records '{name}' with the shape {shape}; that is the name of '{known.long_name}', "
                f"{f'one for each {known.dims[0]}' if known.dims else 'a number'}"
            )
