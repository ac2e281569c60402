"""Where a flight is linearised: the state that it has at a moment of a mission, without noise."""

from __future__ import annotations

import copy
import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from skylimb.base.errors import ConfigError, UnreachableError, unknown_name
from skylimb.base.packing import Layout
from skylimb.control.controller import TraceableController, require_compiled
from skylimb.control.loop.terminations import Terminations
from skylimb.control.missions.mission import Mission
from skylimb.flight.drivers.compiled import CompiledDriver
from skylimb.flight.experiments.experiment import Experiment, experiment_with, robot_of
from skylimb.flight.takeoff import prepare
from skylimb.simulation.plant import Plant
from skylimb.simulation.rows import FlightRows
from skylimb.simulation.tick import CompiledTick

LONGEST_LATENCY = 0.10
"""Greatest true latency that a point's sensor history goes back for, s."""

_NOISE = (
    *("position", "velocity", "attitude", "angular_velocity", "joint", "vectoring"),
    *("imu.gyro", "imu.accelerometer"),
)
_BIAS = ("sensors.imu.gyro_bias_drawn", "sensors.imu.accelerometer_bias_drawn")


@dataclass(frozen=True)
class OperatingPoint:
    """Plant and controller at a moment of a flight.

    Attributes:
        plant: what flies; its model has the stiffness of the experiment's surface.
        tick: sensors and controller, with a history long enough for every latency up to `LONGEST_LATENCY`.
        names: what each entry of the tick's state is.
        gains: flat gains of the controller.
        qpos, qvel, act: MuJoCo's state.
        state: flat state of the tick.
        row: what is known of a tick beforehand: age of the frame, no noise.
        mission: packed references of every tick of the mission, and copies of the last one.
        last: the mission's last tick.
        ticks: ticks of the mission so far, for a controller that follows the flight's clock.
        period: s.
        held: a body's number and the wrench on it that stays, force at its centre of mass, W, (6,); or None.
    """

    plant: Plant
    tick: CompiledTick
    names: tuple[str, ...]
    gains: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray
    act: np.ndarray
    state: np.ndarray
    row: np.ndarray
    mission: np.ndarray
    last: int
    ticks: int
    period: float
    held: tuple[int, np.ndarray] | None = None

    @property
    def references(self) -> np.ndarray:
        """The mission's rows that the tick reads now."""
        return self.mission[self.at : self.at + self.tick.window.rows]

    @property
    def at(self) -> int:
        """The mission's whole tick."""
        clock = self.tick.clock
        return min(self.ticks if clock is None else int(self.state[clock]), self.last)

    @cached_property
    def controls(self) -> np.ndarray:
        """What the tick does to the plant here: controls, then joint forces, (nu + nv,)."""
        data = self.data()
        _, controls, _, forces = self.tick.function(
            self.state, data.qpos, data.qvel, data.act, data.history, self.row, self.references.ravel(),
            self.gains, self.tick.rotors,
        )  # fmt: skip
        return np.concatenate([np.asarray(controls), np.asarray(forces)]).ravel()

    def gain(self, name: str) -> np.ndarray:
        """A gain of the controller by its dotted name, flat."""
        return self.gains[self._slice(name)]

    def with_gains(self, changes: dict[str, Any]) -> OperatingPoint:
        """The same state under other gains, by their dotted names ("translation.press_damping")."""
        gains = self.gains.copy()
        for name, value in changes.items():
            gains[self._slice(name)] = value
        return dataclasses.replace(self, gains=gains)

    def with_latency(self, latency: float) -> OperatingPoint:
        """The same state, seen as late as this, s."""
        if not 0.0 <= latency <= LONGEST_LATENCY:
            raise ConfigError(f"latency = {latency:g} s is not within 0 .. {LONGEST_LATENCY:g} s")
        row = self.row.copy()
        row[self.tick.rows.slices["age"]] = latency
        return dataclasses.replace(self, row=row)

    def data(self) -> mujoco.MjData:
        """MuJoCo's data in this state."""
        data = mujoco.MjData(self.plant.model)
        data.qpos[:], data.qvel[:], data.act[:] = self.qpos, self.qvel, self.act
        if self.held is not None:
            data.xfrc_applied[self.held[0]] = self.held[1]
        mujoco.mj_forward(self.plant.model, data)
        return data

    def driver(self, data: mujoco.MjData, ticks: int, state: np.ndarray | None = None) -> CompiledDriver:
        """A driver that flies on from here.

        Args:
            data: of the plant; it is advanced.
            ticks: how many at most.
            state: flat state of the tick to begin with; the point's own when None.
        """
        tick = dataclasses.replace(self.tick, state=self.state if state is None else state, gains=self.gains)
        references = self.mission[self.at :]
        # Beyond the mission's end the last reference stays.
        references = np.vstack([references, np.repeat(references[-1:], ticks + 1, axis=0)])
        rows = FlightRows(np.tile(self.row, (ticks, 1)), references, len(references) - 1)
        return CompiledDriver(tick, self.plant, data, rows, start=self.at)

    def _slice(self, name: str) -> slice:
        slices = self.tick.gains_layout.slices
        if name not in slices:
            raise unknown_name("gain", name, slices)
        return slices[name]


