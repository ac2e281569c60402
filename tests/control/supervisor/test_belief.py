"""Poses that come, fail to come, stay as they are or are refused: when the model's takes their place."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.records import Imu, Measurement
from skylimb.control.missions.reference import zero_reference
from skylimb.control.records import Command
from skylimb.control.supervisor.halves import Halves
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Flags
from skylimb.control.supervisor.table import TABLE

DT, WARM = 0.005, 200
ROBOT = skylimb.load_robot("hydrus_xi_quad")
NORMAL, COAST = 0.0, float(list(TABLE.modes).index("COAST"))
HOVER = Command(np.full(4, ROBOT.weight / 4.0), ROBOT.nominal_posture(), np.zeros(4))


class Hover:
    """A robot at rest, seen with a sensor's noise whenever a frame comes."""

    def __init__(self, imu: bool = False) -> None:
        self.imu, self.halves = imu, Halves(ROBOT, Limits(), 0, DT, imu=imu)
        self.rng = np.random.default_rng(0)
        self.reference = zero_reference(3, 4)._replace(
            position=np.array([0.0, 0.0, 1.0]), contact_axis=np.array([1.0, 0.0, 0.0])
        )
        self.seen = self.frame()

    def frame(self, away: float = 0.0) -> Measurement:
        """Another frame, that shows the robot elsewhere by so much, m."""
        small = 1e-3 * self.rng.standard_normal((3, 3))
        angles = ROBOT.nominal_posture(), np.zeros(4)
        place = np.array([away, 0.0, 1.0]) + small[0]
        level = np.array([1.0, 0.0, 0.0, 0.0])
        return Measurement(place, level, small[1], small[2], *angles, capture_age=0.01)

    def modes(
        self, comes: Iterable[bool], away: float = 0.0, frozen: bool = False, land: bool = False
    ) -> list[float]:
        """The mode of each tick, at which a frame comes or not."""
        found = []
        for new in comes:
            if new and not frozen:
                self.seen = self.frame(away)
            if self.imu:
                said = Imu(self.rng.standard_normal(3), self.rng.standard_normal(3))
                self.seen = self.seen._replace(imu=said)
            self.halves.look(Flags(pose=float(new), land=float(land)), self.seen, self.reference)
            self.halves.act(HOVER)
            found.append(self.halves.mode)
        return found


def every(ticks: int, count: int = WARM) -> list[bool]:
    """A frame every so many ticks."""
    return [k % ticks == 0 for k in range(count)]


@pytest.mark.parametrize("ticks", [1, 2, 4, 5, 7, 8])
def test_frames_that_come_as_usual_are_no_alarm_and_one_may_be_missed(ticks: int) -> None:
    hover = Hover()
    assert set(hover.modes(every(ticks))) == {NORMAL}
    missed = [*every(ticks, ticks), *[False] * ticks, *every(ticks, 4 * ticks)]
    assert set(hover.modes(missed * 3)) == {NORMAL}


def test_frames_of_100_hz_are_missed_after_20_ms() -> None:
    hover = Hover()
    hover.modes(every(2))
    modes = hover.modes([True, *[False] * 10])
    # The next frame is due after two ticks; the second one that does not come is no chance.
    assert modes == [NORMAL] * 5 + [COAST] * 6
    assert hover.modes([True, False]) == [NORMAL, NORMAL]


def test_after_a_long_loss_the_next_one_is_seen_as_soon() -> None:
    hover = Hover()
    hover.modes([*every(2), *[False] * 100, *every(2, 40)])
    assert hover.modes([True, *[False] * 5]) == [NORMAL] * 5 + [COAST]


@pytest.mark.parametrize("away", [0.06, 0.08, np.nan, 1.5])
def test_a_pose_that_is_not_believed_is_not_flown_by_from_its_first_tick_on(away: float) -> None:
    hover = Hover()
    hover.modes(every(2))
    assert set(hover.modes(every(2, 20), away)) == {COAST}
    assert set(hover.modes(every(2, 20))) == {NORMAL}


