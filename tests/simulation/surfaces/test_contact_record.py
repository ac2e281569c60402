"""The record of a contact, against what every physics step said."""

import numpy as np
import pytest

from skylimb.simulation.surfaces import Board, SineWall
from skylimb.simulation.surfaces.contact_record import contact_gaps, record_contact
from skylimb.studies.verification.rig import Bench

TICK = 0.005


def slide(surface, press, speed, seconds):
    """The record of a tip that is drawn over a surface, and friction's work summed over every step."""
    bench = Bench(surface, gap=-press / surface.stiffness, servos="uv")
    bench.drive(push_w=press, speed_u=speed)
    _, normal = surface.local_closest(np.zeros(3))
    bench.launch(u=speed, w=-speed * normal[1] / normal[0])
    rows, work = [], 0.0
    for _ in range(round(seconds / TICK)):
        trace = bench.run(TICK)
        rows.append(
            (
                trace.time[0],
                *(trace.force.mean(axis=0) @ surface.R_WS.T),
                trace.duty,
                *surface.to_world(trace.position[0]),
                *(trace.velocity[0] @ surface.R_WS.T),
            )
        )
        _, normal = surface.local_closest(trace.position)
        across = trace.force - np.sum(trace.force * normal, axis=1, keepdims=True) * normal
        slip = trace.velocity - np.sum(trace.velocity * normal, axis=1, keepdims=True) * normal
        work -= float(np.sum(across * slip)) * bench.model.opt.timestep
    table = np.array(rows)
    return record_contact(
        surface, table[:, 0], table[:, 1:4], table[:, 4], table[:, 5:8], table[:, 8:11]
    ), work


@pytest.mark.parametrize("surface", [Board(slope=0.3, friction=0.5), SineWall(friction=0.5, slope=0.2)])
def test_forces_slip_and_work(surface):
    record, work = slide(surface, 1.0, 0.13, 2.0)
    settled = slice(100, None)
    tangential = np.linalg.norm(record["tangential_force"], axis=1)
    np.testing.assert_allclose(tangential[settled], 0.5 * record["normal_force"][settled], rtol=2e-3)
    assert record["friction_work"][-1] == pytest.approx(work, rel=5e-3)
    assert np.all(np.diff(record["friction_work"]) >= 0.0)
    np.testing.assert_allclose(np.sum(record["slip_velocity"] * record["normal"], axis=1), 0.0, atol=1e-12)
    gaps = contact_gaps(TICK * np.arange(len(tangential)), record["normal_force"] > 0.0, TICK)
    assert all(start < 0.2 for start, _ in gaps)  # none once it has settled


def test_friction_takes_as_much_where_every_second_tick_touches():
    """A tip at 0.1 m/s that drags with 0.5 N in every second tick."""
    count, surface = 20, Board()
    touching = np.arange(count) % 2 == 0
    u = surface.R_WS[:, 1]
    force, tip = np.outer(touching, -0.5 * u), np.tile(surface.position, (count, 1))
    velocity, times = np.tile(0.1 * u, (count, 1)), TICK * np.arange(count)
    record = record_contact(surface, times, force, touching.astype(float), tip, velocity)
    assert record["friction_work"][-1] == pytest.approx(0.5 * 0.1 * TICK * touching.sum(), rel=1e-12)
    assert not record["slip_velocity"][~touching].any()


def test_the_trace_is_as_long_as_the_way_on_the_surface():
    surface = SineWall()
    record, _ = slide(surface, 1.0, 0.13, 3.0)
    way = np.linalg.norm(record["slip_velocity"], axis=1).sum() * TICK
    assert np.nanmax(record["trace"][:, 0]) - np.nanmin(record["trace"][:, 0]) == pytest.approx(way, rel=5e-3)


def test_gaps_lie_between_touches():
    touching = np.array([0, 0, 1, 1, 0, 0, 0, 1, 0, 1, 0, 0], dtype=bool)
    time = 0.01 * np.arange(12)
    gaps = contact_gaps(time, touching, 0.01)
    np.testing.assert_allclose(gaps, [(0.04, 0.03), (0.08, 0.01)])
    assert contact_gaps(time, np.zeros(12, dtype=bool), 0.01) == []
