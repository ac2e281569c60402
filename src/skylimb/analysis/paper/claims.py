"""Every sentence of the paper's results section as a formula over numbers of its four controllers.

A formula judges one comparison: the four controllers over the same flight. It knows nothing of where the
numbers come from, so that one comparison and an ensemble of them are judged alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

Values = Mapping[str, Mapping[str, float]]
"""Controller -> metric or measure -> number."""

NEARLY_A_CIRCLE = 0.10
"""Departure from its best circle, over the radius, up to which a trace passes for nearly circular; ours."""

SIMILAR = 0.10
"""Relative difference up to which two displacements pass for similar; ours (the paper's differ by 3 %)."""

PID, IMPEDANCE, ADMITTANCE, HYBRID = "pid", "impedance", "admittance", "hybrid"
ALL = (PID, IMPEDANCE, ADMITTANCE, HYBRID)

ERROR, DISPLACEMENT, FORCE = "error_u_median", "displacement_median", "estimated_force_median"


@dataclass(frozen=True)
class PaperClaim:
    """A sentence and what it comes to.

    Attributes:
        name: short name.
        section: where it stands: "traces", "sliding", "contact" or "discussion".
        text: what is claimed, in our words.
        formula: the same in symbols; letters are p, i, a, h for the four controllers.
        controllers: what it is about: the paper's flights under these controllers, which must have finished.
        keys: metrics and measures that it needs.
        holds: whether it is true of some numbers.
    """

    name: str
    section: str
    text: str
    formula: str
    controllers: tuple[str, ...]
    keys: tuple[str, ...]
    holds: Callable[[Values], bool]


Condition = Callable[[Values], bool]


def _smaller(key: str, these: tuple[str, ...], than: tuple[str, ...]) -> Condition:
    """Whether the largest of some is below the smallest of others, in magnitude."""
    return lambda values: (
        max(abs(values[name][key]) for name in these) < min(abs(values[name][key]) for name in than)
    )


def _ordered(key: str, names: tuple[str, ...]) -> Condition:
    """Whether magnitudes rise strictly in this order."""
    return lambda values: all(abs(values[low][key]) < abs(values[high][key]) for low, high in pairwise(names))


def _similar(values: Values) -> bool:
    """Whether PID and impedance alone displace the body alike."""
    pid, impedance = (values[name][DISPLACEMENT] for name in (PID, IMPEDANCE))
    return abs(pid - impedance) <= SIMILAR * max(pid, impedance)


def _all(*conditions: Condition) -> Condition:
    """Whether several conditions hold at once."""
    return lambda values: all(holds(values) for holds in conditions)


CLAIMS: dict[str, PaperClaim] = {
    claim.name: claim
    for claim in (
        PaperClaim(
            "impedance traces best",
            "traces",
            "Of the four traces that of impedance alone lies nearest the desired circle.",
            "distance_i < min(distance_p, distance_a, distance_h)",
            ALL,
            ("trace_distance",),
            _smaller("trace_distance", (IMPEDANCE,), (PID, ADMITTANCE, HYBRID)),
        ),
        PaperClaim(
            "hybrid traces a circle",
            "traces",
            "The hybrid's trace is nearly circular.",
            f"distortion_h <= {NEARLY_A_CIRCLE:g}",
            (HYBRID,),
            ("trace_distortion",),
            lambda values: values[HYBRID]["trace_distortion"] <= NEARLY_A_CIRCLE,
        ),
        PaperClaim(
            "PID and admittance trace smaller",
            "traces",
            "The traces of PID and of admittance alone are smaller than the other two.",
            "max(size_p, size_a) < min(size_i, size_h)",
            ALL,
            ("trace_size",),
            _smaller("trace_size", (PID, ADMITTANCE), (IMPEDANCE, HYBRID)),
        ),
        PaperClaim(
            "PID and admittance trace distorted",
            "traces",
            "The traces of PID and of admittance alone are more distorted than the other two.",
            "min(distortion_p, distortion_a) > max(distortion_i, distortion_h)",
            ALL,
            ("trace_distortion",),
            _smaller("trace_distortion", (IMPEDANCE, HYBRID), (PID, ADMITTANCE)),
        ),
        PaperClaim(
            "arm adapts",
            "traces",
            "Under the hybrid the arm deforms with the board: its reach moves more than a stiff arm's.",
            "reach_h > reach_i",
            (IMPEDANCE, HYBRID),
            ("reach_span",),
            _smaller("reach_span", (IMPEDANCE,), (HYBRID,)),
        ),
        PaperClaim(
            "impedance resists friction",
            "sliding",
            "Impedance-based control follows more accurately than PID when sliding under friction: impedance "
            "and hybrid have smaller y errors.",
            "max(y_i, y_h) < y_p",
            (PID, IMPEDANCE, HYBRID),
            (ERROR,),
            _smaller(ERROR, (IMPEDANCE, HYBRID), (PID,)),
        ),
        PaperClaim(
            "order of the y errors",
            "sliding",
            "The y errors rise from impedance over hybrid and admittance to PID.",
            "y_i < y_h < y_a < y_p",
            ALL,
            (ERROR,),
            _ordered(ERROR, (IMPEDANCE, HYBRID, ADMITTANCE, PID)),
        ),
        PaperClaim(
            "impedance is steadier",
            "sliding",
            "Impedance-based control is steadier than PID: its y errors spread less.",
            "max(spread of |y|_i, |y|_h) < spread of |y|_p",
            (PID, IMPEDANCE, HYBRID),
            ("error_u_spread",),
            _smaller("error_u_spread", (IMPEDANCE, HYBRID), (PID,)),
        ),
        PaperClaim(
            "stiff arms move alike",
            "contact",
            "PID and impedance alone have similar displacements in x.",
            f"|x_p - x_i| <= {SIMILAR:g} max(x_p, x_i)",
            (PID, IMPEDANCE),
            (DISPLACEMENT,),
            _similar,
        ),
        PaperClaim(
            "admittance keeps the body",
            "contact",
            "Both controllers with an adapting arm displace the body less in x than both with a stiff one.",
            "max(x_a, x_h) < min(x_p, x_i)",
            ALL,
            (DISPLACEMENT,),
            _smaller(DISPLACEMENT, (ADMITTANCE, HYBRID), (PID, IMPEDANCE)),
        ),
        PaperClaim(
            "hybrid below impedance in x",
            "contact",
            "The hybrid displaces the body less than impedance alone (springs in series: 0.61 times).",
            "x_h < x_i",
            (IMPEDANCE, HYBRID),
            (DISPLACEMENT,),
            _smaller(DISPLACEMENT, (HYBRID,), (IMPEDANCE,)),
        ),
        PaperClaim(
            "admittance below PID in x",
            "contact",
            "Admittance alone displaces the body less than PID.",
            "x_a < x_p",
            (PID, ADMITTANCE),
            (DISPLACEMENT,),
            _smaller(DISPLACEMENT, (ADMITTANCE,), (PID,)),
        ),
        PaperClaim(
            "hybrid pushed least",
            "contact",
            "The hybrid meets the smallest median force of the four.",
            "|f_h| < min(|f_p|, |f_i|, |f_a|)",
            ALL,
            (FORCE,),
            _smaller(FORCE, (HYBRID,), (PID, IMPEDANCE, ADMITTANCE)),
        ),
        PaperClaim(
            "order of the forces",
            "contact",
            "The forces rise from hybrid over impedance and admittance to PID.",
            "|f_h| < |f_i| < |f_a| < |f_p|",
            ALL,
            (FORCE,),
            _ordered(FORCE, (HYBRID, IMPEDANCE, ADMITTANCE, PID)),
        ),
        PaperClaim(
            "admittance narrows the force",
            "contact",
            "Admittance and hybrid have narrower distributions of the force than PID.",
            "max(spread of f_a, f_h) < spread of f_p",
            (PID, ADMITTANCE, HYBRID),
            ("estimated_force_spread",),
            _smaller("estimated_force_spread", (ADMITTANCE, HYBRID), (PID,)),
        ),
        PaperClaim(
            "admittance softens the contact",
            "contact",
            "An adapting arm lowers the contact force: admittance below PID, hybrid below impedance.",
            "|f_a| < |f_p| and |f_h| < |f_i|",
            ALL,
            (FORCE,),
            _all(_smaller(FORCE, (ADMITTANCE,), (PID,)), _smaller(FORCE, (HYBRID,), (IMPEDANCE,))),
        ),
        PaperClaim(
            "impedance slides smoothly",
            "discussion",
            "Impedance control makes the sliding smoother: the pen's speed varies less than under PID.",
            "max(variation_i, variation_h) < variation_p",
            (PID, IMPEDANCE, HYBRID),
            ("slip_variation",),
            _smaller("slip_variation", (IMPEDANCE, HYBRID), (PID,)),
        ),
        PaperClaim(
            "hybrid wins at once",
            "discussion",
            "The hybrid has a smaller y error, a smaller displacement and a smaller force than PID at once.",
            "y_h < y_p and x_h < x_p and |f_h| < |f_p|",
            (PID, HYBRID),
            (ERROR, DISPLACEMENT, FORCE),
            _all(*(_smaller(key, (HYBRID,), (PID,)) for key in (ERROR, DISPLACEMENT, FORCE))),
        ),
    )
}
"""By name, in the paper's order."""
