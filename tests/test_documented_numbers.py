"""Numbers that the documents quote are those of the presets, experiments and classes."""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import skylimb
from skylimb.control.controller import resolved_tables
from skylimb.control.estimation.delay import DEPTH
from skylimb.control.planning.pen_motion import ROUNDING, SHARP
from skylimb.studies.campaign.spec import CampaignSpec, StopRule

DOCS = Path(__file__).parents[1] / "docs"
NUMBER = r"-?\d+(?:\.\d+)?"


def entry(tables: Mapping[str, Any], key: str) -> Any:
    node: Any = tables
    for part in key.split("."):
        node = node[part]
    return node


@pytest.fixture(scope="module")
def following() -> dict[str, Any]:
    robot = skylimb.load_robot("hydrus_xi_quad")
    return resolved_tables(skylimb.load_controller("following", robot))


def rows(page: str, heading: str) -> list[list[str]]:
    """Cells of the table below a heading."""
    text = (DOCS / page).read_text(encoding="utf-8")
    section = text[text.index(heading) + len(heading) :]
    lines = re.findall(r"^\| `.*$", re.split(r"^#+ ", section, flags=re.MULTILINE)[0], re.MULTILINE)
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_the_table_of_following_is_the_preset(following: dict[str, Any]) -> None:
    table = rows("reports/following_results.md", "### Its numbers\n")
    assert len(table) > 20
    for key, value, _ in table:
        assert entry(following, key.strip("`")) == eval(value, {"__builtins__": {}}), key


def test_the_guide_of_following_names_the_presets_values(following: dict[str, Any]) -> None:
    table = rows("following.md", "## What one changes\n")
    assert len(table) == 8
    for key, value, _ in table:
        assert entry(following, key.strip("`")) == float(value), key
    text = (DOCS / "following.md").read_text(encoding="utf-8")
    speed = re.search(r"along the contact axis with (\d+) mm/s", text)
    assert speed is not None
    assert float(speed[1]) == pytest.approx(1e3 * entry(following, "contact.approach_speed"))
    assert len(text.splitlines()) < 130  # two pages


@pytest.mark.parametrize(
    ("sentence", "keys", "scale"),
    [
        (r"presses with a \*\*commanded force\*\* \((#) N\)", ["translation.force"], 1.0),
        (r"felt\s+force above (#) N for (#) ms", ["machine.touch_force", "machine.touch_time"], (1.0, 1e3)),
        (r"stays below (#) N for (#) s", ["machine.lost_force", "machine.lost_time"], 1.0),
        (r"the robot rests for (#) s", ["machine.rest_time"], 1.0),
        (r"for (#) cm beyond the place of the loss", ["machine.search_again"], 1e2),
        (r"than the tank's (#) J", ["translation.tank"], 1.0),
        (r"bounces off and on gets (#) J each time", ["translation.tank"], 1.0),
        (r"The first touch\*\* is at (#) mm/s", ["contact.approach_speed"], 1e3),
        (r"mu = (#): on a board", ["translation.press_mass_ratio"], 1.0),
        (r"the edge is near 52 ms with (#) ms assumed", ["estimation.delay.latency"], 1e3),
    ],
)
def test_the_text_of_following_quotes_the_preset(
    following: dict[str, Any], sentence: str, keys: list[str], scale: float | tuple[float, ...]
) -> None:
    text = (DOCS / "reports" / "following_results.md").read_text(encoding="utf-8")
    found = re.search(sentence.replace("#", NUMBER).replace(" ", r"\s+"), text)
    assert found is not None, sentence
    scales = scale if isinstance(scale, tuple) else (scale,) * len(keys)
    for told, key, factor in zip(found.groups(), keys, scales, strict=True):
        whole = f"contact.{key}" if key.startswith("machine.") else key
        assert float(told) == pytest.approx(factor * entry(following, whole)), whole


def test_the_history_of_the_delay_is_as_long_as_the_page_says() -> None:
    text = (DOCS / "reports" / "following_results.md").read_text(encoding="utf-8")
    found = re.search(r"history's (\d+) ticks: (\d+) ms at (\d+) Hz", text)
    assert found is not None
    ticks, reach, rate = map(float, found.groups())
    assert ticks == DEPTH
    assert reach == pytest.approx(1e3 * (ticks - 1) / rate)


def test_the_page_on_drawing_quotes_the_experiment() -> None:
    text = (DOCS / "drawing.md").read_text(encoding="utf-8")
    tables = skylimb.load_experiment("paper").to_mapping()
    quoted = re.findall(r"`((?:trajectory|approach)\.\w+)` \((\S+) (?:s|m)\)", text)
    assert {key for key, _ in quoted} == {"trajectory.lift_time", "approach.lift"}
    for key, value in quoted:
        assert float(value) == entry(tables, key)
    sharp = re.search(r"corners of more than (\d+)\s+degrees", text)
    rounded = re.search(r"rounded by at most (\d+) mm", text)
    assert sharp is not None
    assert rounded is not None
    assert float(sharp[1]) == pytest.approx(math.degrees(SHARP))
    assert float(rounded[1]) == pytest.approx(1e3 * ROUNDING)


def test_the_defaults_of_a_campaign_are_those_of_its_class() -> None:
    spec = CampaignSpec("paper", ("pid",), draws=1)
    stop = StopRule("success", 0.1)
    known = 0
    for keys, _, default in rows("campaigns.md", "| Key | Meaning | Default |"):
        for key in re.findall(r"`([\w.]+)`", keys):
            if not default:
                continue
            known += 1
            owner = stop if key.startswith("stop.") else spec
            assert str(getattr(owner, key.removeprefix("stop."))) == default.strip("`"), key
    assert known >= 5


def test_the_guide_of_fully_actuated_flight_counts_as_its_report() -> None:
    counts = r"^\|.*\| `(\w+)` \| (\d+ of \d+) \| (\d+) \|"
    guide, report = (
        re.findall(counts, (DOCS / folder / "full_actuation.md").read_text(encoding="utf-8"), re.MULTILINE)
        for folder in (".", "reports")
    )
    assert len(report) == 6
    assert guide == report
