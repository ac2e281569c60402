"""A score as it is declared: what it is, which flight it calls better, and what the verdict holds it to.

Scores that ship and those of a user's own file are declared alike, at the function that computes them:

    @skylimb.metric(unit="m", smaller_is_better=True, tolerance="pen_line")
    def overshoot(run):
        '''How far the pen went beyond its path.'''
        return float(...)

Such a function takes a run and returns a number, NaN where there is none. With `keys` it returns a dict, and
each key is a score of its own: `keys=("roll", "pitch")` where all are declared alike, else
`keys={"mean": skylimb.Score("Mean of it", "N"), ...}`. It never sees a run that failed, unless it says
`lost=True`: then it is for it to say what such a run still tells.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, get_args

from skylimb.analysis.scores.axis_names import GENERIC, AxisNames
from skylimb.analysis.scores.signals import NoNumberError
from skylimb.base.errors import ConfigError, UserCodeError, choice_error

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run

Kind = Literal["number", "count", "yes or no"]
Number = float | bool | None
"""A score of a flight; None where the flight has none."""

_LONGEST_SHOWN = 60
"""Letters of what a metric returned in a message."""

MISSION = "Distance of the centre of gravity from the mission's reference"
TARGET = "Distance of the centre of gravity from the control law's own target"
PEN = "Distance of the pen from its reference line"
TIMING = "Time"
DRAWING = "The drawn line"
TASK = "The task"
FORCE = "Force"
CONTACT = "Contact and attitude"
GROUPS = ("Done as commanded", MISSION, TARGET, PEN, DRAWING, TIMING, TASK, FORCE, CONTACT)
"""Parts of a table of scores in their order; a group that is not among them comes after them."""

FURTHER = "Further numbers"
"""Title of the scores without a group, which come last."""


@dataclass(frozen=True)
class Tolerance:
    """What a score is held to in a flight's verdict: at most where smaller is better, else at least.

    Attributes:
        bound: a key of the experiment's `[tolerances]`, or a number of the declaration's own.
        words: what was missed, with places for {value} and {bound}; a function of the run makes them where
            they tell more. Usual ones when empty.
        per: what makes a share of the score, which is judged in its place: a number, or a function of the
            run. A flight where it is 0 or not known is not judged.
        scaled: what the bound is for the size of what a run drew, in place of the stated one.
        required: whether a run without a value misses it: yes or no, or a function of the run. What is not
            required is not judged then.
    """

    bound: str | float
    words: str | Callable[[Run], str] = ""
    per: float | Callable[[Run], float | None] | None = None
    scaled: Callable[[Run], float] | None = None
    required: bool | Callable[[Run], bool] = False

    def __post_init__(self) -> None:
        if isinstance(self.bound, str):
            return
        if (
            isinstance(self.bound, bool)
            or not isinstance(self.bound, int | float)
            or self.bound != self.bound
        ):
            raise ConfigError(
                f"tolerance = {self.bound!r} is neither a key of an experiment's [tolerances] nor a number"
            )

    def stated(self, known: Mapping[str, float]) -> float | None:
        """Its bound for an experiment with such tolerances; None for a flight that has none of its name."""
        return known.get(self.bound) if isinstance(self.bound, str) else self.bound

    def of(self, run: Run) -> Tolerance:
        """The same with the words and the divisor that it has for a run, and whether it is required of it."""
        return replace(
            self,
            words=self.words(run) if callable(self.words) else self.words,
            per=(self.per(run) or 0.0) if callable(self.per) else self.per,
            required=self.is_required(run),
        )

    def is_required(self, run: Run) -> bool:
        """Whether the run misses it where it has no value."""
        return self.required(run) if callable(self.required) else self.required


@dataclass(frozen=True)
class Score:
    """The declaration of a score.

    Attributes:
        meaning: what it is, with places for the axes' names (`AxisNames.label`).
        unit: SI, empty for a pure number.
        smaller_is_better: None where neither is; then no flight is better by it.
        group: title of its part of a table; one of `GROUPS`, or another.
        row: its line below that title, with places as in `meaning`; the meaning when empty.
        kind: how it is printed; of many flights a "yes or no" has a rate in place of a median.
        ranked: whether a campaign compares controllers by it, given a direction. Of many comparisons some
            come out by chance, so the shipped scores that are ranked are few.
        tolerance: what the verdict holds it to, if anything.
        name: by which all tables know it.
    """

    meaning: str = ""
    unit: str = ""
    smaller_is_better: bool | None = None
    group: str = ""
    row: str = ""
    kind: Kind = "number"
    ranked: bool = True
    tolerance: Tolerance | None = None
    name: str = ""

    def __post_init__(self) -> None:
        called = f"score '{self.name or self.meaning}'"
        if not any(self.smaller_is_better is known for known in (True, False, None)):
            raise ConfigError(
                f"{called}: smaller_is_better = {self.smaller_is_better!r} is no direction; it is True, "
                "False, or left out where neither is better"
            )
        if self.kind not in get_args(Kind):
            raise choice_error(f"{called}: kind", str(self.kind), get_args(Kind))
        if self.tolerance is not None and not self.directed:
            raise ConfigError(
                f"{called} has a tolerance, so it needs smaller_is_better: True holds it to at most its "
                "bound, False to at least"
            )

    @property
    def directed(self) -> bool:
        """Whether it says which of two flights is better."""
        return self.smaller_is_better is not None

    @property
    def sign(self) -> float:
        """What makes small values good: -1 where larger ones are better, else 1."""
        return -1.0 if self.smaller_is_better is False else 1.0

    def text(self, axes: AxisNames = GENERIC) -> str:
        """What it is for a task with these axes."""
        return axes.label(self.meaning) or self.name

    def titled(self, axes: AxisNames = GENERIC) -> str:
        """The same with its unit in brackets, as figures call it."""
        return f"{self.text(axes)} ({self.unit})" if self.unit else self.text(axes)

    def line(self, axes: AxisNames = GENERIC) -> str:
        """What it is called in a table that is divided as by `grouped`."""
        return axes.label(self.row) or self.text(axes)

    def printed(self, value: Number) -> str:
        """A value in a table: three places, none for a count, and a true minus sign; empty for no number.

        One flight's verdict is yes or no, that of many flights the share of yes.
        """
        if value is None:
            return ""
        if isinstance(value, bool):
            return "yes" if value else "no"
        text = f"{value:g}" if self.kind == "count" else f"{value:z.3f}"
        return text.replace("-", "\N{MINUS SIGN}")

    def number(self, value: Any) -> Number:
        """A value as it is kept: None for what is no finite number, which JSON does not know.

        Raises:
            UserCodeError: when it is no number at all.
        """
        try:
            number = float(value)
        except (TypeError, ValueError):
            shown = " ".join(repr(value).split())
            shown = shown if len(shown) < _LONGEST_SHOWN else f"{shown[:_LONGEST_SHOWN]}..."
            raise UserCodeError(
                f"metric '{self.name}' should return a number, or NaN where there is none; "
                f"it returned {shown}"
            ) from None
        if not math.isfinite(number):
            return None
        return bool(number) if self.kind == "yes or no" else number


@dataclass(frozen=True)
class Metric:
    """A function of a run with the scores that it computes.

    Attributes:
        name: the function's.
        function: of a run; of one that failed only where `lost` says so.
        scores: one, or one for each key.
        keys: of the dict that the function returns; empty where it returns a number.
        on_demand: the set of further numbers that it belongs to; empty for a score of every flight.
        lost: whether it is of a flight that failed as well.
    """

    name: str
    function: Callable[[Run], Any]
    scores: tuple[Score, ...]
    keys: tuple[str, ...] = ()
    on_demand: str = ""
    lost: bool = False

    def __call__(self, run: Run) -> Any:
        """What the function returns."""
        return self.function(run)

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of its scores."""
        return tuple(score.name for score in self.scores)

    def of(self, run: Run) -> dict[str, Number]:
        """Its scores of a run by name.

        Raises:
            UserCodeError: when the function returns something else than it should.
        """
        return self.numbers(self.values(run))

    def numbers(self, values: Iterable[Any]) -> dict[str, Number]:
        """Its scores by name, of what its function returned for each."""
        return {score.name: score.number(one) for score, one in zip(self.scores, values, strict=True)}

    def values(self, run: Run) -> list[Any]:
        """What the function returns for each of its scores; NaN where it has no number.

        Raises:
            UserCodeError: when the function returns something else than it should.
        """
        try:
            found = self.function(run)
        except NoNumberError:
            return [math.nan] * len(self.scores)
        if isinstance(found, Mapping) != bool(self.keys) or (self.keys and set(found) != set(self.keys)):
            wanted = f"a dict with {', '.join(self.keys)}" if self.keys else "a number"
            hint = "; name them: @skylimb.metric(keys=(...))" if isinstance(found, Mapping) else ""
            raise UserCodeError(f"metric '{self.name}' should return {wanted}, it returned {found!r}{hint}")
        return [found[key] for key in self.keys] if self.keys else [found]


