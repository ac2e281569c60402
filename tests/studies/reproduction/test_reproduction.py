"""The pipeline on a tiny ensemble, and the parts of its result on made-up tables."""

import importlib.util
import json
import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skylimb.analysis.paper.claims import CLAIMS
from skylimb.analysis.paper.numbers import PUBLISHED
from skylimb.analysis.scores.measures import fitted_circle
from skylimb.analysis.scores.registry import SETS
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError, OutputError, SkylimbError
from skylimb.studies.campaign.draws import draw
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.reproduction import Prior, load_prior, reproduce
from skylimb.studies.reproduction.judging import judge
from skylimb.studies.reproduction.otherwise import flown_otherwise
from skylimb.studies.reproduction.prior import PRIOR
from skylimb.studies.reproduction.sensitivity import (
    beyond_chance,
    correlations,
    shown_unknowns,
    unknown_columns,
)

REPOSITORY = Path(__file__).parents[3]
COMMITTED = REPOSITORY / "docs" / "reproduction.json"

SHORT = {
    "phases.hover": 0.5,
    "phases.tare": 0.5,
    "phases.settle": 0.5,
    "phases.hover_end": 0.1,
    "trajectory.period": 2.0,
    "approach.speed": 0.3,
    "approach.retreat_speed": 0.5,
}
"""A hurried flight; its numbers mean nothing."""


@pytest.fixture(scope="module")
def short_prior() -> Prior:
    prior = load_prior()
    return replace(prior, _plain={**prior._plain, "set": {**prior._plain["set"], **SHORT}})


