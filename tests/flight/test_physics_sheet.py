"""The sheet of an experiment's physics says what acts."""

import mujoco
import numpy as np
import pytest

from skylimb.flight.physics_sheet import physics_sheet, tip_mass
from skylimb.flight.takeoff import take_off


def lines(name: str, **given: object) -> dict[str, str]:
    (takeoff,) = take_off(name, ("hybrid",), set=given)
    return {line.what: line.value for line in physics_sheet(takeoff)}


def test_the_papers_board() -> None:
    found = lines("paper")
    assert found["damping that acts"] == "53.56 N s/m"
    assert found["damping ratio that acts"] == "0.369 free, 0.228 held"
    assert found["rotors"] == "50 ms"
    assert found["joint2"] == "-1.57 .. 1.57 rad"
    assert found["drag of the rotors, blade flapping"] == "at most 0.3 N"


def test_air_that_acts_on_the_rotors_is_no_longer_missing() -> None:
    given = {"plant.rotor_drag": 0.2, "plant.wall_pull": 0.1}
    (takeoff,) = take_off("paper", ("hybrid",), set=given)
    found = {line.what: line for line in physics_sheet(takeoff)}
    drag, wall = found["drag of the rotors, blade flapping"], found["inflow beside a wall"]
    assert (drag.group, drag.value) == ("air", "0.2 1/s")
    assert (wall.group, wall.value) == ("air", "0 of its thrust lost, 0.1 toward the wall")


def test_the_mass_is_that_which_a_push_meets() -> None:
    """The tip's acceleration under a push, by the engine, less that without."""
    (takeoff,) = take_off("paper", ("hybrid",))
    model, normal = takeoff.plant.model, takeoff.experiment.surface.R_WS[:, 0]
    site = model.site("tip").id
    speeds = []
    for push in (0.0, 1.0):
        data = takeoff.data()
        body = int(model.site_bodyid[site])
        point = data.site_xpos[site].copy()
        mujoco.mj_applyFT(model, data, push * normal, np.zeros(3), point, body, data.qfrc_applied)
        mujoco.mj_forward(model, data)
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jacSite(model, data, jacobian, None, site)
        speeds.append(float(normal @ jacobian @ data.qacc_smooth))
    assert tip_mass(takeoff, held=False) == pytest.approx(1.0 / (speeds[1] - speeds[0]), rel=1e-9)
    assert tip_mass(takeoff, held=True) > 2.0 * tip_mass(takeoff, held=False)


def test_rotors_with_a_speed_and_stops_with_a_stiffness() -> None:
    given = {"plant.rotors": "speed", "plant.joint_stop_stiffness": 500.0}
    (takeoff,) = take_off("paper", ("hybrid",), set=given)
    found = {line.what: line for line in physics_sheet(takeoff)}
    assert found["inertia"].value == "0.0002 kg m^2"
    assert found["motor torque at most"].value == "0.8 N m"
    assert found["joint1"].note == "500 N m/rad, 1 N m s/rad"
    assert found["zero of lift and torque"].value.startswith("+")


def test_a_flight_without_contact_has_no_contact() -> None:
    assert not any("mass" in what for what in lines("free_flight"))


def test_an_imu_whose_place_no_file_says_is_said_to_be_assumed() -> None:
    (known,), (assumed,) = (
        take_off(name, ("pid",), set={"sensors.imu.on": True}) for name in ("paper", "board_hydrus_xi_hex")
    )
    notes = [
        next(line.note for line in physics_sheet(takeoff) if "IMU" in line.what)
        for takeoff in (known, assumed)
    ]
    assert notes[0] == "on link flight_controller"
    assert notes[1].startswith("on link link1, at its origin: assumed")