@pytest.mark.parametrize("angle", [0.3, 0.4, 0.9, 2.0, -0.5])
@pytest.mark.parametrize("axis", [1, 2, 3])
def test_a_capture_that_turns_is_believed_by_and_by_but_no_tilt_that_nobody_saw(
    axis: int, angle: float
) -> None:
    """Markers that changed places tilted a hovering robot, which was then flown by that attitude or cut."""
    hover = Hover()
    hover.modes(every(2))
    q = np.array([np.cos(0.5 * angle), 0.0, 0.0, 0.0])
    q[axis] = np.sin(0.5 * angle)
    modes = []
    for _ in range(round(1.5 / DT)):
        hover.halves.look(Flags(), hover.frame()._replace(quaternion=q), hover.reference)
        hover.halves.act(HOVER)
        modes.append(hover.halves.mode)
    names = [list(TABLE.modes)[int(mode)] for mode in dict.fromkeys(modes)]
    assert names == (["COAST", "NORMAL"] if axis == 3 else ["COAST", "DESCEND", "CUT"])
    if axis != 3:
        assert (modes.index(float(list(TABLE.modes).index("CUT"))) + 1) * DT == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("height", [0.5, 1.0, 4.9])
def test_a_descent_has_the_time_that_its_height_needs(height: float) -> None:
    limits = Limits(descend_for=0.5)
    halves, rng = Halves(ROBOT, limits, 0, DT, imu=True), np.random.default_rng(0)
    hover = Hover()
    reference = hover.reference._replace(position=np.array([0.0, 0.0, height]))
    modes, imu = [], Imu(np.zeros(3), np.zeros(3))
    for k in range(round((height / 0.3 + 2.0) / DT)):
        # The IMU says nothing new from the first second on; the pose is seen all along.
        if k * DT < 1.0:
            imu = Imu(rng.standard_normal(3), rng.standard_normal(3))
        place = np.array([0.0, 0.0, height])
        halves.look(
            Flags(),
            hover.frame()._replace(imu=imu, position=place + 1e-4 * rng.standard_normal(3)),
            reference,
        )
        halves.act(HOVER)
        modes.append(list(TABLE.modes)[int(halves.mode)])
    assert list(dict.fromkeys(modes)) == ["NORMAL", "DESCEND", "CUT"]
    assert modes.count("DESCEND") * DT == pytest.approx(height / 0.3 + 0.5, abs=0.02)


@pytest.mark.parametrize("odd", [np.nan, np.inf, 1e13])
@pytest.mark.parametrize(
    ("name", "ends"),
    [("pose", "CUT"), ("joints", "RETREAT"), ("late", "RETREAT"), ("land", "RETREAT"), ("stop", "CUT")],
)
def test_what_is_told_and_is_no_number_is_the_worse_of_both(name: str, ends: str, odd: float) -> None:
    hover = Hover()
    hover.modes(every(2))
    flags = Flags()._replace(**{name: odd})
    for _ in range(round(1.2 / DT)):
        hover.halves.look(flags, hover.frame(), hover.reference)
        hover.halves.act(HOVER if name != "late" else None)
    assert list(TABLE.modes)[int(hover.halves.mode)] == ends


def test_poses_that_do_not_differ_by_a_bit_are_none_whatever_their_stamps_say() -> None:
    hover = Hover()
    hover.modes(every(2))
    modes = hover.modes(every(2, 20), frozen=True)
    # Its own two ticks count, too.
    assert (modes.index(COAST) + 2) * DT == pytest.approx(0.055)
    assert set(modes[modes.index(COAST) :]) == {COAST}
    # A pose that comes at every second tick is seen at both.
    assert set(Hover().modes([True] * 4, frozen=True)) == {NORMAL}


@pytest.mark.parametrize("frozen", [True, False])
def test_what_stands_in_for_poses_goes_on_from_the_last_one_that_was_another(frozen: bool) -> None:
    """A frozen capture is believed for 50 ms, and the robot was believed to be where it was then."""
    hover, speed = Hover(), np.array([0.0, 0.5, 0.0])
    for k in range(5 * WARM):
        if k % 2 == 0:
            frame = hover.frame()
            hover.seen = frame._replace(position=DT * k * speed + [0.0, 0.0, 1.0], velocity=speed)
        hover.halves.look(Flags(pose=float(k % 2 == 0)), hover.seen, hover.reference)
        hover.halves.act(HOVER)
    last, far = 5 * WARM - 2, []
    for k in range(5 * WARM, 5 * WARM + 20):
        hover.halves.look(Flags(pose=float(frozen and k % 2 == 0)), hover.seen, hover.reference)
        hover.halves.act(HOVER)
        far.append(hover.halves.sight.measurement.position[1] - DT * last * speed[1])
    assert far[1] == pytest.approx(0.0, abs=2e-3)
    first = 11 if frozen else 4
    np.testing.assert_allclose(far[first:], (np.arange(first, 20) + 2) * DT * 0.5, atol=4e-3)
    assert far[-1] == pytest.approx(21 * DT * 0.5, abs=4e-3)


