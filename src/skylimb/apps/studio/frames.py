"""What a page needs to show live flights: the scene once, and at every moment one flat row of numbers."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from skylimb.analysis.figures.scene import LIFT, dashes, eye_and_target, load_model, place_camera
from skylimb.analysis.scores.signals import direction
from skylimb.analysis.viewer.believed import believed_frame
from skylimb.analysis.viewer.packing import packed
from skylimb.analysis.viewer.shapes import OUT_OF_SIGHT, meshes, shapes_with_surface, thrust_sites
from skylimb.analysis.viewer.signals import SMOOTHING
from skylimb.apps.studio.curves import Moment, described_signals, panels_of
from skylimb.apps.studio.implied import implied_signals
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.base.rotations import quaternion_from_rotation
from skylimb.simulation.surface_state import state_of
from skylimb.simulation.surfaces.geom import BODY
from skylimb.simulation.surfaces.placement import surface_rotation

FLYING, ENDED, LOST = 0, 1, 2
"""State of a flight in a frame: it flies, came to its mission's end, or is lost."""

_PICTURE = (640, 360)


class FlightView:
    """One flight as a page sees it.

    Args:
        flight: that is shown.
        name: what it is called.
        colour: of its lines.
    """

    def __init__(self, flight: LiveFlight, name: str, colour: str) -> None:
        self.name = name
        self._flight, self._colour = flight, colour
        takeoff = flight.takeoff
        self._model = load_model(takeoff.plant.scene, _PICTURE)
        self._data = mujoco.MjData(self._model)
        recorded = {name: flight.recent[-1, part] for name, part in flight.slices.items()}
        self._implied = implied_signals(flight, flight.ticks, recorded)
        self._smoothed = max(1, round(SMOOTHING / takeoff.period))
        frame = takeoff.mission.frame
        named = ((frame.sliding_u, "u"), (frame.sliding_v, "v"), (frame.contact, "n"))
        self._axes = [direction(axis, name) for axis, name in named]
        self._panels = panels_of(flight, self._axes)
        body = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_BODY, BODY)
        self._surface = [self._model.nbody] if body < 0 else [body, self._model.nbody]
        self._turned = np.zeros((self._model.nbody + 1, 4))
        self._tilt: tuple[tuple[float, ...], np.ndarray] = (), np.zeros(4)

    def scene(self) -> dict[str, Any]:
        """Everything that does not change from moment to moment; lengths in m, forces in N, vectors in W."""
        surface, robot = self._flight.takeoff.plant.surface, self._flight.takeoff.robot
        mission, described = self._flight.takeoff.mission, surface.describe()
        camera = place_camera(mission.reference.position, mission.tip_path, np.array(described["normal"]))
        low, high = robot.thrust_limits()
        columns = np.cumsum([0, *(len(panel.curves) for panel in self._panels)])
        return {
            "name": self.name,
            "colour": self._colour,
            "controller": self._flight.takeoff.controller.name,
            "shapes": shapes_with_surface(
                self._model, np.asarray(surface.position, dtype=float), quaternion_from_rotation(surface.R_WS)
            ),
            "meshes": meshes(self._model),
            "bodies": self._model.nbody + 1,
            "body_names": [self._model.body(i).name for i in range(self._model.nbody)] + ["surface"],
            "rotors": thrust_sites(self._model),
            "thrust_limits": [list(map(float, low)), list(map(float, high))],
            "nominal": self._nominal(),
            "surface": {
                key: described[key] for key in ("kind", "origin", "axis_u", "axis_v", "normal", "size")
            },
            "camera": eye_and_target(camera),
            "frame": believed_frame(
                self._flight.takeoff.experiment.path_center,
                self._axes[-1],
                self._axes[:-1],
                described["size"],
            ),
            "panels": [panel.described(int(k)) for panel, k in zip(self._panels, columns, strict=False)],
            "signals": described_signals(self._flight, self._implied),
        }

    def _surface_pose(self, tick: int) -> tuple[np.ndarray, bool]:
        """Place and quaternion of the surface's axes in W at a tick, (7,); and whether it is there."""
        flight, surface = self._flight, self._flight.takeoff.plant.surface
        state = state_of(flight.surface[tick])
        turned = state.slope, state.pitch, state.roll
        if turned != self._tilt[0]:  # seldom, and it is a quarter of a frame's work
            R = surface_rotation(surface.contact_axis, *turned)
            self._tilt = turned, quaternion_from_rotation(R)
        slid = surface.motion(tick * flight.takeoff.period)[0] * surface.motion_axis
        return np.concatenate([state.position + slid, self._tilt[1]]), state.present > 0.0

    def values(self, ticks: int | None = None) -> dict[str, np.ndarray]:
        """The numbers of a moment by what they are, always as many and in the same order.

        Args:
            ticks: after which it comes; after all that were flown when None.
        """
        flight = self._flight
        ticks = flight.ticks if ticks is None else min(ticks, flight.ticks)
        rows, slices = flight.recent[:ticks], flight.slices
        recorded = {name: rows[-1, part] for name, part in slices.items()}
        implied = implied_signals(flight, ticks, recorded)
        signals = {**recorded, **implied}
        data = self._data
        data.qpos[:] = signals["configuration"]
        mujoco.mj_kinematics(self._model, data)
        recent = rows[-self._smoothed :]
        force = recent[:, slices["contact_force"]].mean(axis=0)
        estimate = np.full(3, np.nan)
        if "external_force_estimate" in slices:
            estimate = recent[:, slices["external_force_estimate"]].mean(axis=0)
        moment = Moment(signals, force, estimate)
        pose, present = self._surface_pose(ticks - 1)
        over = flight.over and ticks == flight.ticks
        state = FLYING if not over else LOST if flight.flight().cause else ENDED
        poses = np.vstack([np.hstack([data.xpos, data.xquat]), pose])
        if not present:
            poses[self._surface, 2] -= OUT_OF_SIGHT
        # A quaternion keeps its sign from moment to moment, so that one may interpolate.
        poses[:, 3:] *= np.where(np.sum(poses[:, 3:] * self._turned, axis=1) < 0.0, -1.0, 1.0)[:, None]
        self._turned = poses[:, 3:]
        curves = [curve.value(moment) for panel in self._panels for curve in panel.curves]
        return {
            "state": np.array([float(state)]),
            "poses": poses.ravel(),
            "thrusts": signals["thrusts"],
            "tip": signals["tip_position"],
            "force": force,
            "surface": pose,
            "present": np.array([float(present)]),
            "touching": signals["contact_duty"],
            "curves": np.array(curves),
            "signals": np.concatenate([rows[-1], *implied.values()]),
        }

    def _nominal(self) -> dict[str, Any]:
        """The path that is asked for, on the surface, in dashes; as the viewer has it."""
        takeoff = self._flight.takeoff
        mission, surface = takeoff.mission, takeoff.plant.surface
        points = dashes(mission.tip_path[mission.in_phase("slide")]).reshape(-1, 3)
        points = (
            points + surface.distance_along(points, mission.frame.contact)[:, None] * mission.frame.contact
        )
        ends = (points + LIFT * surface.normal(points)).reshape(-1, 6)
        ends = ends[np.isfinite(ends).all(axis=1)]
        return {"since": packed(np.zeros(len(ends))), "ends": packed(ends)}