def quiet(experiment: Experiment) -> Experiment:
    """The experiment without noise and with a frame at every tick, so that time has no mark."""
    noise = dict.fromkeys([*(f"sensors.{name}_noise" for name in _NOISE), *_BIAS], 0.0)
    return experiment_with(experiment, {**noise, "sensors.rate": 0.0})


def operating_point(
    experiment: Experiment, controller: TraceableController, at: float | None = None
) -> OperatingPoint:
    """Fly to a moment of a mission and stop there.

    Args:
        experiment: what to fly; its noise is left out.
        controller: one that can be traced.
        at: the moment on the mission's clock, s; the middle of the slide when None.

    Raises:
        UnreachableError: when the flight does not get there.
        ConfigError: when the mission has no such moment, or something acts on it that a linearisation at one
            moment cannot know: a surface that moves, or friction that varies.
    """
    require_compiled(controller, "linearised")
    # Without a fault the supervisor changes nothing; its clocks and predictions are no states of this loop.
    experiment = experiment_with(quiet(experiment), {"supervisor.on": False})
    takeoff = prepare(experiment, robot_of(experiment), controller)
    plant, mission = _without_rest(takeoff.plant), takeoff.mission
    if plant.surface.moves or plant.surface.friction_varies:
        raise ConfigError(
            f"surface '{plant.surface.kind}' moves or its friction varies; a linearisation needs one that "
            "does neither"
        )
    at = _middle_of_slide(mission) if at is None else at
    if not 0.0 < at < mission.times[-1]:
        raise ConfigError(f"at = {at:g} s is outside of the mission, 0 .. {mission.times[-1]:g} s")
    late = takeoff.changed(experiment_with(experiment, {"sensors.latency": LONGEST_LATENCY}))
    names = state_names(late.initial_tick_state)
    data, tick = takeoff.data(), late.tick
    point = OperatingPoint(
        plant, tick, names, tick.gains.copy(), data.qpos.copy(), data.qvel.copy(), data.act.copy(),
        tick.state.copy(), takeoff.rows.ticks[0], takeoff.rows.references, takeoff.rows.last, 0,
        takeoff.period,
    )  # fmt: skip
    return _fly(point, data, len(takeoff.rows), at, experiment.terminations)


def _without_rest(plant: Plant) -> Plant:
    """The plant whose pen meets no friction at all, where none is asked for.

    The engine keeps a coefficient of 1e-5, and what small friction holds still in the small slides in the
    large: the slowest modes would be others in a flight.
    """
    if plant.surface.contact.friction > 0.0:
        return plant
    model = copy.copy(plant.model)
    model.pair_dim[:] = 1
    return dataclasses.replace(plant, model=model)


def _fly(
    point: OperatingPoint, data: mujoco.MjData, most: int, at: float, limits: Terminations
) -> OperatingPoint:
    tick, driver, clock = point.tick, point.driver(data, most), 0.0
    for k in range(most):
        state = driver.state(k)
        if clock * point.period >= at - 1e-9:
            return dataclasses.replace(
                point,
                qpos=data.qpos.copy(),
                qvel=data.qvel.copy(),
                act=data.act.copy(),
                state=state.copy(),
                ticks=k,
            )
        driver.tick(k)
        upright = 1.0 - 2.0 * (data.qpos[4] ** 2 + data.qpos[5] ** 2)
        if not (np.isfinite(driver.state(k + 1)).all() and upright > np.cos(limits.tilt)):
            raise UnreachableError(f"the flight is lost at t = {k * point.period:.3f} s, before {at:g} s")
        clock = k + 1.0 if tick.clock is None else float(driver.state(k + 1)[tick.clock])
    raise UnreachableError(
        f"the controller holds the mission back: it is at {clock * point.period:.3f} s of {at:g} s"
    )


def state_names(initial: Any) -> tuple[str, ...]:
    """A name for each entry of a tick's flat state."""
    layout = Layout(initial)
    heads = ("sensors", "controller", "clock", "rates")
    names = []
    for path, part in layout.slices.items():
        head, _, rest = path.partition(".")
        count = part.stop - part.start
        name = f"{heads[int(head)]}.{rest}"
        names += [f"{name}[{i}]" if count > 1 else name for i in range(count)]
    return tuple(names)


def _middle_of_slide(mission: Mission) -> float:
    slide = np.flatnonzero(mission.in_phase("slide"))
    if not len(slide):
        raise ConfigError("the mission has no slide; say at which moment to linearise")
    return float(mission.times[slide[len(slide) // 2]])