def metric(
    function: Callable[[Run], Any] | None = None,
    *,
    unit: str = "",
    smaller_is_better: bool | None = None,
    group: str = "",
    row: str = "",
    kind: Kind = "number",
    ranked: bool = True,
    tolerance: str | float | Tolerance | None = None,
    keys: Sequence[str] | Mapping[str, Score] = (),
    meaning: str = "",
    on_demand: str = "",
    lost: bool = False,
) -> Any:
    """Make a function of a run a `Metric`; see the module.

    Args:
        function: what is decorated.
        unit: see `Score`, as for all that follow but the last four.
        smaller_is_better: see there.
        group: see there.
        row: see there.
        kind: see there.
        ranked: see there.
        tolerance: a key of the experiment's `[tolerances]`, a number in the score's unit, or a `Tolerance`.
        keys: of the dict that the function returns, or a declaration for each.
        meaning: the first line of the function's docstring when empty.
        on_demand: name of a set; its scores are computed where a campaign's `measures` has it.
        lost: whether it is of a flight that failed as well.

    Raises:
        ConfigError: naming what cannot be declared so.
    """
    bound = tolerance if tolerance is None or isinstance(tolerance, Tolerance) else Tolerance(tolerance)

    def made(function: Callable[[Run], Any]) -> Metric:
        name = function.__name__
        alike = Score("", unit, smaller_is_better, group, row, kind, ranked, bound, name)
        text = meaning or (inspect.getdoc(function) or "").partition("\n")[0].rstrip(".")
        if isinstance(keys, Mapping):
            if alike != Score(name=name):
                raise ConfigError(f"metric '{name}': each of its keys has a declaration of its own")
            scores = [replace(score, name=score.name or f"{name}_{key}") for key, score in keys.items()]
        elif keys:
            scores = [
                replace(
                    alike,
                    meaning=f"{text}, {key}" if text else "",
                    row=f"{row}, {key}" if row else "",
                    name=f"{name}_{key}",
                )
                for key in keys
            ]
        else:
            scores = [replace(alike, meaning=text)]
        return Metric(name, function, tuple(scores), tuple(keys), on_demand, lost)

    return made if function is None else made(function)


def grouped(scores: Iterable[Score]) -> dict[str, list[Score]]:
    """Scores by what they measure, as tables show them; those of no group come last."""
    found = list(scores)
    titles = dict.fromkeys((*GROUPS, *(score.group for score in found if score.group), ""))
    parts = {title or FURTHER: [score for score in found if score.group == title] for title in titles}
    return {title: part for title, part in parts.items() if part}
