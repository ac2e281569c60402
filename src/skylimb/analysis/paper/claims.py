"""What the paper claims of its four controllers, held against a set of runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from skylimb.analysis.paper.paper_claims import CLAIMS
from skylimb.analysis.paper.paper_configuration import is_the_papers
from skylimb.analysis.paper.paper_numbers import PUBLISHED
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.shipped import measured


@dataclass(frozen=True)
class Claim:
    """A statement of the paper's with its numbers and ours.

    Attributes:
        text: the statement.
        paper: what the paper prints for it.
        ours: the same from the runs.
        holds: whether it is true of the runs.
    """

    text: str
    paper: str
    ours: str
    holds: bool


Judge = Callable[[Mapping[str, Run]], Claim]


def check_claims(runs: Mapping[str, Run]) -> list[Claim]:
    """Check the claims that these runs allow to check.

    A claim is about flights of the paper's configuration by the controllers that it names. It needs one of
    each that finished.

    Args:
        runs: by name; of two runs with the same controller the first counts.

    Returns:
        The claims that could be judged, in the paper's order.
    """
    flown: dict[str, Run] = {}
    for run in runs.values():
        if not run.failed and is_the_papers(run):
            flown.setdefault(run.controller, run)
    found: list[Claim] = []
    for name, judge in _JUDGES.items():
        if set(CLAIMS[name].controllers) <= set(flown):
            claim = judge(flown)
            found.append(replace(claim, paper=_true_minus(claim.paper), ours=_true_minus(claim.ours)))
    return found


def _true_minus(text: str) -> str:
    return text.replace("-", "\u2212")


def _metric(flown: Mapping[str, Run], controller: str, key: str) -> float:
    return _number(flown[controller].metrics.get(key))


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _friction(flown: Mapping[str, Run]) -> Claim:
    key = "error_u_median"
    ours = {name: _metric(flown, name, key) for name in ("impedance", "hybrid", "pid")}
    printed = {name: PUBLISHED[name].error_u_median for name in ours}
    return Claim(
        "Impedance control along the sliding directions resists friction: under impedance and hybrid the "
        "error in y is smaller than under PID.",
        " and ".join(f"{printed[name]:.3f}" for name in ("impedance", "hybrid"))
        + f" against {printed['pid']:.3f} m",
        " and ".join(f"{ours[name]:.3f}" for name in ("impedance", "hybrid"))
        + f" against {ours['pid']:.3f} m",
        _holds("impedance resists friction", "error_u_median", ours),
    )


def _holds(name: str, key: str, column: Mapping[str, float]) -> bool:
    """What the formula of a claim says of one number a controller."""
    return CLAIMS[name].holds({controller: {key: value} for controller, value in column.items()})


def _ratio(name: str, adaptive: str, stiff: str, text: str) -> Judge:
    def judge(flown: Mapping[str, Run]) -> Claim:
        ours = [_metric(flown, controller, "displacement_median") for controller in (adaptive, stiff)]
        printed = [PUBLISHED[controller].displacement_median for controller in (adaptive, stiff)]
        ratio = ours[0] / ours[1] if ours[1] else float("nan")
        return Claim(
            text,
            f"{printed[0]:.3f} / {printed[1]:.3f} m = {printed[0] / printed[1]:.2f}",
            f"{ours[0]:.3f} / {ours[1]:.3f} m = {ratio:.2f}",
            _holds(name, "displacement_median", dict(zip((adaptive, stiff), ours, strict=True))),
        )

    return judge


def _smallest_force(flown: Mapping[str, Run]) -> Claim:
    ours = {name: _metric(flown, name, "estimated_force_median") for name in PUBLISHED}
    others = ", ".join(f"{ours[name]:.2f}" for name in PUBLISHED if name != "hybrid")
    printed = ", ".join(
        f"{PUBLISHED[name].estimated_force_median:.2f}" for name in PUBLISHED if name != "hybrid"
    )
    return Claim(
        "The hybrid controller meets the smallest force of the four (median estimate in x).",
        f"{PUBLISHED['hybrid'].estimated_force_median:.2f} against {printed} N",
        f"{ours['hybrid']:.2f} against {others} N",
        _holds("hybrid pushed least", "estimated_force_median", ours),
    )


def _narrower_force(flown: Mapping[str, Run]) -> Claim:
    key = "estimated_force_spread"
    spread = {
        name: _number(measured(flown[name], ["paper"])[key]) for name in ("pid", "admittance", "hybrid")
    }
    return Claim(
        "An adapting arm narrows the distribution of the estimated force (distance between its quartiles) "
        "compared with PID.",
        "shown in a box plot, no number",
        f"{spread['admittance']:.2f} and {spread['hybrid']:.2f} against {spread['pid']:.2f} N",
        _holds("admittance narrows the force", key, spread),
    )


_JUDGES: dict[str, Judge] = {
    "impedance resists friction": _friction,
    "hybrid below impedance in x": _ratio(
        "hybrid below impedance in x",
        "hybrid",
        "impedance",
        "Adapting the arm takes up part of the board's depth: the CoG is displaced less under hybrid "
        "than under impedance. Springs in series, k_a / (k_a + m K_x), with the paper's gains: 0.61.",
    ),
    "admittance below PID in x": _ratio(
        "admittance below PID in x",
        "admittance",
        "pid",
        "Likewise the CoG is displaced less under admittance than under PID.",
    ),
    "hybrid pushed least": _smallest_force,
    "admittance narrows the force": _narrower_force,
}
"""Claims that one comparison can be held against, in the paper's order."""
