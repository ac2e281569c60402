"""Laws that ship, side by side: each pair flies or is refused by name, and each law is what it declares."""

import itertools
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skylimb
from law_records import hover
from skylimb.base.config import with_overrides
from skylimb.base.errors import ConfigError
from skylimb.base.keys import rows_of
from skylimb.base.packing import Layout
from skylimb.control.cascade import Cascade, build_cascade
from skylimb.control.controller import load_controller
from skylimb.control.laws.fields import FIELDS, RECORDS, needed, optional, provided, require_fit, required
from skylimb.control.laws.monitor import LawMonitor
from skylimb.control.laws.preset import Preset, preset_from_mapping, preset_mapping, preset_names
from skylimb.control.laws.slots import SLOTS, Slot, Slots, find_law, law_names
from skylimb.control.laws.trial import with_trial
from skylimb.flight.events import EventContext, GainChange
from skylimb.robots.model import Robot
from skylimb.simulation.surfaces import surface_from_mapping

DT = 0.005
ROBOT: Robot = skylimb.load_robot("hydrus_xi_quad")


@cache
def filled(slot: str, name: str) -> Slot:
    """A law that ships, with the gains of a preset that has it, else its own."""
    presets = (preset_from_mapping(*preset_mapping(preset)) for preset in preset_names())
    used = (getattr(preset.slots, slot) for preset in presets)
    law = find_law(slot, name, Path())
    return next((one for one in used if one.name == name), None) or Slot(name, law, law.Gains())


def slots_of(names: tuple[str, ...]) -> Slots:
    return Slots(*map(filled, SLOTS, names))


COMBINATIONS = list(itertools.product(*(law_names(slot) for slot in SLOTS)))


def fits(slots: Slots) -> bool:
    try:
        require_fit(slots, "here")
    except ConfigError:
        return False
    return True


@cache
def fitting() -> list[tuple[str, ...]]:
    """Names of laws that fit, in all slots. Not worked out before a test asks."""
    return [names for names in COMBINATIONS if fits(slots_of(names))]


@cache
def cascade_of(names: tuple[str, ...]) -> Cascade:
    return build_cascade(ROBOT, Preset("mixed", "", slots_of(names)))


def pairs(names: tuple[str, ...]) -> set[tuple[tuple[str, str], ...]]:
    """Every two laws of a cascade."""
    return set(itertools.combinations(zip(SLOTS, names, strict=True), 2))


@cache
def covering() -> tuple[tuple[str, ...], ...]:
    """A few cascades that fit, in which any two laws fly together that do so in one of them at all."""
    chosen, left = [], set().union(*map(pairs, fitting()))
    while left:
        best = max(fitting(), key=lambda names: len(left & pairs(names)))
        chosen.append(best)
        left -= pairs(best)
    return tuple(chosen)


def test_laws_that_fit_fly_a_tick() -> None:
    for names in covering():
        cascade = cascade_of(names)
        measurement, reference = hover(cascade)
        gains, state = cascade.gains(), cascade.initial_state()
        state, *_ = cascade.step(gains, state, measurement, reference, DT)
        everything = cascade.step(gains, state, measurement, reference, DT)
        assert np.isfinite(ca.DM(Layout(everything).pack(everything)).full()).all(), names


def test_laws_that_do_not_fit_are_refused_by_both_names_and_the_field() -> None:
    refused = [names for names in COMBINATIONS if names not in fitting()]
    assert len(refused) > len(fitting()) > 50
    for names in refused:
        with pytest.raises(ConfigError, match=r"^here: ") as caught:
            require_fit(slots_of(names), "here")
        called = {f"{slot} law '{name}'": slot for slot, name in zip(SLOTS, names, strict=True)}
        told = sorted((one for one in called if one in str(caught.value)), key=str(caught.value).index)
        needing, giving = (called[one] for one in told)
        fields = {field for field in FIELDS if field in str(caught.value).replace(",", " ").split()}
        law = getattr(slots_of(names), giving).law
        assert fields
        assert fields <= needed(needing, getattr(slots_of(names), needing)).keys()
        assert fields.isdisjoint(provided(giving, law) or ())
        # The laws that it recommends give what is missing.
        shipped = str(caught.value).partition(f"({giving} laws that do: ")[2].rstrip(")").split(", ")
        for name in shipped:
            assert fields <= set(provided(giving, find_law(giving, name, Path())) or ())


def test_task_frame_on_open_contact_is_refused_when_it_is_read(robot: Robot) -> None:
    with pytest.raises(ConfigError) as caught:
        load_controller("task_frame", robot, {"contact.law": "open"})
    assert str(caught.value) == (
        "controller task_frame: translation law 'task_frame' needs contact.tip, which contact law 'open' "
        "does not give (contact laws that do: task_frame)"
    )


@cache
def seen() -> dict[tuple[str, str], tuple[set[str], set[str]]]:
    """What each law read and gave in any cascade, those with every structural switch among them."""
    found: dict[tuple[str, str], tuple[set[str], set[str]]] = {}
    for names in covering():
        for steady in (False, True):
            slots = slots_of(names)
            if hasattr(getattr(slots.allocation.gains, "leak", None), "steady"):
                gains = with_overrides(slots.allocation.gains, {"leak.steady": steady}, "", "")
                slots = slots._replace(allocation=replace(slots.allocation, gains=gains))
            elif steady:
                continue
            cascade = build_cascade(ROBOT, Preset("mixed", "", slots))
            monitor = LawMonitor(slots)
            cascade.step(cascade.gains(), cascade.initial_state(), *hover(cascade), DT, monitor)
            for slot, name in zip(SLOTS, names, strict=True):
                read, given = found.setdefault((slot, name), (set(), set()))
                read |= monitor.reads[slot]
                given |= monitor.gives.get(slot, set())
    return found


