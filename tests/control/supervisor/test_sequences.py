"""Sequences of anything: commands stay finite and within limits, modes latch, and what lasts has its end."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    rule,
    run_state_machine_as_test,
)

import skylimb
from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Imu, Measurement
from skylimb.control.missions.reference import zero_reference
from skylimb.control.records import Command
from skylimb.control.supervisor.halves import Halves
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Flags, initial_watch
from skylimb.control.supervisor.table import TABLE

DT = 0.005
LIMITS = Limits(losses=True, overruns=20, retreat_after=0.1, cut_after=0.2, imu_for=0.2, descend_for=0.5)
"""Times are short, so that sequences reach the ends of them."""

ROBOT = skylimb.load_robot("hydrus_xi_quad")
NORMAL, COAST, RETREAT, DESCEND, CUT = range(len(TABLE.modes))
MEMORY = Layout(initial_watch(ROBOT, True))
WILD = st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e12, 5e-324, 0.0])

# A fault that lasts: what is flags of it, the mode that it ends in at least, and within which time, s.
LASTING: dict[str, tuple[dict[str, Any], int, float]] = {
    "no pose": ({"pose": 0.0}, CUT, LIMITS.cut_after + LIMITS.imu_for),
    "no joint angles": ({"joints": 0.0}, RETREAT, LIMITS.retreat_after),
    "no command": ({}, RETREAT, LIMITS.overruns * DT),
    "a command of no numbers": ({}, RETREAT, LIMITS.overruns * DT),
    "a silent imu": ({}, DESCEND, LIMITS.deaf_after),
    "a landing": ({"land": 1.0}, RETREAT, 0.0),
    "a stop": ({"stop": 1.0}, CUT, 0.0),
}


class Flight(RuleBasedStateMachine):
    """Whatever comes, for some ticks at a time."""

    def __init__(self) -> None:
        super().__init__()
        self.halves = Halves(ROBOT, LIMITS, 0, DT, imu=True)
        self.rng = np.random.default_rng(0)
        self.fault = ""
        self.mode, self.command = 0.0, initial_watch(ROBOT, True).command
        self.reference = zero_reference(3, 4)._replace(
            position=np.array([0.0, 0.0, 1.0]), contact_axis=np.array([1.0, 0.0, 0.0])
        )
        self.imu = Imu(np.zeros(3), np.zeros(3))

    def measured(self, **changes: Any) -> Measurement:
        """A robot that hovers, with a sensor's noise."""
        small = 1e-3 * self.rng.standard_normal((4, 3))
        seen = Measurement(
            np.array([0.0, 0.0, 1.0]) + small[0],
            np.array([1.0, 0.0, 0.0, 0.0]),
            small[1],
            small[2],
            ROBOT.nominal_posture(),
            np.zeros(4),
            0.01,
            self.imu,
        )
        return seen._replace(**changes)

    def tick(self, measured: Measurement | None, wanted: Command | None, flags: Flags | None = None) -> None:
        """One tick, and what has to hold after every one."""
        before = self.mode
        self.halves.look(flags or Flags(), measured, self.reference)
        self.mode = self.halves.mode
        self.command, _ = self.halves.act(wanted)
        assert self.mode in range(len(TABLE.modes))
        # What a tick works on: whatever was remembered, it begins with numbers.
        known = [part for name, part in MEMORY.slices.items() if not name.startswith("before.")]
        assert np.isfinite(np.concatenate([self.halves._looked[part] for part in known])).all()
        assert self.mode >= before or (before, self.mode) == (COAST, NORMAL)

    def wanted(self, value: float = 10.0) -> Command:
        """What a controller commands."""
        return Command(np.full(4, value), ROBOT.nominal_posture(), np.zeros(4))

    def hears(self) -> None:
        """An IMU says something new."""
        self.imu = Imu(self.rng.standard_normal(3), self.rng.standard_normal(3))

    @initialize(fault=st.sampled_from(list(LASTING)))
    def begin(self, fault: str) -> None:
        """A flight that is seen, and the fault that will end it."""
        self.fault = fault
        for _ in range(3):
            self.hears()
            self.tick(self.measured(), self.wanted())

    @rule(ticks=st.integers(1, 30))
    def flies(self, ticks: int) -> None:
        """All is well."""
        for _ in range(ticks):
            self.hears()
            self.tick(self.measured(), self.wanted())

    @rule(
        ticks=st.integers(1, 30),
        flags=st.tuples(*(st.sampled_from([0.0, 1.0, np.nan]),) * 3),
        value=st.sampled_from([5.0, 1e3, -1e3]),
    )
    def is_told_odd_things(self, ticks: int, flags: tuple[float, ...], value: float) -> None:
        """Poses and angles are new or not, ticks late or not, thrusts wanted that no rotor gives."""
        for _ in range(ticks):
            self.tick(self.measured(), self.wanted(value), Flags(*flags))

    @rule(ticks=st.integers(1, 30), place=st.integers(0, 30), wild=WILD)
    def measures_wildly(self, ticks: int, place: int, wild: float) -> None:
        """A number of the measurement is none, or absurd."""
        layout = Layout(self.measured())
        for _ in range(ticks):
            flat = layout.pack(self.measured())
            flat[place % len(flat)] = wild
            self.tick(layout.unpack(flat), self.wanted())

    @rule(ticks=st.integers(1, 30), way=st.floats(-2.0, 2.0))
    def jumps(self, ticks: int, way: float) -> None:
        """The capture shows another place."""
        for _ in range(ticks):
            moved = self.measured()
            self.tick(moved._replace(position=moved.position + np.array([way, 0.0, 0.0])), self.wanted())

    @rule(ticks=st.integers(1, 30), place=st.integers(0, 10), wild=st.one_of(st.none(), WILD))
    def controls_wildly(self, ticks: int, place: int, wild: float | None) -> None:
        """The controller commands nothing, or no number."""
        layout = Layout(self.wanted())
        flat = layout.pack(self.wanted())
        flat[place % len(flat)] = 0.0 if wild is None else wild
        for _ in range(ticks):
            self.tick(self.measured(), None if wild is None else layout.unpack(flat))

    @rule(name=st.sampled_from([name for name in MEMORY.slices if name != "mode"]), wild=WILD)
    def forgets(self, name: str, wild: float) -> None:
        """Something writes into the memory, but for the mode; then the controller commands nothing."""
        self.halves._state[MEMORY.slices[name]] = wild
        self.controls_wildly(20, 0, None)

    @invariant()
    def commands_within_limits(self) -> None:
        """Whatever came."""
        limits = ROBOT.thrust_limits(), ROBOT.joint_limits(), ROBOT.vectoring_limits()
        for part, (low, high) in zip(self.command, limits, strict=True):
            assert np.isfinite(part).all()
            assert ((part >= low) & (part <= high)).all()

    def teardown(self) -> None:
        """A fault that lasts has its end, whatever came before it."""
        if self.fault:
            flags, mode, within = LASTING[self.fault]
            self.flies(1)  # whoever forgot that anything was seen sees it again
            for _ in range(round(within / DT) + 2):
                if self.fault != "a silent imu":
                    self.hears()
                odd = {"no command": None, "a command of no numbers": self.wanted(np.nan)}
                wanted = odd.get(self.fault, self.wanted())
                self.tick(self.measured(), wanted, Flags()._replace(**flags))
                self.commands_within_limits()
            assert self.mode >= mode


def test_whatever_comes() -> None:
    assert TABLE.modes.keys() == {"NORMAL", "COAST", "RETREAT", "DESCEND", "CUT"}
    run_state_machine_as_test(
        Flight,
        settings=settings(
            max_examples=60,
            stateful_step_count=12,
            deadline=None,
            suppress_health_check=[HealthCheck.too_slow],
        ),
    )
