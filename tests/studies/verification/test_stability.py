import numpy as np
import pytest
from scipy.linalg import expm

import skylimb
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.control.cascade import Cascade
from skylimb.studies.verification.stability import (
    ClosedLoop,
    OperatingPoint,
    at,
    edge,
    flown_growth,
    linearise,
    operating_point,
    stability_map,
)
from skylimb.studies.verification.stability.plant import tangent_map

REST = {
    "surface.friction": 0.0,
    "trajectory.shape": "hold",
    "phases.hover": 0.5,
    "phases.tare": 0.5,
    "sensors.latency": 0.02,
}


def controller(name: str) -> Cascade:
    loaded = skylimb.load_controller(name, skylimb.load_robot("hydrus_xi_quad"))
    assert isinstance(loaded, Cascade)
    return loaded


@pytest.fixture(scope="module")
def point() -> OperatingPoint:
    return operating_point(skylimb.load_experiment("paper", REST), controller("following"))


@pytest.fixture(scope="module")
def loop(point: OperatingPoint) -> ClosedLoop:
    return linearise(point)


def oscillator(damping: float) -> ClosedLoop:
    """x'' = -4 pi^2 x - damping x', beside a clock that nobody reads and a constant that nobody writes."""
    A = np.array([[0.0, 1.0], [-4.0 * np.pi**2, -damping]])
    matrix = np.eye(4)
    matrix[:2, :2] = expm(0.005 * A)
    matrix[2, 0], matrix[1, 3] = 1.0, 1.0
    return ClosedLoop(matrix, ("position x", "velocity x", "clock", "constant"), 2, 0.005)


def test_an_oscillator_has_its_own_frequency_and_damping() -> None:
    loop = oscillator(0.4)
    (mode,) = loop.modes()
    assert mode.growth == pytest.approx(-0.2)
    assert mode.frequency == pytest.approx(1.0, rel=1e-3)
    assert mode.damping_ratio == pytest.approx(0.2 / (2.0 * np.pi), rel=1e-3)
    assert loop.stable
    assert not oscillator(-0.4).stable
    assert {name for name, _ in mode.parts} == {"position x", "velocity x"}


def test_what_is_not_in_the_loop_is_not_judged() -> None:
    loop = oscillator(0.4)
    assert loop.in_loop.tolist() == [True, True, False, False]
    assert loop.neutral == 0


def test_a_quaternion_turns_at_half_the_angle(point: OperatingPoint) -> None:
    G = tangent_map(point.plant.model, point.qpos)
    assert G.shape == (14, 13)
    assert np.linalg.norm(G[3:7, 3:6], axis=0) == pytest.approx([0.5] * 3, rel=1e-6)
    assert point.qpos[3:7] @ G[3:7, 3:6] == pytest.approx([0.0] * 3, abs=1e-7)
    assert G[7:, 6:] == pytest.approx(np.eye(7), abs=1e-6)


def test_the_preset_is_stable_at_rest_and_flies_as_its_modes_say(
    point: OperatingPoint, loop: ClosedLoop
) -> None:
    assert loop.stable
    modes = loop.modes(12)
    assert any(mode.frequency > 0.5 for mode in modes)
    for mode in modes:
        assert flown_growth(point, loop, mode) == pytest.approx(mode.growth, rel=0.02)


def test_clocks_and_means_are_outside_of_the_loop(loop: ClosedLoop) -> None:
    inside = {name for name, member in zip(loop.names, loop.in_loop, strict=True) if member}
    assert "controller.translation.press.integral" in inside
    assert "velocity joint2" in inside
    assert not [name for name in inside if name.startswith(("clock", "controller.estimation.tare"))]
    assert "controller.contact.machine.since" not in inside


def test_flights_on_both_sides_of_an_edge(point: OperatingPoint) -> None:
    axis = "latency"
    limit = edge(point, axis, 0.02, 0.08, steps=5)
    for factor, grows in ((0.85, False), (1.15, True)):
        there = at(point, axis, factor * limit)
        loop = linearise(there)
        swing = max((mode for mode in loop.modes(20) if mode.frequency > 0.0), key=lambda mode: mode.growth)
        flown = flown_growth(there, loop, swing)
        assert loop.stable is not grows
        assert (flown > 0.0) is grows
        assert flown == pytest.approx(swing.growth, rel=0.02)


def test_a_surface_of_another_stiffness_pushes_as_hard(point: OperatingPoint) -> None:
    stiff = at(point, "stiffness", 50e3)
    indentations = [-there.data().contact[0].dist for there in (point, stiff)]
    assert indentations[0] / indentations[1] == pytest.approx(10.0, rel=1e-6)
    before, after = (there.data().qacc for there in (point, stiff))
    assert after == pytest.approx(before, abs=1e-3)


def test_a_map_has_the_axes_asked_for(point: OperatingPoint, loop: ClosedLoop) -> None:
    axes = {"known latency": [0.02], "x translation.press_damping": [1.0, 20.0]}
    found = stability_map(point, axes)
    assert found.growth.dims == tuple(axes)
    assert found.growth.shape == (1, 2)
    assert float(found.growth[0, 0]) == pytest.approx(loop.growth, rel=1e-6)
    assert float(found.growth[0, 1]) > 0.0


@pytest.mark.parametrize("name", ["impedance", "hybrid"])
def test_the_papers_presets_can_be_linearised(name: str) -> None:
    loop = linearise(operating_point(skylimb.load_experiment("paper", REST), controller(name)))
    assert loop.stable
    assert loop.modes(1)[0].growth == pytest.approx(loop.growth, rel=1e-6)


def test_mistakes_are_named(point: OperatingPoint) -> None:
    with pytest.raises(UnknownNameError, match=r"translation\.press_damping"):
        at(point, "translation.press_dampin", 1.0)
    with pytest.raises(ConfigError, match="latency"):
        at(point, "latency", 0.5)
    with pytest.raises(ConfigError, match="edge needs"):
        edge(point, "latency", 0.01, 0.02)
    with pytest.raises(ConfigError, match="at least one axis"):
        stability_map(point, {})
    moving = skylimb.load_experiment("paper", {**REST, "surface.advance_distance": 0.05})
    with pytest.raises(ConfigError, match="moves"):
        operating_point(moving, controller("hybrid"))


def test_where_a_path_rests_no_clock_moves_anything() -> None:
    """The derivative of its speed's length was no number there, in 140 entries."""
    hover = operating_point(skylimb.load_experiment("paper", REST), controller("following"), 0.25)
    loop = linearise(hover)
    assert np.isfinite(loop.matrix).all()
    others = [not name.startswith("clock.") for name in loop.names]
    for name in ("clock.ticks", "clock.pace"):
        assert not loop.matrix[others, loop.names.index(name)].any()
    ticks, pace = loop.names.index("clock.ticks"), loop.names.index("clock.pace")
    assert loop.matrix[ticks, ticks] == pytest.approx(1.0)
    assert not loop.in_loop[[ticks, pace]].any()