@pytest.mark.parametrize(("slot", "name"), [(slot, name) for slot in SLOTS for name in law_names(slot)])
def test_a_law_declares_what_it_reads_and_gives_and_no_more(slot: str, name: str) -> None:
    law = find_law(slot, name, Path())
    read, given = seen()[slot, name]
    assert read == {*(required(law) or ()), *optional(law)}
    assert given == set(provided(slot, law) or ())
    assert hasattr(law, "PROVIDES") == (slot in FIELDS.values())
    assert hasattr(law, "REQUIRES") == (slot != "estimation")


def given_by(field: str) -> str:
    """The laws that give a field, as the page lists them."""
    slot = FIELDS[field]
    return ", ".join(
        f"`{name}`"
        for name in law_names(slot)
        if field in (provided(slot, find_law(slot, name, Path())) or ())
    )


def read_by(field: str) -> str:
    """The laws that read a field by their slots; in brackets those that do so where it is given."""
    slots = []
    for slot in SLOTS:
        laws = {name: find_law(slot, name, Path()) for name in law_names(slot)}
        names = [f"`{name}`" for name, law in laws.items() if field in (required(law) or ())]
        names += [f"(`{name}`)" for name, law in laws.items() if field in optional(law)]
        if names:
            slots.append(f"{slot} {', '.join(names)}")
    return "; ".join(slots) or "the cascade"


def test_the_page_says_which_law_gives_and_reads_each_field() -> None:
    page = (Path(__file__).parents[3] / "docs" / "law_fields.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines()]
    told = {row[0].strip("`"): row[1:] for row in rows if row[0].strip("`") in FIELDS}
    assert list(told) == list(FIELDS)
    shapes = _shapes()
    for field, (shape, _, _, givers, readers) in told.items():
        assert shape == shapes[field]
        assert givers == given_by(field)
        assert readers == read_by(field)


def _shapes() -> dict[str, str]:
    """Shape of each field, or the name of the record that it is."""

    class Keeping(LawMonitor):
        found: dict[str, str]

        def keep(self, field: str, value: Any) -> None:
            if value is not None:
                size = Layout({"": value}).size
                plain = "scalar" if size == 1 else f"({size},)"
                self.found[field] = f"`{type(value).__name__}`" if hasattr(value, "_fields") else plain

        def gave(self, slot: str, record: Any) -> None:
            name = next(name for name, (giver, _) in RECORDS.items() if giver == slot)
            for field, value in record._asdict().items():
                self.keep(f"{name}.{field}", value)
            super().gave(slot, record)

        def residual(self, state: Any) -> Any:
            missing = super().residual(state)
            self.keep("residual", missing)
            return missing

    found: dict[str, str] = {}
    for names in covering():
        cascade = cascade_of(names)
        monitor = Keeping(cascade.preset.slots)
        monitor.found = found
        cascade.step(cascade.gains(), cascade.initial_state(), *hover(cascade), DT, monitor)
    return found


@settings(max_examples=25, deadline=None)
@given(
    names=st.deferred(lambda: st.sampled_from(fitting())),
    changes=st.fixed_dictionaries({}, optional={
        "translation.feed": st.sampled_from([0.0, 0.5]),
        "translation.landing_cancel": st.sampled_from([(0.0, 0.0), (0.0, 0.5)]),
        "allocation.leak.steady": st.booleans(),
        "allocation.leak.compensate": st.booleans(),
        "estimation.tare": st.booleans(),
    }),
)  # fmt: skip
def test_whatever_is_not_refused_reads_only_what_it_declares(
    names: tuple[str, ...], changes: dict[str, Any]
) -> None:
    cascade = cascade_of(names)
    keys = {name for name, _, _ in rows_of(cascade.key_tables())}
    changes = {key: value for key, value in changes.items() if key in keys}
    preset = cascade.preset
    for key, value in changes.items():
        preset = preset.with_gain(key, value, "here")
    if fits(preset.slots):
        # Raises where a law reads or gives other than it declares.
        with_trial(cascade.with_gains(changes))
    else:
        with pytest.raises(ConfigError, match="does not give"):
            cascade.with_gains(changes)


@pytest.mark.parametrize(
    ("key", "value", "field"),
    [
        ("translation.feed", 1.0, "contact.across"),
        ("translation.landing_cancel", (0.0, 0.5), "contact.landing"),
    ],
)
def test_a_gain_that_needs_a_field_is_refused_before_and_in_flight(
    robot: Robot, key: str, value: Any, field: str
) -> None:
    following, drawing = (load_controller(name, robot) for name in ("following", "drawing"))
    told = rf"^{{}} following: translation law 'following' needs {field} \({key} = .*\), which contact law 'f"
    change, board = GainChange(5.0, key, value), surface_from_mapping({})
    change.require(EventContext(robot, drawing, board, 0.005))
    with pytest.raises(ConfigError, match=told.format("gain at 5 s, controller")):
        change.require(EventContext(robot, following, board, 0.005))
    assert isinstance(following, Cascade)
    with pytest.raises(ConfigError, match=told.format("controller")):
        following.with_gains({key: value})
    with pytest.raises(ConfigError, match=told.format("controller")):
        load_controller("following", robot, {key: value})
