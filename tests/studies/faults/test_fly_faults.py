"""A small catalogue, flown: the table says what the flights' rows say; a folder goes on where it was left."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from short_flights import HOLD
from skylimb.apps.cli import main
from skylimb.base.errors import OutputError
from skylimb.studies.campaign.distributions import Distribution
from skylimb.studies.campaign.flight_queue import FlightQueue, Interrupted
from skylimb.studies.campaign.fly_campaign import report_campaign
from skylimb.studies.faults import Outcome, fly_faults
from skylimb.studies.faults.catalogue import CATALOGUE, Catalogue, Fault
from skylimb.studies.faults.page import Row, faults_page

NO_THRUST = {"kind": "rotor", "time": 1.0, "effectiveness": 0.0}
PUSH = {"kind": "push", "time": 1.0, "latest": 1.2, "duration": 0.1, "force": [0.0, 1.0, 0.0]}
SMALL = Catalogue(
    experiment="paper",
    controllers=("hybrid",),
    seed=3,
    set=HOLD,
    vary={"surface.slope": Distribution(choice=(0.3, -0.3))},
    faults=(
        Fault("no thrust", "It falls.", {"events": [NO_THRUST]}, bounds={"tilt": (0.2, 0.3)}),
        Fault("a push", "It moves.", {"events": [PUSH]}, bounds={"sideways": (0.1, 0.2), "seen": (0.1, 0.1)}),
    ),
)


@pytest.fixture(scope="module", autouse=True)
def _no_campaigns_reports() -> Iterator[None]:
    """What stands here is the catalogue's page; that of each campaign is looked at where campaigns are."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skylimb.studies.campaign.report.render_report", lambda *_: "")
        yield


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    return fly_faults(tmp_path_factory.mktemp("faults") / "out", 2, catalogue=SMALL, workers=0)


def unprotected(outcome: Outcome) -> list[Row]:
    return [row for row in outcome.rows if not row.supervised]


def test_the_table_says_what_the_flights_rows_say(flown: Outcome) -> None:
    assert flown.complete
    assert flown.flown == flown.total == 8
    fell, moved = unprotected(flown)
    assert (fell.flights, fell.survived, fell.within) == (2, 0, 0)
    assert fell.numbers == {"tilt": (None, None)}
    assert "hit the floor" in fell.cause or "lost" in fell.cause
    assert (moved.flights, moved.survived, moved.within) == (2, 2, 2)
    rows = report_campaign(flown.folder / "unprotected" / "a-push").rows.values()
    assert moved.numbers == {"sideways": tuple(sorted(row["fault_sideways"] for row in rows))}
    assert not fell.reached(SMALL.faults[0])
    assert moved.reached(SMALL.faults[1])
    for row in flown.rows:
        assert (flown.folder / row.worst / "log.nc").is_file()
    assert json.loads((flown.folder / "faults.json").read_text())[0]["fault"] == "no thrust"


def test_an_interrupted_catalogue_says_how_to_go_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*arguments: object) -> None:
        raise Interrupted

    monkeypatch.setattr(FlightQueue, "fly", stopped)
    out = str(tmp_path / "my faults")
    words = ["--controllers", "hybrid", "pid", "--only", "rotor at half", "push of 4 N"]
    words += ["--catalogue", str(CATALOGUE), "--draws", "3", "--workers", "0"]
    assert main(["faults", "--out", out, *words]) == 130
    said = capsys.readouterr().out.splitlines()
    assert said[0] == f"interrupted: 0 of 24 flights are kept in {out}; to go on:"
    command = shlex.split(said[1])
    assert command == ["skylimb", "faults", "--out", out, "--resume", *words]
    assert main(command[1:]) == 130


def test_the_page_has_every_fault_with_its_bounds(flown: Outcome) -> None:
    page = (flown.folder / "faults.md").read_text(encoding="utf-8")
    assert page == faults_page(SMALL, flown.rows)
    assert "Not outlived by every supervised flight: no thrust." in page
    assert "## No thrust\n\nIt falls.\n" in page
    assert "tilt rad (0.2 / 0.3)" in page
    assert "| hybrid, unprotected | 0 of 2 | 0 of 2 | - / - |" in page


