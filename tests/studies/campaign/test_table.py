"""The Parquet table: the same bytes for the same rows, and damage that is found."""

import random
from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from skylimb.studies.campaign.frozen import Campaign, freeze
from skylimb.studies.campaign.reading import load_spec
from skylimb.studies.campaign.rows import OK, Row, make_row
from skylimb.studies.campaign.table import read_table, write_table

SpecWriter = Callable[..., Path]


@pytest.fixture
def campaign(write_spec: SpecWriter) -> Campaign:
    vary = """
    "plant.thrust_scale" = { uniform = [0.9, 1.1] }
    "trajectory.direction" = { choice = [-1, 1] }
    "surface.friction" = { choice = [0, 0.5] }
    "plant.rotor_scale" = { choice = [[1.0, 1.0, 1.0, 1.0], [0.9, 1.0, 1.0, 1.0]] }
    """
    return freeze(load_spec(write_spec(draws=300, vary=vary)))


@pytest.fixture
def rows(campaign: Campaign) -> list[Row]:
    scores = {key: 1.0 / (place + 3) for place, key in enumerate(campaign.spec.keys[:5])}
    return [make_row(campaign, flight, OK, "", scores) for flight in range(600)]


def test_rows_read_back_as_they_were(campaign: Campaign, rows: list[Row], tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_table(tmp_path / name, rows, campaign)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert read_table(tmp_path / "a", campaign) == (rows, False)
    assert read_table(tmp_path / "none", campaign) == ([], False)
    columns = pq.read_schema(tmp_path / "a")
    kinds = {"trajectory.direction": "int64", "surface.friction": "double", "plant.rotor_scale.0": "double"}
    assert {name: str(columns.field(name).type) for name in kinds} == kinds


def test_no_flipped_bit_goes_unnoticed(campaign: Campaign, rows: list[Row], tmp_path: Path) -> None:
    """A flip is harmless, or costs the table: never a number."""
    write_table(tmp_path / "table", rows, campaign)
    sound, rng = (tmp_path / "table").read_bytes(), random.Random(2)
    seen = set()
    for _ in range(150):
        altered = bytearray(sound)
        altered[rng.randrange(len(sound))] ^= 1 << rng.randrange(8)
        (tmp_path / "table").write_bytes(altered)
        found, damaged = read_table(tmp_path / "table", campaign)
        assert found == ([] if damaged else rows)
        seen.add(len(found))
    assert seen == {0, 600}


def test_an_altered_table_and_one_of_another_campaign_are_not_taken(
    campaign: Campaign, rows: list[Row], write_spec: SpecWriter, tmp_path: Path
) -> None:
    path = tmp_path / "table"
    write_table(path, rows, campaign)
    table = pq.read_table(path)
    place = table.column_names.index("tilt_max")
    better = table.set_column(place, "tilt_max", pq.read_table(path).column("error_u_median"))
    pq.write_table(better, path)
    assert read_table(path, campaign) == ([], True)
    other = freeze(load_spec(write_spec(draws=300, head='sampling = "halton"')))
    write_table(path, rows, other)
    assert read_table(path, campaign) == ([], True)


def test_a_column_of_two_kinds_is_refused_by_name(
    campaign: Campaign, rows: list[Row], tmp_path: Path
) -> None:
    with pytest.raises(TypeError, match="column 'seed'"):
        write_table(tmp_path / "table", [rows[0], {**rows[1], "seed": 1.5}], campaign)
