"""A controller that commands nothing on bad grounds, and never anything out of limits."""

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skylimb
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.records import Command
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.retreat import BACK, BACK_SPEED, DESCENT, retreat
from skylimb.control.supervisor.table import TABLE
from skylimb.flight.realtime.compiled_controller import CompiledController
from skylimb.flight.realtime.guard import WORDS, GuardedController
from skylimb.flight.realtime.pacer import Pacer
from skylimb.robots.model import Robot

Make = Callable[..., Measurement]
DT = 0.005


class Late(Pacer):
    """A pacer whose ticks are missed where one says so."""

    def __init__(self) -> None:
        super().__init__(DT)
        self.is_missed, self.moment = False, 0.0

    def time(self) -> float:
        return self.moment

    @property
    def missed(self) -> bool:
        return self.is_missed


class Counting:
    """Commands a number that rises with every tick that it flies."""

    name = "counting"

    def __init__(self, robot: Robot) -> None:
        self.robot, self.seen = robot, list[tuple[Measurement, Reference]]()
        self.given: Callable[[Command], Any] = lambda command: command

    def gains(self) -> None:
        return None

    def initial_state(self) -> int:
        return 0

    def step(
        self, gains: None, state: int, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[int, Any, dict[str, Any]]:
        self.seen.append((measurement, reference))
        command = Command(
            np.full(4, 5.0 + 0.01 * (state + 1)), reference.joint_angles, reference.vectoring_angles
        )
        return state + 1, self.given(command), {"ticks": float(state + 1), "vector": np.ones(3)}


def noisy(measurement: Measurement, count: Iterator[int] = itertools.count()) -> Measurement:  # noqa: B008
    """What no sensor shows twice."""
    try:
        little = 1e-9 * next(count)
        named = ("position", "velocity", "angular_velocity")
        return measurement._replace(**{name: getattr(measurement, name) + little for name in named})
    except TypeError:
        return measurement


class Flight:
    """A guard, its controller, and what happened to them so far."""

    def __init__(self, robot: Robot, **limits: Any) -> None:
        self.inner, self.pacer = Counting(robot), Late()
        self.guard = GuardedController(self.inner, robot, self.pacer, Limits(**limits))
        self.state: Any = self.guard.initial_state()
        self.reference = zero_reference(3, 4)._replace(
            position=np.array([0.0, 0.0, 1.0]), contact_axis=np.array([1.0, 0.0, 0.0]), touch=1.0, adapt=1.0
        )
        # The joints that `hovering` has: servos that don't follow are a fault of their own.
        q, psi = nominal_posture(robot, "torque")
        self.reference = self.reference._replace(joint_angles=q, vectoring_angles=psi)

    def tick(self, measurement: Measurement, taken: float | None = None) -> tuple[Command, dict[str, Any]]:
        if taken is not None:
            self.guard.taken(taken)
        self.state, command, own = self.guard.step(None, self.state, noisy(measurement), self.reference, DT)
        self.pacer.moment += DT
        return command, dict(own)


@pytest.fixture
def flight(robot: Robot) -> Flight:
    return Flight(robot, overruns=10)


def test_a_missed_tick_holds_the_command(flight: Flight, hovering: Make) -> None:
    first, _ = flight.tick(hovering())
    flight.pacer.is_missed = True
    held, own = flight.tick(hovering())
    np.testing.assert_array_equal(held.thrusts, first.thrusts)
    assert (own["tick_held"], own["ticks"]) == (1.0, 1.0)
    flight.pacer.is_missed = False
    command, own = flight.tick(hovering())
    assert command.thrusts[0] == pytest.approx(5.02)
    assert own["tick_held"] == 0.0
    assert flight.guard.counts["missed tick"] == 1


@pytest.mark.parametrize(("delay", "mode"), [(0.055, "NORMAL"), (0.065, "RETREAT")])
def test_what_a_link_adds_to_the_loop_is_borne_or_leads_back(
    flight: Flight, hovering: Make, delay: float, mode: str
) -> None:
    _, own = flight.tick(hovering())
    for _ in range(3):
        flight.guard.delayed(delay)
        _, own = flight.tick(hovering())
    assert own["loop_delay"] == delay
    assert flight.guard.mode == mode
    assert flight.guard.counts.get("commands take too long", 0) == (mode == "RETREAT")


@pytest.mark.parametrize("odd", [np.ones(2), "grasped", None, {"a": 1}])
def test_a_signal_that_is_not_what_it_was_is_no_number_in_the_log_and_no_reason_to_land(
    flight: Flight, hovering: Make, odd: Any
) -> None:
    _, own = flight.tick(hovering())
    np.testing.assert_array_equal(own["vector"], np.ones(3))
    step = flight.inner.step

    def spoilt(*given: Any) -> tuple[int, Any, dict[str, Any]]:
        state, command, signals = step(*given)
        return state, command, {**signals, "vector": odd}

    flight.inner.step = spoilt  # type: ignore[method-assign]
    command, own = flight.tick(hovering())
    assert np.isnan(own["vector"]).all()
    assert np.shape(own["vector"]) == (3,)
    assert own["ticks"] == 2.0
    assert command.thrusts[0] == pytest.approx(5.02)
    assert flight.guard.counts == {"signal 'vector' is not what it was": 1}
    assert not flight.guard.retreating


@pytest.mark.parametrize("odd", [None, (1, 2), ("a", "b", "c"), (1, Command(np.full(4, "x"), 2.0, 3.0), {})])
def test_what_is_no_answer_of_a_controller_is_a_controller_that_failed(
    flight: Flight, hovering: Make, odd: Any
) -> None:
    before, _ = flight.tick(hovering())
    flight.inner.step = lambda *given: odd  # type: ignore[method-assign]
    command, _ = flight.tick(hovering())
    np.testing.assert_array_equal(command.thrusts, before.thrusts)
    assert flight.guard.counts["the controller failed"] == 1
    flight.tick(hovering())
    assert flight.guard.retreating


def test_each_bit_of_the_table_has_words_for_a_pilot() -> None:
    assert list(WORDS) == list(TABLE.bits)


def test_why_it_was_broken_off_is_what_was_asked_and_not_that_somebody_asked(
    flight: Flight, hovering: Make, caplog: pytest.LogCaptureFixture
) -> None:
    flight.tick(hovering())
    flight.guard.retreat("low battery")
    flight.tick(hovering())
    assert flight.guard.reason == "broken off by the guard (low battery)"
    assert "NORMAL -> RETREAT: low battery" in caplog.text


def test_too_many_missed_ticks_in_a_row_retreat(flight: Flight, hovering: Make) -> None:
    flight.tick(hovering())
    for _ in range(3):  # not in a row
        flight.pacer.is_missed = True
        for _ in range(9):
            flight.tick(hovering())
        flight.pacer.is_missed = False
        flight.tick(hovering())
    assert not flight.guard.retreating
    flight.pacer.is_missed = True
    for _ in range(12):
        flight.tick(hovering())
    assert flight.guard.retreating
    flight.pacer.is_missed = False
    _, own = flight.tick(hovering())
    assert own["retreating"] == 1.0
    assert flight.inner.seen[-1][1].touch == 0.0


def test_old_measurements_coast_then_descend_and_then_cut(
    robot: Robot, hovering: Make, caplog: pytest.LogCaptureFixture
) -> None:
    flight = Flight(robot)
    first, _ = flight.tick(hovering(), taken=0.0)
    modes, commands = list[str](), list[Command]()
    for _ in range(250):
        commands.append(flight.tick(hovering(), taken=0.0)[0])
        modes.append(flight.guard.mode)
    began = {mode: modes.index(mode) for mode in ("COAST", "DESCEND", "CUT")}
    # After one pose nobody knows yet how often they come: it coasts later than it will.
    assert began == {"COAST": 18, "DESCEND": 120, "CUT": 200}
    # The controller is asked all the while that it coasts, about where the model has the robot.
    assert len(flight.inner.seen) == 121
    moved = np.array([seen.position for seen, _ in flight.inner.seen[20:]])
    assert np.diff(moved[:, 2]).max() < 0.0  # 20 N carry nothing, and it knows
    level = np.array([command.thrusts for command in commands[120:200]])
    low, high = robot.thrust_limits()
    assert (level >= low).all()
    assert (level <= high).all()
    assert (level[20:] > low).all()
    np.testing.assert_array_equal(commands[-1].thrusts, low)
    np.testing.assert_array_equal(commands[-1].joint_angles, first.joint_angles)
    assert flight.guard.retreating
    assert "guard" in caplog.text or "DESCEND" in caplog.text
    flight.tick(hovering(), taken=1.3)
    assert flight.guard.mode == "CUT"


def test_joint_angles_that_stop_are_not_the_poses_fault(flight: Flight, hovering: Make) -> None:
    """The controller flies back by a good pose, with the angles that were believed last."""
    modes: list[str] = []
    for k in range(200):
        flight.guard.taken(k * DT, min(k, 20) * DT)
        flight.tick(hovering())
        modes.append(flight.guard.mode)
    broken = modes.index("RETREAT")
    assert broken == pytest.approx(20 + 0.6 / DT, abs=1)
    assert set(modes[:broken]) == {"NORMAL"}
    assert set(modes[broken:]) == {"RETREAT"}
    assert flight.guard.counts == {"no joint angles for long": 200 - broken}


def test_a_fresh_measurement_ends_a_coast(robot: Robot, hovering: Make) -> None:
    flight = Flight(robot)
    for k in range(60):
        blind = 20 <= k < 50
        flight.tick(hovering(), taken=None if not blind else 19 * DT)
        if blind and k > 26:
            assert flight.guard.mode == "COAST"
    assert flight.guard.mode == "NORMAL"
    assert not flight.guard.retreating


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_command_that_is_no_number_is_held(flight: Flight, hovering: Make, bad: float) -> None:
    first, _ = flight.tick(hovering())
    flight.inner.given = lambda command: command._replace(joint_angles=np.array([0.0, bad, 0.0]))
    command, own = flight.tick(hovering())
    np.testing.assert_array_equal(command.thrusts, first.thrusts)
    assert own["tick_held"] == 1.0
    assert flight.state == 1  # what made it is not remembered
    assert flight.guard.counts["command is no number"] == 1


@pytest.mark.parametrize("raised", [ValueError("spring broke"), SystemExit(), SystemExit("enough")])
def test_a_controller_that_raises_or_exits_is_flown_back(
    flight: Flight, hovering: Make, raised: BaseException
) -> None:
    def fails(command: Command) -> Command:
        raise raised

    first, _ = flight.tick(hovering())
    flight.inner.given = fails
    second, _ = flight.tick(hovering())
    assert flight.guard.retreating
    assert flight.guard.failed == (str(raised) or "SystemExit")
    np.testing.assert_array_equal(second.thrusts, first.thrusts)


def test_a_command_beyond_the_limits_is_cut(flight: Flight, robot: Robot, hovering: Make) -> None:
    low, high = robot.thrust_limits()
    flight.inner.given = lambda command: command._replace(
        thrusts=np.array([-3.0, 99.0, 5.0, 6.0]), joint_angles=np.array([0.0, 9.0, -9.0])
    )
    command, _ = flight.tick(hovering())
    np.testing.assert_array_equal(command.thrusts, [low[0], high[1], 5.0, 6.0])
    bottom, top = robot.joint_limits()
    np.testing.assert_array_equal(command.joint_angles, [0.0, top[1], bottom[2]])
    flight.inner.given = lambda command: command._replace(thrusts=np.ones(3))
    assert flight.tick(hovering())[1]["tick_held"] == 1.0


def test_a_first_measurement_that_is_bad_gives_the_least_command(
    flight: Flight, robot: Robot, hovering: Make
) -> None:
    command, own = flight.tick(hovering(quaternion=np.zeros(4)))
    np.testing.assert_array_equal(command.thrusts, robot.thrust_limits()[0])
    assert np.isnan(own["ticks"])
    assert np.shape(own["vector"]) == (3,)
    assert flight.state == 0
    _, own = flight.tick(hovering())
    assert own["ticks"] == 1.0


def test_a_retreat_goes_back_then_down_and_stays() -> None:
    last = zero_reference(3, 4)._replace(
        position=np.array([1.0, 2.0, 1.5]), contact_axis=np.array([0.0, 1.0, 0.0]), touch=1.0, wait=1.0
    )
    end = BACK / BACK_SPEED
    assert retreat(last, 0.0, 0.3).position.tolist() == [1.0, 2.0, 1.5]
    half, down = retreat(last, end / 2, 0.3), retreat(last, end + 1.0, 0.3)
    np.testing.assert_allclose(half.velocity, [0.0, -BACK_SPEED, 0.0], atol=1e-12)
    np.testing.assert_allclose(down.position[:2], [1.0, 2.0 - BACK])
    np.testing.assert_allclose(down.velocity, [0.0, 0.0, -DESCENT], atol=1e-12)
    landed = retreat(last, 100.0, 0.3)
    assert landed.position[2] == pytest.approx(0.3)
    assert not landed.velocity.any()
    for reference in (half, down, landed):
        assert (reference.touch, reference.wait, reference.adapt, reference.tare) == (0.0, 0.0, 0.0, 0.0)
        np.testing.assert_allclose(reference.tip_position, reference.position - last.position)


@settings(max_examples=12)
@given(dt=st.floats(0.001, 0.05), tick=st.integers(1, 40), height=st.floats(0.2, 3.0))
def test_a_retreat_begins_where_it_was_and_never_jumps(
    robot: Robot, hovering: Make, dt: float, tick: int, height: float
) -> None:
    """At any period and tick of breaking, the reference moves at most by its speed times the period."""
    guard, state = GuardedController(Counting(robot), robot), 0
    q, psi = nominal_posture(robot, "torque")
    ticks = tick + round(3.0 / dt) if dt > 0.02 else tick + 100
    path = []
    for k in range(ticks):
        asked = zero_reference(3, 4)._replace(
            position=np.array([0.02 * min(k, tick), 0.0, height]),
            contact_axis=np.array([1.0, 0.0, 0.0]),
            joint_angles=q,
            vectoring_angles=psi,
        )
        if k == tick:
            guard.retreat("for the test")
        guard.taken(k * dt)
        state, _, _ = guard.step(None, state, noisy(hovering()), asked, dt)
        assert guard.flown is not None
        path.append(np.array(guard.flown.position))
        assert guard.retreating == (k >= tick)
    np.testing.assert_array_equal(path[tick], [0.02 * tick, 0.0, height])
    moved = np.abs(np.diff(path[tick:], axis=0))
    assert moved.max() <= max(BACK_SPEED, DESCENT) * dt * (1.0 + 1e-9)
    last = zero_reference(3, 4)._replace(position=path[tick], contact_axis=np.array([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(path[-1], retreat(last, (ticks - 1 - tick) * dt).position, atol=1e-9)


@pytest.mark.parametrize("name", ["hybrid", "following"])
def test_a_compiled_controller_is_the_controller(robot: Robot, hovering: Make, name: str) -> None:
    plain = skylimb.load_controller(name, robot)
    compiled = CompiledController(plain, DT)  # pyright: ignore[reportArgumentType]
    states, reference = [plain.initial_state(), compiled.initial_state()], zero_reference(3, 4)._replace(
        position=np.array([0.3, 0.0, 1.0]), reach=1.0, contact_axis=np.array([1.0, 0.0, 0.0]),
        sliding_axis=np.array([0.0, 1.0, 0.0]), joint_angles=hovering().joint_angles,
        vectoring_angles=hovering().vectoring_angles,
    )  # fmt: skip
    for k in range(3):
        seen = hovering(position=np.array([0.01 * k, 0.0, 1.0]))
        states[0], one, signals = plain.step(plain.gains(), states[0], seen, reference, DT)
        states[1], two, others = compiled.step(compiled.gains(), states[1], seen, reference, DT)
        for a, b in zip(one, two, strict=True):
            np.testing.assert_allclose(np.asarray(a, dtype=float).ravel(), b, atol=1e-9)
        assert dict(signals).keys() == dict(others).keys()
        assert np.shape(others["cog_position_estimate"]) == (3,)
