"""A user's laws are tried once when they are read: on numbers of a robot in hover, then on symbols.

The trial is a trace of the cascade. Where a user's law comes in, what it is given is evaluated for a robot
that is shaken about in hover. So it is seen what the law reads, and whether what it returns is what the
cascade needs. On symbols it has to give the same numbers; where it does not, it flies in Python.
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.errors import UserCodeError
from skylimb.base.packing import Layout, is_numeric, structure
from skylimb.base.record_tree import children_of, is_leaf, rebuilt
from skylimb.base.user_code import described, returned
from skylimb.control.estimation.records import Measurement, zero_measurement
from skylimb.control.laws.fields import require_fit
from skylimb.control.laws.monitor import LawMonitor, monitored_like, unmonitored
from skylimb.control.laws.prepared_gains import handed, preparing
from skylimb.control.laws.python_laws import PythonFunction
from skylimb.control.laws.results import called, checked
from skylimb.control.laws.slots import SLOTS, Slots
from skylimb.control.laws.traced_step import step_inputs, symbolic_inputs
from skylimb.control.laws.user_functions import Prepared, UserLaw
from skylimb.control.laws.user_trace import PERIOD, STEPS, differing, plain_attributes, shaken_hover
from skylimb.control.missions.reference import zero_reference
from skylimb.control.records import Demand


def tried(cascade: Any) -> Any:
    """The cascade with what a trial has shown where a law is a user's, else as it is; see `with_trial`."""
    theirs = any(isinstance(slot.law, UserLaw) for slot in cascade.preset.slots)
    return with_trial(cascade) if theirs else cascade


def with_trial(cascade: Any) -> Any:
    """The cascade with what a trial of its laws has shown.

    Raises:
        ConfigError: where a law reads what nobody gives, or is not as it declares.
        UserCodeError: where it fails, or returns what the cascade cannot take.
    """
    preset = cascade.preset
    gives, python = _shown(_Cascade(cascade.structure(), cascade))
    seen = zip(preset.slots, SLOTS, strict=True)
    slots = Slots(
        *(replace(filled, gives=gives.get(slot), python=python.get(slot, {})) for filled, slot in seen)
    )
    require_fit(slots, f"controller {preset.name}")
    return replace(cascade, preset=replace(preset, slots=slots))


@dataclass(frozen=True)
class _Cascade:
    """A cascade by its structure: flights that differ in numbers alone are tried together."""

    structure: Hashable
    cascade: Any = field(compare=False)


@functools.lru_cache(maxsize=64)
def _shown(of: _Cascade) -> tuple[dict[str, frozenset[str]], dict[str, dict[str, PythonFunction]]]:
    """What each law gives, and which of its functions fly in Python, by its slot."""
    cascade = of.cascade
    preset, monitor = cascade.preset, LawMonitor(cascade.preset.slots)
    for slot in preparing(preset):
        _try_prepare(cascade, slot)
    hover, laws = _Hover(cascade), dict[str, _TriedLaw]()
    for slot, filled in zip(SLOTS, preset.slots, strict=True):
        if isinstance(filled.law, UserLaw):
            laws[slot] = _TriedLaw(slot, filled.law, hover)
            preset = preset.with_slot(slot, replace(filled, law=laws[slot]))
    state, *given, gains = hover.records
    replace(cascade, preset=preset).step(gains, state, *given, PERIOD, monitor)
    return monitor.gives, {slot: law.python for slot, law in laws.items()}


def _try_prepare(cascade: Any, slot: str) -> None:
    """A `UserCodeError` unless what a law prepares of its gains is something, and the same every time."""
    filled = getattr(cascade.preset.slots, slot)
    law, (one, other) = filled.law, (filled.law.prepare(filled.gains, cascade.robot.pairs) for _ in range(2))
    if one is None:
        raise UserCodeError(
            f"{law.what}: prepare returns nothing, expected what step is handed behind inputs"
        )
    if is_numeric(one) and structure(one) == structure(other):
        layout = Layout(one)
        if not _differing(layout, layout.pack(one), layout.pack(other)):
            return
    elif not is_numeric(one):
        return
    raise UserCodeError(
        f"{law.what}: prepare gives another result when it is called again with the same gains"
    )


