"""What `skylimb show` prints, in a terminal and into a file."""

import re
import tomllib
from pathlib import Path

import pytest

import skylimb
from skylimb.apps.cli.key_tables import commented_toml
from skylimb.apps.cli.main import main
from skylimb.base.config import flatten, parse_assignment
from skylimb.base.keys import Table, keys_of, tables_of
from skylimb.control.laws.preset import preset_from_mapping, preset_mapping
from skylimb.control.laws.preset_keys import preset_tables
from skylimb.flight.experiments.experiment import experiment_from_mapping
from skylimb.robots.flight_file import FlightFile
from skylimb.simulation.surfaces import FrictionMap, Patch, surface_from_mapping

EXPERIMENT = skylimb.load_experiment("paper")
HYBRID = preset_from_mapping(*preset_mapping("hybrid"))


def shown(name: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["show", name]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", skylimb.list_experiments())
def test_an_experiment_that_was_shown_can_be_flown(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(shown(name, capsys), encoding="utf-8")
    assert skylimb.load_experiment(str(path)) == skylimb.load_experiment(name)


@pytest.mark.parametrize("name", skylimb.list_controllers())
def test_a_controller_that_was_shown_can_be_flown(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(shown(name, capsys), encoding="utf-8")
    assert preset_from_mapping(*preset_mapping(str(path))) == preset_from_mapping(*preset_mapping(name))
    # What was shown is shown again.
    again = shown(str(path), capsys)
    assert again.replace(str(path), name) == path.read_text(encoding="utf-8")


def test_a_robot_that_was_shown_is_a_flight_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = shown("hydrus_xi_quad", capsys)
    assert "4.12" in out
    folder = Path(skylimb.load_robot("hydrus_xi_quad").description.folder)
    path = tmp_path / "flight.toml"
    path.write_text(out.replace('urdf = "', f'urdf = "{folder.as_posix()}/'), encoding="utf-8")
    mine, shipped = skylimb.load_robot(path), skylimb.load_robot("hydrus_xi_quad")
    assert mine.mass == shipped.mass
    assert [rotor.lag for rotor in mine.description.rotors] == [0.05] * 4
    assert shown(str(path), capsys).splitlines()[0] == out.splitlines()[0]


def test_a_terminal_shows_the_same_words_in_colour(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plain = shown("paper", capsys)
    monkeypatch.setattr("skylimb.apps.cli.key_tables.for_a_person", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "200")
    coloured = shown("paper", capsys)
    assert "\x1b[" in coloured
    words = re.sub(r"\x1b\[[0-9;]*m", "", coloured)
    assert [line.rstrip() for line in words.splitlines()] == plain.splitlines()


@pytest.mark.parametrize("tables", [list(tables_of(EXPERIMENT)), list(preset_tables(HYBRID))])
def test_every_key_has_its_unit_range_and_meaning_above_it(tables: list[Table]) -> None:
    lines = list(commented_toml("title", tables, "hint"))
    assert max(len(line) for line in lines if line.startswith("# ")) <= 79
    words = re.sub(r"\s+", " ", " ".join(line.removeprefix("# ") for line in lines))
    for table in tables:
        for name, value, info in table.rows:
            if not isinstance(value, dict):
                assert info.meaning in words
                assert f"{name} =" in words
            if info.range and info.unit and not isinstance(value, dict):
                assert f"({info.unit}; {info.range})" in words


@pytest.mark.parametrize(("name", "prefix"), [("paper", ""), ("hybrid", "controller.")])
def test_the_example_of_a_change_can_be_typed(
    name: str, prefix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    hint = next(line for line in shown(name, capsys).splitlines() if line.startswith("# Change a key: "))
    key, value = parse_assignment(hint.rpartition(" ")[2])
    assert key.startswith(prefix)
    if prefix:
        skylimb.load_controller(
            "hybrid", skylimb.load_robot("hydrus_xi_quad"), {key.removeprefix(prefix): value}
        )
    else:
        assert skylimb.load_experiment("paper", {key: value}) == EXPERIMENT


def test_what_is_not_set_is_commented_out_under_the_header_that_would_set_it() -> None:
    lines = list(commented_toml("title", tables_of(EXPERIMENT), "hint"))
    for line in ("# [surface.friction_map]", "# [surface.friction_map.patches.NAME]", "# [[events]]"):
        assert line in lines
    assert lines.index("# [[events]]") < lines.index("# kind =") < lines.index("# time =")
    assert "# damping =" in lines
    assert all(len(line) <= 79 for line in lines if line.startswith("# ") and "=" not in line)


def test_an_entry_of_a_list_and_an_odd_name_are_read_back() -> None:
    events = [
        {"kind": "gain", "time": 1.0, "key": "a", "value": [1.0, 2.0]},
        {"kind": "push", "time": 4.0, "duration": 1.0},
        {"kind": "gain", "time": 2.0, "key": "b", "value": 3.0},
    ]
    experiment = skylimb.load_experiment("paper", {"events": events})
    text = "\n".join(commented_toml("title", tables_of(experiment), ""))
    assert experiment_from_mapping(tomllib.loads(text), "") == experiment
    # Each kind is explained once.
    assert text.count("as many numbers as the gain has") == text.count("link that is pushed") == 1

    surface = surface_from_mapping({})
    mapped = type(surface)(friction_map=FrictionMap(patches={"wet spot": Patch(), "b": Patch(radius=0.1)}))
    tables = tomllib.loads("\n".join(commented_toml("title", tables_of(mapped, ("surface",)), "")))
    assert surface_from_mapping(tables["surface"]) == mapped


def test_the_flight_file_says_what_every_key_is() -> None:
    names = {name.rpartition(".")[2] for name in keys_of(FlightFile)}
    robot = next(iter(skylimb.list_robots()))
    assert robot
    text = "\n".join(commented_toml("t", tables_of(FlightFile), ""))
    for name in names:
        assert f"{name} =" in text


def test_the_values_are_those_of_the_experiment() -> None:
    tables = tomllib.loads("\n".join(commented_toml("title", tables_of(EXPERIMENT), "")))
    assert flatten(tables) == flatten(EXPERIMENT.to_mapping())


def test_a_file_with_gains_of_a_users_controller_is_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine.py").write_text(
        (Path(__file__).parents[3] / "examples" / "user_controller.py").read_text()
    )
    (tmp_path / "gains.toml").write_text('file = "mine.py"\nvelocity = [3.0, 3.0, 3.5]\n')
    assert main(["show", str(tmp_path / "gains.toml")]) == 0
    assert "velocity = [3.0, 3.0, 3.5]" in capsys.readouterr().out
