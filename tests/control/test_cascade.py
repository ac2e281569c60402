"""The pipeline: what goes from slot to slot, what is kept, and what the loop may ask of it."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from law_records import hover
from skylimb.base.errors import ConfigError
from skylimb.base.rotations import rotation_from_rpy
from skylimb.control.cascade import Cascade
from skylimb.control.controller import cascade_from_tables, is_traceable, resolved_tables
from skylimb.control.estimation.records import Start, Wrench
from skylimb.control.laws.preset import preset_mapping, preset_names
from skylimb.control.laws.slots import SLOTS, Slot, Slots, find_law, law_names
from skylimb.control.needs import Needs, merged, needs_of
from skylimb.robots.model import Robot

DT = 0.005


@pytest.fixture(scope="module")
def cascades(robot: Robot) -> dict[str, Cascade]:
    return {name: cascade_from_tables(*preset_mapping(name), robot) for name in preset_names()}


def numbers(value: Any) -> np.ndarray:
    return np.ravel(np.asarray(value, dtype=float))


@pytest.mark.parametrize("name", preset_names())
def test_at_rest_on_its_reference_it_hovers(cascades: dict[str, Cascade], name: str) -> None:
    cascade = cascades[name]
    measurement, reference = hover(cascade)
    gains = cascade.gains()
    state, _, _ = cascade.step(gains, cascade.initial_state(), measurement, reference, DT)
    state, command, signals = cascade.step(gains, state, measurement, reference, DT)
    model = cascade.robot.at(measurement.joint_angles, measurement.vectoring_angles)
    np.testing.assert_allclose(numbers(signals["force_command"]), model.mass * model.gravity, atol=1e-6)
    np.testing.assert_allclose(numbers(signals["torque_command"]), 0.0, atol=1e-6)
    np.testing.assert_allclose(numbers(command.thrusts), model.hover_thrusts, atol=1e-5)
    np.testing.assert_allclose(numbers(command.joint_angles), measurement.joint_angles, atol=1e-12)
    # A law that moves the angles about the posture's goes on towards more thrust margin.
    moving = 4.0 * 2.0 * DT if needs_of(cascade).moves > 0.0 else 1e-3
    np.testing.assert_allclose(numbers(command.vectoring_angles), measurement.vectoring_angles, atol=moving)
    assert isinstance(state, Slots)


def recording(kept: dict[str, list[Any]], name: str, law: Any) -> Any:
    """The law, and everything that it is given and gives."""

    def step(*given: Any) -> Any:
        found = law.step(*given)
        kept.setdefault(name, []).append((given, found))
        return (*found[:2], {**found[2], f"of_{name}": 1.0})

    return SimpleNamespace(**{**vars(law), "step": step})


def test_each_law_gets_its_own_gains_and_state_and_what_came_before_it(cascades: dict[str, Cascade]) -> None:
    cascade, kept = cascades["following"], {}
    for name in SLOTS:
        slot = getattr(cascade.preset.slots, name)
        law = recording(kept, name, slot.law)
        cascade = replace(cascade, preset=cascade.preset.with_slot(name, replace(slot, law=law)))
    measurement, reference = hover(cascade)
    moved = measurement._replace(position=measurement.position + np.array([0.1, -0.05, 0.02]))
    gains, state = cascade.gains(), cascade.initial_state()
    for seen in (measurement, moved):
        before = state
        state, command, signals = cascade.step(gains, state, seen, reference, DT)
    assert list(kept) == list(SLOTS)
    last = {name: calls[-1] for name, calls in kept.items()}
    for name, (given, found) in last.items():
        assert given[0] is getattr(gains, name)
        assert given[1] is getattr(before, name)
        assert signals[f"of_{name}"] == 1.0
        if name != "estimation":  # which is told the command once more
            assert getattr(state, name) is found[0]
    estimate, view, arm = (last[name][1][1] for name in ("estimation", "contact", "shape"))
    assert last["estimation"][0][2] == (cascade.robot, moved, reference, DT)
    inputs = {name: given[2] for name, (given, _) in last.items()}
    for name in SLOTS[1:]:
        assert inputs[name][:4] == (cascade.robot, moved, reference, DT)
        assert inputs[name].estimate.body is estimate.body
    assert inputs["shape"].contact.anchor is view.anchor
    assert inputs["translation"].arm.rate is arm.rate
    force, demand = last["translation"][1][1], last["allocation"][0][3]
    np.testing.assert_allclose(numbers(demand.force), numbers(force) - numbers(estimate.bias.force))
    torque = numbers(last["attitude"][1][1])
    np.testing.assert_allclose(numbers(demand.torque), torque - numbers(estimate.bias.torque))
    assert command is last["allocation"][1][1].command
    low, high = last["shape"][0][3]
    assert (low, high) == (cascade.family.reach_min, cascade.family.reach_max)


def biased(cascade: Cascade, force: np.ndarray, torque: np.ndarray, scale: float = 1.0) -> dict[str, Any]:
    """Signals of a tick at rest where the rotors have to make up a bias, and a scale of all thrusts."""
    slot, (measurement, reference) = cascade.preset.slots.estimation, hover(cascade)

    def step(*given: Any) -> Any:
        state, estimate, signals = slot.law.step(*given)
        return state, estimate._replace(bias=Wrench(force, torque), scale=scale), signals

    gives = (*slot.law.PROVIDES, "estimate.bias", "estimate.scale")
    law = SimpleNamespace(**{**vars(slot.law), "step": step, "PROVIDES": gives})
    made = replace(cascade, preset=cascade.preset.with_slot("estimation", replace(slot, law=law)))
    return made.step(made.gains(), made.initial_state(), measurement, reference, DT)[2]


def test_a_bias_is_made_up_for_and_the_aimed_force_sets_the_attitude(cascades: dict[str, Cascade]) -> None:
    cascade, none = cascades["impedance"], np.zeros(3)
    force, torque = np.array([0.4, -0.2, 0.1]), np.array([0.05, 0.02, -0.03])
    plain = biased(cascade, none, none)
    pushed, turned = biased(cascade, force, none), biased(cascade, none, torque)
    found = numbers(pushed["force_command"])
    np.testing.assert_allclose(found, numbers(plain["force_command"]) - force)
    yaw = float(pushed["attitude_estimate"][2])
    roll, pitch, _ = numbers(pushed["attitude_target"])
    target = rotation_from_rpy(roll, pitch, yaw)
    np.testing.assert_allclose(target[:, 2], found / np.linalg.norm(found), atol=1e-9)
    np.testing.assert_allclose(
        numbers(turned["torque_command"]), numbers(plain["torque_command"]) - torque, atol=1e-9
    )


def test_thrusts_that_give_less_are_asked_for_more_bias_and_all(cascades: dict[str, Cascade]) -> None:
    cascade, force, torque = cascades["impedance"], np.array([0.4, -0.2, 0.1]), np.array([0.05, 0.02, -0.03])
    plain, weak = (biased(cascade, force, torque, scale) for scale in (1.0, 0.8))
    for name in ("force_command", "torque_command"):
        np.testing.assert_allclose(0.8 * numbers(weak[name]), numbers(plain[name]), atol=1e-9)


def test_the_tilt_gives_what_does_not_leak(cascades: dict[str, Cascade]) -> None:
    cascade = cascades["impedance"].with_gains({"allocation.leak.compensate": True})
    measurement, reference = hover(cascade)
    state, leak = cascade.initial_state(), np.array([0.5, -0.3, 0.0])
    leaking = state._replace(allocation=state.allocation._replace(leak=leak))
    plain, found = (
        cascade.step(cascade.gains(), each, measurement, reference, DT)[2] for each in (state, leaking)
    )
    aimed = numbers(found["force_command"])
    np.testing.assert_allclose(aimed, numbers(plain["force_command"]) - leak, atol=1e-12)
    roll, pitch, _ = numbers(found["attitude_target"])
    up = rotation_from_rpy(roll, pitch, float(found["attitude_estimate"][2]))[:, 2]
    np.testing.assert_allclose(up, aimed / np.linalg.norm(aimed), atol=1e-9)


def test_the_observer_knows_the_wrench_that_the_allocation_gives(cascades: dict[str, Cascade]) -> None:
    """Thrusts that saturate are known to the observer as they are."""
    cascade = cascades["impedance"]
    measurement, reference = hover(cascade)
    high = reference._replace(position=np.array([0.0, 0.0, 50.0]))
    state, command, _ = cascade.step(cascade.gains(), cascade.initial_state(), measurement, high, DT)
    most = cascade.robot.description.rotors[0].thrust_max
    assert numbers(command.thrusts).max() == most
    model = cascade.robot.at(measurement.joint_angles, measurement.vectoring_angles)
    lift = (model.allocation_C @ numbers(command.thrusts))[:3] - model.mass * model.gravity
    np.testing.assert_allclose(numbers(state.estimation.observer.known_force), lift, atol=1e-6)


def test_needs_of_laws_are_merged(cascades: dict[str, Cascade]) -> None:
    assert cascades["hybrid"].needs == Needs()
    assert cascades["following"].needs == Needs(
        paced=True, vectoring="contact", force=1.0, moves=0.5, supervised=True
    )
    assert needs_of(cascades["following"]) is not None
    assert merged([Needs(preview=(0.1,)), Needs(), Needs(paced=True)]) == Needs(True, (0.1,))
    assert merged([Needs(preview=(0.1,)), Needs(preview=(0.1,))]).preview == (0.1,)
    assert merged([Needs(force=2.0), Needs(moves=0.1), Needs(force=1.0)]) == Needs(force=2.0, moves=0.1)
    assert merged([Needs(preview=(0.1, 0.3)), Needs(preview=(0.2,))]).preview == (0.1, 0.2, 0.3)


def test_a_control_period_that_a_law_cannot_work_at_is_refused(cascades: dict[str, Cascade]) -> None:
    cascades["following"].require(DT)
    cascades["hybrid"].require(1e-4)
    with pytest.raises(ConfigError, match=r"estimation\.delay\.latency"):
        cascades["following"].require(0.0005)


class Own:
    """A controller that nobody can trace."""

    name = "own"

    def gains(self) -> None: ...

    def initial_state(self) -> None: ...

    def step(self, gains: Any, state: Any, measurement: Any, reference: Any, dt: float) -> Any: ...


def test_what_can_be_traced_is_known_by_what_it_has(cascades: dict[str, Cascade]) -> None:
    assert is_traceable(cascades["pid"])
    assert not is_traceable(Own())
    assert needs_of(Own()) == Needs()
    assert resolved_tables(Own()) == {"name": "own"}
    tables = resolved_tables(cascades["hybrid"])
    assert list(tables) == ["name", "description", *SLOTS]
    assert tables["shape"] == {
        "law": "admittance", "mass": 40.0, "damping": 55.0, "stiffness": 16.0, "force_reference": 0.0
    }  # fmt: skip


def test_the_structure_is_what_is_baked_in(cascades: dict[str, Cascade], robot: Robot) -> None:
    def made(**changes: Any) -> Any:
        mapping, path = preset_mapping("hybrid")
        return cascade_from_tables(mapping, path, robot, changes).structure()

    assert made() == cascades["hybrid"].structure()
    assert hash(made()) == hash(cascades["hybrid"].structure())
    assert made(**{"shape.stiffness": 20.0}) == made()
    for change in (
        {"estimation.tare": False},
        {"allocation.leak.compensate": True},
        {"allocation.vectoring.purpose": "contact"},
        {"estimation.law": "predictive"},
    ):
        assert made(**change) != made(), change


def test_gains_are_checked_like_those_of_a_file(cascades: dict[str, Cascade]) -> None:
    cascades["hybrid"].check_gain("shape.stiffness", 20.0, "here", DT)
    with pytest.raises(ConfigError, match=r"^here: shape\.stiffness"):
        cascades["hybrid"].check_gain("shape.stiffness", -20.0, "here", DT)


def test_every_law_that_ships_follows_the_protocol(robot: Robot, cascades: dict[str, Cascade]) -> None:
    start = Start(robot, 1.09, np.zeros(4))
    functions = {"estimation": ("step", "commanded"), "allocation": ("step", "aim")}
    for slot in SLOTS:
        for name in law_names(slot):
            law: Any = find_law(slot, name, None)  # type: ignore[arg-type]
            assert all(callable(getattr(law, one)) for one in functions.get(slot, ("step",)))
            used = [getattr(made.preset.slots, slot) for made in cascades.values()]
            gains = next((one.gains for one in used if one.name == name), None)
            law.initial_state(law.Gains() if gains is None else gains, start)


@dataclass(frozen=True)
class NoGains:
    """Nothing to choose."""


def test_a_slot_asks_its_law_what_it_needs_and_requires() -> None:
    asking = SimpleNamespace(Gains=NoGains, needs=lambda gains: Needs(paced=True))
    assert Slot("a", asking, NoGains()).needs.paced
    assert Slot("b", SimpleNamespace(), NoGains()).needs == Needs()
    Slot("b", SimpleNamespace(), NoGains()).require(DT)