class _Hover:
    """The numbers that expressions of a trace have for a robot in hover, some times shaken about.

    Args:
        cascade: whose tick is traced.

    Attributes:
        robot: that the laws of the cascade fly.
        state: of each slot before the first tick.
        gains: as the laws are handed them.
        records: symbols for state, measurement, reference and gains.
        shapes: a record of numbers of every kind that has entries by joint.
    """

    def __init__(self, cascade: Any) -> None:
        needs, rng = cascade.needs, np.random.default_rng(0)
        inputs = step_inputs(cascade, len(needs.preview))
        self.robot, self.state = cascade.robot.pairs, cascade.initial_state()
        self.gains = handed(cascade.preset, self.robot, cascade.gains(), cascade.gains())
        self._symbols, self.records = symbolic_inputs(inputs)
        self._numbers: list[list[np.ndarray]] = []
        for _ in range(STEPS):
            hover = shaken_hover(cascade.robot, rng, needs)
            self.shapes = self._shapes(hover[0])
            given: tuple[Any, ...] = self.state, *hover, cascade.gains()
            self._numbers.append([part.pack(one) for part, one in zip(inputs, given, strict=True)])

    def _shapes(self, hover: Measurement) -> Mapping[type, Any]:
        robot, z3 = self.robot, np.zeros(3)
        q, psi = hover.joint_angles, hover.vectoring_angles[: robot.n_vectoring]  # pairs have no angles
        known = (
            zero_measurement(len(q), len(psi), hover.imu is not None),
            zero_reference(len(q), len(psi)),
            robot.at(q, psi),
            Demand(z3, z3, z3, q, psi),
        )
        return {type(one): one for one in known}

    def of(self, expression: Any) -> list[np.ndarray]:
        """What an expression is, each time."""
        function = ca.Function("hover", self._symbols, [ca.densify(ca.SX(expression))])
        return [function.call(numbers)[0].full().ravel() for numbers in self._numbers]

    def stands_for(self, symbols: Any, numbers: list[np.ndarray]) -> None:
        """Take up new symbols with their numbers, each time."""
        self._symbols.append(symbols)
        for known, more in zip(self._numbers, numbers, strict=True):
            known.append(more)


def _shaped(record: Any, shapes: Mapping[type, Any]) -> Any:
    """A record of symbols with leaves of the right shapes, where records of numbers are known to have them.

    Symbols do not tell a vector of one entry from a number, nor a matrix of one column from a vector: what
    belongs to the joints of a robot that has only one of them.
    """
    if is_leaf(record):
        return record
    known = shapes.get(type(record))
    children = [
        getattr(known, name)
        if is_leaf(child) and is_leaf(getattr(known, name, None))
        else _shaped(child, shapes)
        for name, child in children_of(record)
    ]
    return rebuilt(record, children) if children else record


class _FailedError(Exception):
    """A user's function has raised an error on numbers."""

    def __init__(self, error: Exception) -> None:
        super().__init__(str(error))
        self.error = error