@pytest.fixture(scope="module")
def tiny(short_prior: Prior, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tiny") / "reproduction"
    assert reproduce(folder, 3, workers=0, prior=short_prior, errata=False).result is not None
    return folder


def test_a_tiny_ensemble_leaves_everything(tiny: Path) -> None:
    content = json.loads((tiny / "reproduction.json").read_text())
    assert content["draws"] == 3
    assert content["flights"] == 12
    assert [number["paper"] for number in content["numbers"][:4]] == [0.134, 0.079, 0.105, 0.083]
    assert len(content["numbers"]) == 16
    assert content["numbers"][-1]["paper"] is None
    assert {claim["name"] for claim in content["claims"]} == set(CLAIMS)
    assert all(claim["all_draws"]["draws"] == 3 for claim in content["claims"])
    assert sum(entry["count"] for entry in content["failures"].values()) + sum(
        number["flights"] for number in content["numbers"][:4]
    ) == 12  # fmt: skip
    assert {path.name for path in (tiny / "figures").iterdir()} >= {
        "numbers.png",
        "claims.png",
    }
    assert not (tiny / "figures" / "sensitivity.pdf").exists()
    page = (tiny / "report.html").read_text()
    assert "0.134" in page
    assert "surface.friction" in page
    assert "http" not in page
    assert "with 3 draws no unknown" in page


@pytest.mark.slow
def test_neither_workers_nor_an_interruption_change_the_result(
    tiny: Path, short_prior: Prior, tmp_path: Path
) -> None:
    """Two processes, begun with what another run left of it."""
    folder = tmp_path / "again"
    reproduce(folder, 3, workers=2, prior=short_prior, errata=False)
    assert (folder / "reproduction.json").read_bytes() == (tiny / "reproduction.json").read_bytes()
    assert (folder / "flights.parquet").read_bytes() == (tiny / "flights.parquet").read_bytes()
    (folder / "reproduction.json").unlink()
    reproduce(folder, 3, workers=0, prior=short_prior, resume=True, errata=False)
    assert (folder / "reproduction.json").read_bytes() == (tiny / "reproduction.json").read_bytes()


def test_a_folder_is_neither_overwritten_nor_mistaken(tiny: Path, short_prior: Prior, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="exists already"):
        reproduce(tiny, 3, workers=0, prior=short_prior)
    with pytest.raises(OutputError, match="holds no reproduction"):
        reproduce(tmp_path, 3, workers=0, prior=short_prior, resume=True)
    with pytest.raises(OutputError, match="begun with another"):
        reproduce(tiny, 4, workers=0, prior=short_prior, resume=True)


def test_the_prior_says_why_and_can_be_flown() -> None:
    prior = load_prior()
    assert all(len(unknown.reason) > 20 for unknown in prior.unknowns)
    assert {"branch of psi", "sign of the slope"} <= {entry.name for entry in prior.kept}
    campaign = freeze(prior.campaign(64))
    varied = {unknown.key for unknown in prior.unknowns}
    assert {"surface.friction", "approach.depth", "trajectory.direction", "surface.slope"} <= varied
    assert {"sensors.latency", "plant.thrust_scale", "plant.rotor_scale"} <= varied
    assert campaign.names == tuple(PUBLISHED)


def test_what_all_draws_fly_otherwise_than_the_paper_is_said(short_prior: Prior, tiny: Path) -> None:
    """The declared unknowns are what the ensemble is about; whatever else differs stands on the page."""
    prior = load_prior()
    otherwise = [found.key for found in flown_otherwise(prior, freeze(prior.campaign(1)))]
    assert otherwise == ["approach.standoff", "plant.rotors"]
    moved = replace(prior, _plain={**prior._plain, "set": {"surface.position": [1.4, 0.0, 1.2]}})
    (found,) = flown_otherwise(moved, freeze(moved.campaign(1)))
    assert str(found) == "surface.position = [1.4, 0, 1.2] (paper: [1.5, 0, 1.2])"
    curved = replace(prior, _plain={**prior._plain, "experiment": "sine_gentle"})
    assert "surface.kind" in {found.key for found in flown_otherwise(curved, freeze(curved.campaign(1)))}
    assert "trajectory.period = 2 (paper: 14)" in (tiny / "report.html").read_text()


def test_gains_go_to_those_that_have_them() -> None:
    campaign = freeze(load_prior().campaign(4))
    drawn = campaign.draw(1)
    assert "translation.proportional" in campaign.gains_of(drawn, "pid")
    assert "translation.proportional" not in campaign.gains_of(drawn, "impedance")
    assert "estimation.tare" in campaign.gains_of(drawn, "impedance")


def test_one_factor_scales_a_list() -> None:
    spec = load_prior().campaign(32)
    for index in range(32):
        gains = np.array(draw(spec, index).values["controller.translation.proportional"])
        factors = gains / [2.3, 2.3, 3.6]
        np.testing.assert_allclose(factors, factors[0])
        assert 1 / 1.5 <= factors[0] <= 1.5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[unknown."surface.friction"]\nuniform = [0.1, 0.2]\n', "no reason"),
        ('[unknown."surface.friction"]\nuniform = [0.2, 0.1]\nreason = "because"\n', "lower to the higher"),
        ('[unknwon."surface.friction"]\n', "unknown"),
    ],
)
def test_a_prior_that_does_not_hold_is_refused(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "prior.toml"
    path.write_text(f'experiment = "paper"\ncontrollers = ["pid"]\n{text}')
    with pytest.raises(SkylimbError, match=message):
        load_prior(path)


def test_only_names_gains_and_controllers_that_exist(tmp_path: Path) -> None:
    path = tmp_path / "prior.toml"
    path.write_text(
        'experiment = "paper"\ncontrollers = ["pid"]\n[unknown."controller.estimation.tare"]\n'
        'choice = [true, false]\nreason = "because"\ncontrollers = ["hybird"]\n'
    )
    with pytest.raises(ConfigError, match="hybird"):
        load_prior(path).campaign(2)


def test_the_printed_numbers_satisfy_what_the_paper_says_of_them() -> None:
    printed = {name: vars(numbers) for name, numbers in PUBLISHED.items()}
    told = [claim for claim in CLAIMS.values() if set(claim.keys) <= set(printed["pid"])]
    assert len(told) >= 8
    assert all(claim.holds(printed) for claim in told)


def table(short_prior: Prior, draws: int) -> tuple[Any, dict[int, dict[str, Any]]]:
    """A made-up ensemble in which every flight finishes with the paper's numbers."""
    campaign = freeze(short_prior.campaign(draws))
    rows = {}
    for index in range(draws):
        for place, name in enumerate(campaign.names):
            numbers = dict.fromkeys(campaign.spec.keys, 0.1 + 0.01 * place) | vars(PUBLISHED[name])
            rows[campaign.flight(index, place)] = {
                "draw": index, "controller": name, "status": "OK", "cause": "", **numbers
            }  # fmt: skip
    return campaign, rows


def test_a_loss_counts_against_every_claim_that_needs_it(short_prior: Prior) -> None:
    campaign, rows = table(short_prior, 10)
    lost = rows[campaign.flight(3, 1)]
    lost |= {"status": "FAILED", "cause": "lost position: more than 2 m from the reference at t = 9.000 s"}
    result = judge(short_prior, campaign, rows)
    claims = {judged.claim.name: judged for judged in result.claims}
    resists = claims["impedance resists friction"]
    assert (resists.rate.successes, resists.rate.draws) == (9, 10)
    assert (resists.finished.successes, resists.finished.draws) == (9, 9)
    assert claims["admittance below PID in x"].rate.successes == 10
    assert result.failures["impedance"] == {"lost position: more than 2 m from the reference": 1}
    impedance = next(n for n in result.numbers if (n.controller, n.key) == ("impedance", "error_u_median"))
    assert impedance.ours.flights == 9
    assert impedance.inside
    assert impedance.percentile == 50.0
    assert result.inside == 12


def test_an_interval_that_misses_the_paper_says_so(short_prior: Prior) -> None:
    campaign, rows = table(short_prior, 10)
    for row in rows.values():
        if row["controller"] == "hybrid":
            row["estimated_force_median"] = -0.5 - 0.01 * row["draw"]
    result = judge(short_prior, campaign, rows)
    force = next(n for n in result.numbers if (n.controller, n.key) == ("hybrid", "estimated_force_median"))
    assert not force.inside
    assert force.percentile == 100.0
    assert result.inside == 11
    assert len(result.nearest) == 8
    assert [near.draw for near in result.nearest][:3] == [0, 1, 2]  # the further, the larger the force


def test_a_number_that_follows_one_unknown_is_found(short_prior: Prior) -> None:
    campaign = freeze(short_prior.campaign(64))
    columns = unknown_columns(campaign, 64)
    assert columns["controller.translation.proportional"].max() <= 1.5
    assert "controller.translation.proportional.1" not in columns
    found = correlations(columns, columns["approach.depth"] ** 3)
    assert found["approach.depth"] == pytest.approx(1.0)
    assert max(abs(value) for name, value in found.items() if name != "approach.depth") < 0.5
    error = columns["sensors.attitude_misalignment.1"]
    valley = correlations(columns, np.abs(error))
    assert valley["|sensors.attitude_misalignment.1|"] == pytest.approx(1.0)
    assert abs(valley["sensors.attitude_misalignment.1"]) < 0.4


def test_what_chance_can_show_is_not_drawn() -> None:
    assert beyond_chance(200, "shown") == pytest.approx(0.2, rel=1e-3)
    drawn = np.random.default_rng(0)
    for draws in (5, 20, 200):
        columns = {f"unknown {number}": drawn.normal(size=draws) for number in range(30)}
        cause = columns["unknown 3"]
        found = {
            ("pid", "error_u_median"): correlations(columns, cause + 0.1 * drawn.normal(size=draws)),
            ("hybrid", "error_u_median"): correlations(columns, np.full(draws, np.nan)),
        }
        assert shown_unknowns(found, draws) == ([] if draws == 5 else ["unknown 3"])


def test_a_circle_is_found_in_part_of_it() -> None:
    angle = np.linspace(0.3, 2.5, 40)
    middle, radius = fitted_circle(np.stack([0.2 + 0.3 * np.cos(angle), 1.0 + 0.3 * np.sin(angle)], axis=1))
    np.testing.assert_allclose([*middle, radius], [0.2, 1.0, 0.3], atol=1e-12)
    assert set(SETS["paper"]) >= {key for claim in CLAIMS.values() for key in claim.keys if "trace" in key}


def test_the_verb_refuses_what_it_cannot_fly(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["reproduce", "--draws", "1", "--out", str(tmp_path / "new")]) == 2
    assert "--draws" in capsys.readouterr().err
    assert main(["reproduce", "--out", str(tmp_path)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_the_committed_result_was_flown_with_the_prior_that_ships() -> None:
    content = json.loads(COMMITTED.read_text(encoding="utf-8"))
    assert content["prior"]["sha256"] == load_prior().digest
    assert [unknown["key"] for unknown in content["prior"]["unknowns"]] == list(
        tomllib.loads(PRIOR.read_text(encoding="utf-8"))["unknown"]
    )
    assert content["draws"] >= 200
    assert content["flights"] == 4 * content["draws"]
    assert content["inside"]["of"] == 12
    assert math.isclose(content["numbers"][0]["paper"], 0.134)


def test_the_documentation_shows_the_committed_result() -> None:
    spec = importlib.util.spec_from_file_location("writer", REPOSITORY / "benchmarks" / "reproduction.py")
    assert spec is not None
    assert spec.loader is not None
    writer = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(writer)
    section = writer.section()
    assert "@" not in section
    assert section in (REPOSITORY / "docs" / "reports" / "results.md").read_text(encoding="utf-8")
