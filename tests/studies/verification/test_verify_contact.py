"""The whole suite: every row holds, its page is written, and it can fail."""

import json
import math

import numpy as np
import pytest

from skylimb.base.errors import OutputError
from skylimb.studies.verification import Row, verify_contact
from skylimb.studies.verification import rig as rig_module
from skylimb.studies.verification.impact import spring_damper_restitution
from skylimb.studies.verification.row import worst
from skylimb.studies.verification.sliding import kept_contact, kinetic_friction
from skylimb.studies.verification.statics import creep, static_indentation
from skylimb.studies.verification.stick_slip import Belt
from skylimb.studies.verification.suite import ROWS


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    out = tmp_path_factory.mktemp("verify") / "contact"
    seen = []
    with pytest.MonkeyPatch.context() as patch:  # what is drawn is looked at, not how finely
        patch.setattr("skylimb.studies.verification.figures._DPI", 40)
        rows = verify_contact(out, progress=lambda *state: seen.append(state))
    return rows, out, seen


NAMES = [measure.__name__ for measure in ROWS]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_claim_holds(written, name):
    row = next(row for row in written[0] if row.name == name)
    assert row.passed, row


@pytest.mark.slow
def test_page_figures_and_numbers_are_written(written):
    rows, out, seen = written
    assert [row.name for row in rows] == NAMES
    page = (out / "contact.html").read_text()
    records = json.loads((out / "rows.json").read_text())
    assert len(records) == len(rows)
    for row, record in zip(rows, records, strict=True):
        assert row.figure == f"{row.name}.png"
        assert (out / row.figure).read_bytes().startswith(b"\x89PNG")
        assert f'src="{row.figure}"' in page
        assert record["passed"] is True
    assert f"{len(rows)} of {len(rows)} claims hold" in page
    assert seen[-1] == (len(ROWS), len(ROWS), "")


def test_an_existing_folder_is_not_written_over(tmp_path):
    with pytest.raises(OutputError, match="exists already"):
        verify_contact(tmp_path)


def test_the_suite_fails_with_the_engines_own_contact(monkeypatch):
    monkeypatch.setattr(rig_module, "tune_tool", lambda model, parameters, foot: None)
    for measure in (kept_contact, static_indentation, creep):
        assert not measure().row.passed, measure.__name__


def test_the_suite_fails_when_friction_is_off_by_a_hundredth(monkeypatch):
    def tune(model, parameters, foot):
        original(model, parameters, foot)
        model.pair_friction[0, :2] *= 1.01

    original = rig_module.tune_tool
    monkeypatch.setattr(rig_module, "tune_tool", tune)
    assert not kinetic_friction().row.passed


@pytest.mark.parametrize(
    ("measured", "bound", "passed"),
    [
        (1.0, "", True),
        (1.2, "", False),
        (0.2, "below", True),
        (1.2, "below", False),
        (5.0, "above", True),
        (0.2, "above", False),
        (math.nan, "below", False),
    ],
)
def test_a_row_passes_on_the_right_side_only(measured, bound, passed):
    assert Row("name", "claim", measured, 1.0, 0.1, "-", bound=bound).passed is passed


def test_the_worst_case_is_the_farthest_and_a_nan_is_farther():
    assert worst(np.array([1.0, 1.4, 0.8]), 1.0) == (1.4, 1.0)
    measured, _ = worst(np.array([1.0, np.nan, 9.0]), 1.0)
    assert math.isnan(measured)


def test_restitution_without_damping_is_one_and_falls_with_it():
    values = [spring_damper_restitution(zeta) for zeta in (1e-6, 0.1, 0.5, 0.99, 1.0, 1.5)]
    assert values[0] == pytest.approx(1.0, abs=1e-4)
    assert np.all(np.diff(values) < 0)
    assert values[3] == pytest.approx(values[4], abs=5e-3)


def test_the_belts_equations_slip_at_the_static_limit():
    belt = Belt()
    _, place = belt.solve(6.0)
    assert place.max() > 0.3 * 1.5 * 4.0 / 40.0  # a little beyond it, as it takes time to turn back
    assert place.max() < 0.3 * 1.5 * 4.0 / 40.0 * 1.1