class _TriedLaw:
    """A law whose every call is tried on numbers before it is traced.

    Args:
        slot: that it fills.
        law: a user's.
        hover: gives the numbers.

    Attributes:
        python: its functions that cannot be compiled.
    """

    def __init__(self, slot: str, law: UserLaw, hover: _Hover) -> None:
        self._slot, self._law, self._hover = slot, law, hover
        self.python: dict[str, PythonFunction] = {}

    def __getattr__(self, name: str) -> Any:
        """What the law has; its functions are tried."""
        return partial(self._call, name) if name in self._law.plain else getattr(self._law, name)

    def _call(self, name: str, *given: Any) -> Any:
        traced = getattr(self._law, name)
        bare = unmonitored(given)
        known = (getattr(record, self._slot) for record in (self._hover.gains, self._hover.state))
        layout = Layout((*known, *(_shaped(one, self._hover.shapes) for one in bare[2:])))
        hover = self._hover.of(layout.pack(bare))
        try:
            made, results, changed = self._on_numbers(name, layout, hover, given)
        except _FailedError as failed:
            # What is written for symbols alone flies as well; on symbols it is held to the same.
            if "read-only" not in str(failed):
                with contextlib.suppress(Exception):
                    return self._on_symbols(name, traced(*given))
            raise failed.error from failed.error.__cause__
        why = _untraceable(traced, name, layout, made, zip(hover, results, strict=True))
        if changed and not why:
            why = f"{name} changes '{changed}' of its file at every call; memory belongs into its state"
        if not why:
            return traced(*given)
        self.python[name] = PythonFunction(layout, made, why.removeprefix(f"{self._law.what} fails in "))
        symbols = ca.SX.sym(name, made.size)
        self._hover.stands_for(symbols, results)
        return made.unpack(symbols)

    def _on_symbols(self, name: str, result: Any) -> Any:
        """A function's result on symbols, after a look at the numbers that it has."""
        layout, law, hover = Layout(result), self._law, self._hover
        for numbers in hover.of(layout.pack(result)):
            one, state = layout.unpack(numbers), getattr(hover.state, self._slot)
            checked(one, self._slot, name, f"{law.what}: {name}", state, hover.robot, law.signals)
        return result

    def _on_numbers(
        self, name: str, layout: Layout[Any], hover: list[np.ndarray], given: tuple[Any, ...]
    ) -> tuple[Layout[Any], list[np.ndarray], str]:
        """What a function returns: where it stands in a flat vector, and the vector for each of its calls.

        Third is a name in the law's file whose value every call changes; empty where there is none.
        """
        law, function, results = self._law, self._law.plain[name], list[np.ndarray]()
        before, now = dict[str, str](), dict[str, str]()
        made = Layout[Any](())
        for numbers in hover:
            record = layout.reader(numbers)()
            try:
                with np.errstate(all="ignore"):  # what is not finite is named
                    result, place = returned(function, *monitored_like(given, record))
            except Exception as error:
                raise _FailedError(error) from error
            what = f"{law.what}{f' in {place}' if place else ''}: {name}"
            state = getattr(self._hover.state, self._slot)
            known = made
            made, result = checked(result, self._slot, name, what, state, self._hover.robot, law.signals)
            if results and (odd := sorted(known.slices.keys() ^ made.slices.keys())):
                raise UserCodeError(
                    f"{what} does not always return {called(odd[0])}; whatever is recorded is recorded at "
                    "every tick"
                )
            results.append(result)
            again = np.zeros(made.size)
            made.writer(again)(function(*record))
            if odd := _differing(made, result, again):
                raise UserCodeError(
                    f"{what} gives another {odd} when it is called again with the same arguments; what it "
                    "remembers belongs into its state, and it draws no random numbers"
                )
            before, now = now, plain_attributes(law.module)
        # What only the first calls change is a table that is filled once.
        return made, results, next((part for part in now if now[part] != before.get(part)), "")


def _untraceable(
    function: Any,
    name: str,
    given: Layout[Any],
    made: Layout[Any],
    calls: Iterable[tuple[np.ndarray, np.ndarray]],
) -> str:
    """Why a function cannot be compiled, in a sentence; empty where it can."""
    symbols = ca.SX.sym("given", given.size)
    arguments = given.unpack(symbols)
    if isinstance(arguments[0], Prepared) and not is_numeric(arguments[0].made):
        return f"what prepare returns ({type(arguments[0].made).__name__}) is more than numbers"
    try:
        traced = ca.Function("law", [symbols], [ca.densify(ca.SX(made.pack(function(*arguments))))])
    except Exception as error:  # whatever it is, the law has worked on numbers
        return described(error)
    for numbers, result in calls:
        if odd := _differing(made, traced(numbers).full().ravel(), result):
            return f"on symbols {name} gives another {odd} than on numbers"
    return ""


def _differing(layout: Layout[Any], one: np.ndarray, other: np.ndarray) -> str:
    """The first entry in which two flat results differ; empty where there is none."""
    if one.shape != other.shape:
        return "shape"
    return next((called(name) or "result" for name in differing(layout, one, other)), "")