@pytest.mark.parametrize("axis", [1, 2, 3])
def test_a_robot_that_is_seen_to_have_tipped_over_stops(axis: int) -> None:
    """About its contact axis or across it; a heading may be any."""
    hover, cut = Hover(), float(list(TABLE.modes).index("CUT"))
    hover.modes(every(2))
    lean, modes = 0.04 * np.arange(1, 30), []
    for angle in lean:
        q = np.array([np.cos(0.5 * angle), 0.0, 0.0, 0.0])
        q[axis] = np.sin(0.5 * angle)
        frame = hover.frame()
        rates = frame.angular_velocity + np.eye(3)[axis - 1] * 0.04 / DT
        seen = frame._replace(quaternion=q, angular_velocity=rates)
        hover.halves.look(Flags(), seen, hover.reference)
        hover.halves.act(HOVER)
        modes.append(hover.halves.mode)
    assert modes == [NORMAL if axis == 3 or angle < Limits().upset_at else cut for angle in lean]


def test_nobody_stops_for_a_lean_that_is_the_model_s() -> None:
    hover = Hover()
    hover.modes(every(2))
    hover.modes([False] * 10)
    place = hover.halves._made.watch.slices["prediction.motion.quaternion"]
    hover.halves._state[place] = [np.cos(0.6), np.sin(0.6), 0.0, 0.0]
    assert hover.modes([False]) == [COAST]


@pytest.mark.parametrize("imu", [False, True])
def test_who_flies_back_by_an_imu_is_not_turned_to_where_the_model_has_gone_astray(imu: bool) -> None:
    """A blind robot turned to where its model believed it to be, half a radian off, and was lost."""
    hover = Hover(imu)
    hover.modes([*every(2), *[False] * 40])
    hover.modes([False] * 2, land=True)
    place = hover.halves._made.watch.slices["prediction.motion.quaternion"]
    hover.halves._state[place] = [np.cos(0.5), 0.0, 0.0, np.sin(0.5)]
    assert hover.modes([False]) == [float(list(TABLE.modes).index("RETREAT"))]
    turned = hover.halves.sight.reference.heading - hover.reference.heading
    assert turned == pytest.approx(0.0 if imu else 0.7, abs=0.02)


def test_a_memory_of_zeros_commands_no_more_than_the_controller() -> None:
    """As that of exported C that nobody has reset: no rotor is believed to have lost all of its thrust."""
    hover = Hover()
    hover.halves._state[:] = 0.0
    hover.halves.look(Flags(), hover.frame(), hover.reference)
    np.testing.assert_array_equal(hover.halves.act(HOVER)[0].thrusts, HOVER.thrusts)


def test_bits_are_one_or_zero_whatever_the_memory_holds() -> None:
    hover = Hover()
    hover.halves._state[:] = 17.3
    hover.halves.look(Flags(), hover.frame(), hover.reference)
    assert set(hover.halves.sight.bits) <= {0.0, 1.0}


def test_a_robot_that_descends_is_as_level_as_before_whatever_its_vectoring_angles_are() -> None:
    """Of the way past a servo that runs away: at its end the rotors give no yaw, and {C} is on its side."""
    q, first = np.array([-1.07, -1.03, 0.5]), np.array([-2.6, 1.6, 2.65, -1.95])
    last = np.array([-4.92, -0.44, -2.07, -3.8])
    assert np.arccos(ROBOT.at(q, last).R_root_C[2, 2]) > 1.3
    halves = Halves(ROBOT, Limits(losses=True), 0, DT, imu=False)
    rng, reference, found = np.random.default_rng(0), Hover().reference, []
    for psi in [*[first] * WARM, *np.linspace(first, last, 2 * WARM)]:
        noise = 1e-3 * rng.standard_normal((3, 3))
        place, level = np.array([0.0, 0.0, 1.0]) + noise[0], np.array([1.0, 0.0, 0.0, 0.0])
        seen = Measurement(place, level, noise[1], noise[2], q, psi, capture_age=0.01)
        found.append(halves.look(Flags(pose=1.0), seen, reference).body.R_WC[2, 2])
        halves.act(Command(np.full(4, ROBOT.weight / 4.0), q, psi))
    assert halves.mode == list(TABLE.modes).index("DESCEND")
    assert np.arccos(found).max() < 0.15
