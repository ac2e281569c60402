"""How closely a flight has to do what it was commanded."""

from __future__ import annotations

from typing import Annotated

from skylimb.base.keys import Key, configuration


@configuration
class Tolerances:
    """Within which a finished contact flight counts as done as commanded, over its sliding period.

    They change nothing of a flight, only its verdict.
    """

    force: Annotated[
        float, Key("", "greatest mean error of the normal force, as a share of the commanded", 0.0, 10.0)
    ] = 0.10
    force_swing: Annotated[
        float,
        Key("", "greatest root mean square error of its 0.2 s mean, as a share of the commanded", 0.0, 10.0),
    ] = 0.30
    pen_line: Annotated[
        float, Key("m", "greatest root mean square distance of the pen from its reference line", 0.0, 10.0)
    ] = 0.020
    path: Annotated[
        float, Key("", "least share of the reference line that is drawn no farther than that", 0.0, 1.0)
    ] = 0.95
    frechet: Annotated[
        float, Key("m", "greatest Frechet distance of a drawing from its reference", 0.0, 10.0)
    ] = 0.020
    lifted: Annotated[
        float, Key("", "greatest share of the time of a drawing's lifts in touch", 0.0, 1.0)
    ] = 0.05
    valve: Annotated[
        float, Key("rad", "greatest turn that a valve lacks of its second stop in the end", 0.0, 6.3)
    ] = 0.0175
    peg: Annotated[
        float, Key("m", "greatest distance of a peg's end from the floor of its hole", 0.0, 1.0)
    ] = 0.001
    foot: Annotated[float, Key("rad", "greatest mean angle between a foot and its surface", 0.0, 3.2)] = (
        0.0175
    )
    contact: Annotated[float, Key("", "least share of the time in touch", 0.0, 1.0)] = 0.95
