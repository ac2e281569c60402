"""What there is to be set and scored, as `list`, `show` and `keys` have it."""

import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from skylimb.apps.catalogue.entries import KINDS, entries, find_entry, tables_of_entry
from skylimb.apps.catalogue.page import keys_page
from skylimb.apps.catalogue.search import all_keys, search
from skylimb.apps.cli.main import main
from skylimb.control.laws.slots import SLOTS, law_names
from skylimb.flight.events import EVENTS, SurfaceChange
from skylimb.flight.experiments.experiment import experiment_from_mapping
from skylimb.robots import SHIPPED
from skylimb.simulation.surfaces import SURFACES

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def read_once() -> Iterator[None]:
    """All files are read for each entry that is sought; here some 360 are."""
    known = entries()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skylimb.apps.catalogue.entries.entries", lambda: known)
        yield


def test_every_entry_has_a_name_of_its_own_and_a_meaning() -> None:
    known = entries()
    assert len({entry.name for entry in known}) == len(known)
    assert {entry.kind for entry in known} == set(KINDS)
    assert all(entry.meaning for entry in known)
    names = {entry.name for entry in known}
    assert {f"surface.{kind}" for kind in SURFACES} <= names
    assert {f"{slot}.{law}" for slot in SLOTS for law in law_names(slot)} <= names
    assert {f"event.{kind}" for kind in EVENTS} <= names
    assert {"path.drawing", "sensors", "metric.tilt_max", "campaign", "surface"} <= names


@pytest.mark.usefixtures("read_once")
@pytest.mark.parametrize("entry", entries(), ids=lambda entry: entry.name)
def test_every_entry_is_found_and_has_keys_with_meanings(entry) -> None:
    assert find_entry(entry.name) == entry
    assert find_entry(entry.short).short == entry.short
    tables = tables_of_entry(entry)
    assert bool(tables) == (entry.kind not in ("metric", "experiment", "robot"))
    assert all(info.meaning for table in tables for _, _, info in table.rows)


def test_a_path_shows_its_own_keys_and_those_of_all() -> None:
    (table,) = tables_of_entry(find_entry("line"))
    values = {name: value for name, value, _ in table.rows}
    assert values["shape"] == "line"
    assert {"length", "speed", "direction", "feedforward"} <= set(values)
    assert not {"radius", "text", "waypoints"} & set(values)


def test_a_controller_shows_keys_that_its_file_does_not_set(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "hybrid"]) == 0
    out = capsys.readouterr().out
    assert "[allocation.leak]" in out
    assert "cutoff = 0.5" in out


def test_show_takes_what_run_takes(capsys: pytest.CaptureFixture[str]) -> None:
    folder = SHIPPED / "hydrus_xi_quad"
    for name in (folder, folder / "flight.toml"):
        assert main(["show", str(name)]) == 0
        assert "measured_link" in capsys.readouterr().out
    assert main(["show", str(ROOT / "examples" / "user_controller.py")]) == 0
    assert "upright" in capsys.readouterr().out
    assert main(["show", "nothing_like_it"]) == 2
    assert "unknown experiment, controller, robot" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cylinder", "surface.kind=cylinder"),
        ("translation.pid", "controller.translation.law=pid"),
        ("circle", "trajectory.shape=circle"),
        ("event.push", "--set events.0.KEY=VALUE"),
        ("sensors", "--set sensors.rate=100"),
        ("tilt_max", "tilt_max: Largest tilt, rad"),
        ("campaign", "draws ="),
    ],
)
def test_what_is_shown_says_how_it_is_used(name: str, words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", name]) == 0
    assert words in capsys.readouterr().out


def test_an_event_is_shown_as_its_table_is_written(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", "event.surface"]) == 0
    out = capsys.readouterr().out
    text = out.replace("# time =", "time = 3.0").replace("# slope =", "slope = 0.2")
    assert "\n[[events]]\n" in text
    (event,) = experiment_from_mapping(tomllib.loads(text), "shown").events
    assert event == SurfaceChange(3.0, slope=0.2)


def test_show_without_a_name_lists_the_names(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show"]) == 0
    out = capsys.readouterr().out
    assert main(["list"]) == 0
    assert capsys.readouterr().out == out
    assert "Events: kind in [[events]]" in out
    assert all(entry.name in out for entry in entries())


def test_a_word_finds_keys_by_name_then_meaning_then_spelling() -> None:
    assert [key.key for key in search("friction")][:1] == ["surface.friction"]
    assert search("surface.friction")[0].of[0].startswith("surface.")
    assert [key.key for key in search("Coulomb")][:1] == ["surface.friction"]
    assert "controller.shape.stiffness" in [key.key for key in search("stifness")]
    assert search("qqqqqq") == []
    assert search("events.<n>.kind")[0].of == tuple(f"event.{kind}" for kind in sorted(EVENTS))
    keys = [key.key for key in all_keys()]
    assert "controller.allocation.leak.cutoff" in keys
    assert "trajectory.radius" in keys
    assert "rotors.<n>.thrust_max" in keys


def test_keys_on_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "thrust_max"]) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[0].split("\t") == [
        "rotors.<n>.thrust_max", "-", "N", "> 0, <= 10000", "greatest thrust", "flight",
    ]  # fmt: skip
    assert main(["keys"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(all_keys())
    assert main(["keys", "qqqqqq"]) == 2
    assert "no key has anything to do with 'qqqqqq'" in capsys.readouterr().err


def test_the_page_of_the_docs_is_up_to_date() -> None:
    text = (ROOT / "docs" / "keys.md").read_text(encoding="utf-8")
    assert text == keys_page(), "write it anew: skylimb keys --page docs/keys.md"
    for key in all_keys():
        bare = key.key.removeprefix("controller.")
        assert f"| `{bare}` |" in text, key.key
