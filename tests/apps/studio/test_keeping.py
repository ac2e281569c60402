"""What is kept is what was flown: from its config.toml any driver gives the same bits again."""

import tomllib

import numpy as np
import pytest

import skylimb
from of_kind import of_kind
from skylimb.analysis.recording import load_runs
from skylimb.base.errors import ConfigError, OutputError
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.events import GainChange, Push, SurfaceChange
from skylimb.flight.flying import fly_here
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off
from told_session import Session

SIGNALS = (
    "configuration",
    "contact_force",
    "thrusts_command",
    "surface_gap",
    "surface_position",
    "contact_trace",
)


@pytest.fixture(scope="module")
def session(short, tmp_path_factory):
    """Gains, pokes, changes of the surface, a rewind into all of that and a branch from there."""
    session = Session(
        "paper", ("hybrid", "following"), set=short, seed=4, out=tmp_path_factory.mktemp("kept")
    )
    session.advance(150)
    session.set_key("controller.attitude.damping_ratio", [0.9, 0.9, 0.9])
    session.advance(20)
    session.poke("link4", [0.1, 0.0, 0.0], [0.0, 0.0, -1.0])
    session.advance(200)
    session.surface(position=[-0.005, 0.0, 0.0], tilt=[0.05, 0.02])
    session.release()
    session.advance(60)
    session.surface(friction=0.1, stiffness=2500.0)
    session.poke("link1", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    session.advance(50)
    session.surface(present=False)
    session.advance(30)
    session.rewind(session.live.time - 0.6)
    session.set_key("controller.attitude.damping_ratio", [1.1, 1.0, 1.0], 1)
    session.advance(7)
    session.surface(friction=0.3, tilt=[0.03, 0.0])
    session.advance(40)
    session.poke("link2", [0.0, 0.1, 0.0], [0.0, 0.7, 0.0])
    session.advance(33)
    return session


@pytest.fixture(scope="module")
def kept(session):
    kept = session.keep("first")
    kept.report.wait(timeout=120)
    return kept


@pytest.mark.parametrize("name", ["hybrid", "following"])
def test_a_kept_flight_is_repeated_to_the_bit_by_any_driver(session, kept, name):
    run = load_runs(kept.folder)[name]
    assert run.log.sizes["time"] == session.live.flights[0].ticks
    (takeoff,) = take_off(str(kept.folder / name / "config.toml"), (None,))
    experiment = takeoff.experiment
    assert len(of_kind(experiment, SurfaceChange)) == 2
    assert len(of_kind(experiment, Push)) == 2
    assert len(of_kind(experiment, GainChange)) == (2 if name == "following" else 1)
    for flight in (fly_here(takeoff), fly_native([takeoff])[0]):
        again = scored_run(takeoff, flight)
        assert again.cause == run.cause
        for signal in SIGNALS:
            assert np.array_equal(again.log[signal].values, run.log[signal].values, equal_nan=True), signal
    live = session.live.flights[["hybrid", "following"].index(name)]
    assert np.array_equal(run.log.configuration.values, live.recent[:, live.slices["configuration"]])


def test_a_kept_folder_has_the_preset_as_it_became_and_a_report(session, kept):
    preset = tomllib.loads((kept.folder / "following" / "preset.toml").read_text())
    assert preset["attitude"]["damping_ratio"] == [1.1, 1.0, 1.0]
    skylimb.load_runs(kept.folder)
    assert (kept.folder / "report.html").is_file()
    session.poll()
    events = session.events()
    assert [event["event"] for event in events if event["event"] in ("kept", "report")] == ["kept", "report"]
    configs = [kept.folder / name / "config.toml" for name in ("hybrid", "following")]
    assert kept.commands == tuple(f"skylimb run {config}" for config in configs)


def test_the_flights_go_on_after_they_were_kept(session, kept):
    before = session.live.flights[0].ticks
    assert session.advance(3) == 3
    assert session.live.flights[0].ticks == before + 3
    assert session.live.flights[0].experiment.stop_at is None


def test_a_kept_flight_says_that_it_was_stopped(kept):
    run = load_runs(kept.folder)["hybrid"]
    assert (run.status, run.failed, run.done, run.missed) == ("STOPPED", False, None, [])
    assert "stopped by its experiment (stop_at) at t = " in run.cause


@pytest.mark.parametrize("name", ["../out", "/etc/out", ".hidden", "a/b", "a" * 81, "a ", "a."])
def test_a_name_that_leads_out_of_the_folder_is_refused(session, name):
    with pytest.raises(ConfigError, match="letters, digits"):
        session.keep(name)


def test_nothing_that_was_kept_is_overwritten(session, kept):
    with pytest.raises(OutputError, match="exists"):
        session.keep("first")


def test_a_kept_flight_is_scored_as_far_as_it_flew_and_its_report_says_what_was_done(short, tmp_path):
    session = Session("paper", ("hybrid",), set=short, out=tmp_path)
    while session.live.flights[0].recent[-1, session.live.flights[0].slices["contact_duty"]] < 0.5:
        session.advance(10)
    session.advance(260)
    session.poke("link2", [0.0, 0.0, 0.0], [0.0, 0.25, 0.0])
    session.advance(40)
    session.release()
    session.set_key("controller.attitude.damping_ratio", 0.9, entry=0)
    session.advance(60)
    kept = session.keep("half")
    kept.report.wait(timeout=120)
    run = skylimb.Run.load(kept.folder)
    assert run.stopped
    assert run.metrics["contact_fraction"] > 0.9
    report = (kept.folder / "report.html").read_text()
    assert "was stopped by its experiment (stop_at) at t = " in report
    assert "STOPPED" in report
    for said in ("0.25 N on link2", "attitude.damping_ratio to [0.9"):
        assert said in report, said


def test_a_flight_that_has_just_begun_is_kept_and_flies_again(short, tmp_path):
    session = Session("paper", ("hybrid",), set=short, out=tmp_path)
    kept = session.keep()
    assert kept.mistake() == ""
    run = skylimb.Run.load(kept.folder)
    assert run.stopped
    assert run.log.sizes["time"] == 1
    again = skylimb.run(str(kept.folder / "config.toml"), str(kept.folder / "preset.toml"))
    np.testing.assert_array_equal(again.log.thrusts_command, run.log.thrusts_command)
