"""Configuration keys: default, unit, range and meaning of a value, written in one place.

A configuration is a frozen dataclass whose fields carry a `Key`:

    @configuration
    class ApproachConfig:
        '''How the robot comes to the surface and leaves it.'''

        depth: Annotated[float, Key("m", "how far beyond the surface the tip aims", low=0.0, high=0.6)] = 0.18

The annotation is read by the check at construction, by `keys_of` and `described` (for tables, sliders and
logs), and by the reader of TOML files, `skylimb.base.config`. A check that needs several keys goes into a
method `check` of the class; it is called after the keys are checked, and raises what `refused` returns.
"""

from skylimb.base.keys.checks import RefusedError, choice_problem
from skylimb.base.keys.configuration import configuration, is_configuration, refused
from skylimb.base.keys.key import Key, Vector3
from skylimb.base.keys.listing import (
    ANY_NAME,
    ANY_NUMBER,
    REQUIRED,
    KeyInfo,
    Table,
    brief,
    described,
    files_of,
    keys_of,
    rows_of,
    summary,
    tables_of,
    units_of,
)

__all__ = [
    "ANY_NAME",
    "ANY_NUMBER",
    "REQUIRED",
    "Key",
    "KeyInfo",
    "RefusedError",
    "Table",
    "Vector3",
    "brief",
    "choice_problem",
    "configuration",
    "described",
    "files_of",
    "is_configuration",
    "keys_of",
    "refused",
    "rows_of",
    "summary",
    "tables_of",
    "units_of",
]