def test_a_bound_is_missed_by_median_or_by_what_99_percent_keep(flown: Outcome) -> None:
    row, fault = unprotected(flown)[1], replace(SMALL.faults[1], bounds={"sideways": (0.1, 0.2)})
    cases = ((0.1, 0.2), True), ((0.11, 0.2), False), ((0.1, 0.21), False), ((0.1, None), False)
    for numbers, kept in cases:
        assert replace(row, numbers={"sideways": numbers}).reached(fault) is kept
    assert not replace(row, survived=1).reached(fault)
    assert replace(row, survived=1).reached(replace(fault, survived=False))


def test_a_folder_goes_on_where_it_was_left(flown: Outcome) -> None:
    with pytest.raises(OutputError, match="--resume goes on"):
        fly_faults(flown.folder, 2, catalogue=SMALL, workers=0)
    again = fly_faults(flown.folder, 2, catalogue=SMALL, workers=0, resume=True)
    assert again.rows == flown.rows


def test_a_fault_that_is_flown_alone_leaves_the_others_in_the_table(tmp_path: Path) -> None:
    folder, (fell, moved) = tmp_path / "out", SMALL.faults
    alone = fly_faults(folder, 1, catalogue=SMALL, only=[moved.name], workers=0)
    both = fly_faults(folder, 2, catalogue=SMALL, only=[fell.name], workers=0, resume=True)
    assert both.flown == both.total == 4
    assert [row.fault for row in both.rows] == [fell.name] * 2 + [moved.name] * 2
    assert both.rows[2:] == alone.rows
    assert [row["fault"] for row in json.loads((folder / "faults.json").read_text())] == [
        row.fault for row in both.rows
    ]
    # Held to today's bounds, also where it was not flown today.
    harder = replace(SMALL, faults=(fell, replace(moved, bounds={"sideways": (1e-6, 1e-6)})))
    rows = fly_faults(folder, 2, catalogue=harder, only=[fell.name], workers=0, resume=True).rows
    assert [row.within for row in rows] == [0] * 4
    # What was flown as another fault than it is now says nothing of it.
    other = replace(SMALL, faults=(fell, replace(moved, set={"events": [{**PUSH, "duration": 0.2}]})))
    rows = fly_faults(folder, 2, catalogue=other, only=[fell.name], workers=0, resume=True).rows
    assert {row.fault for row in rows} == {fell.name}


def test_the_verb_shows_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.toml"
    lines = [f'"{key}" = {json.dumps(value)}' for key, value in HOLD.items()]
    text = 'experiment = "paper"\ncontrollers = ["hybrid"]\n[set]\n' + "\n".join(lines)
    file.write_text(f'{text}\n[[faults]]\nname = "nothing"\nphysics = "Nothing."\n', encoding="utf-8")
    out = tmp_path / "out"
    assert (
        main(["faults", "--catalogue", str(file), "--draws", "1", "--workers", "0", "--out", str(out)]) == 0
    )
    assert "hybrid, unprotected" in capsys.readouterr().out
    assert (out / "faults.md").is_file()


def test_what_a_flight_moves_by_itself_is_no_faults_doing(tmp_path: Path) -> None:
    nothing = replace(SMALL.faults[1], set={"events": [{**PUSH, "force": [0.0, 0.0, 0.0]}]})
    still = replace(SMALL, faults=(replace(nothing, bounds={"tip": (0.0, 0.0), "sideways": (0.0, 0.0)}),))
    rows = fly_faults(tmp_path / "out", 2, catalogue=still, workers=0).rows
    assert [row.numbers["tip"] for row in rows] == [(0.0, 0.0)] * 2
    assert all(row.reached(still.faults[0]) for row in rows)
