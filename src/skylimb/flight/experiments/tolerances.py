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
    force_spread: Annotated[
        float,
        Key(
            "",
            "greatest standard deviation of the error of its 5 ms mean, as a share of the commanded",
            0.0,
            10.0,
        ),
    ] = 0.5
    force_peak: Annotated[
        float,
        Key("", "greatest excess of its 10 ms mean, in times of the commanded", 0.0, 1e3),
    ] = 4.0
    of_size: Annotated[
        float,
        Key(
            "",
            "share of its size that a line may be off, root mean square, within the next two: of the whole "
            "drawing's for its place, of the corner's or bow's at hand for its shape",
            above=0.0,
            high=1e3,
        ),
    ] = 0.05
    finest: Annotated[
        float, Key("m", "what is allowed of that however small the line is", above=0.0, high=10.0)
    ] = 0.001
    pen_line: Annotated[
        float, Key("m", "what is allowed of that however large the line is", above=0.0, high=10.0)
    ] = 0.020
    frechet: Annotated[
        float,
        Key(
            "m",
            "greatest Frechet distance of a stroke from its shape; less where its size allows less",
            above=0.0,
            high=10.0,
        ),
    ] = 0.020
    marks: Annotated[
        float,
        Key(
            "m",
            "farthest mark of touching down and leaving; less where the drawing's size allows less",
            0,
            10,
        ),
    ] = 0.050
    longer: Annotated[
        float,
        Key(
            "",
            "share by which what is drawn of a stroke may be longer than it, besides eight times `finest`",
            0.0,
            1e3,
        ),
    ] = 0.10
    behind: Annotated[
        float,
        Key(
            "m",
            "greatest distance of the pen from where it should be at each moment, but for 5 % of the time; "
            "less where the size of its strokes allows less",
            0.0,
            10.0,
        ),
    ] = 0.100
    path: Annotated[
        float,
        Key("", "least share of the reference line that is drawn within what its shape allows", 0.0, 1.0),
    ] = 0.95
    strokes: Annotated[
        float, Key("", "greatest number of strokes that are not drawn, or miss their shape", 0.0, 1e4)
    ] = 0.0
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
    clearance: Annotated[
        float,
        Key(
            "m", "least distance of rotors' discs and bodies, but for the tool, from the surface", -10.0, 10.0
        ),
    ] = 0.0
