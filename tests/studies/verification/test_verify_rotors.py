"""Every claim about rotors holds, and fails where the physics is wrong."""

import pytest

from skylimb.simulation import plant_tick
from skylimb.studies.verification import rotors, verify_rotors


@pytest.mark.parametrize("measure", rotors.ROWS, ids=lambda measure: measure.__name__)
def test_every_claim_holds(measure):
    row = measure().row
    assert row.passed, row


def test_page_and_figures_are_written(tmp_path, monkeypatch):
    monkeypatch.setattr(rotors, "ROWS", (rotors.speed_step, rotors.reaction))
    rows = verify_rotors(tmp_path / "out")
    page = (tmp_path / "out" / "rotors.html").read_text()
    assert "Rotors against theory" in page
    assert "2 of 2 claims hold" in page
    assert all((tmp_path / "out" / f"{row.name}.png").is_file() for row in rows)


def test_claims_fail_without_the_reaction(monkeypatch):
    original = plant_tick.momentum_forces
    monkeypatch.setattr(plant_tick, "momentum_forces", lambda *given: 0.99 * original(*given))
    for measure in (rotors.reaction, rotors.precession, rotors.wheel):
        assert not measure().row.passed, measure.__name__
