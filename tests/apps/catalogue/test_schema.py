"""JSON schemas: every TOML file that ships is valid, and what skylimb refuses is not."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from skylimb.apps.catalogue.schema import schemas
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError
from skylimb.control.laws.preset import preset_from_mapping
from skylimb.flight.experiments.experiment import experiment_from_mapping

ROOT = Path(__file__).parents[3]
PACKAGE = ROOT / "src" / "skylimb"
SCHEMAS = {name.partition(".")[0]: schema for name, schema in schemas().items()}
SHIPPED = {
    "experiment": [
        *(PACKAGE / "flight" / "experiments" / "library").glob("*.toml"),
        *(ROOT / "examples" / "surfaces").glob("*.toml"),
    ],
    "controller": [
        *(PACKAGE / "control" / "presets").glob("*.toml"), *(ROOT / "examples" / "laws").glob("*.toml")
    ],
    "robot": [*(PACKAGE / "robots").glob("*/flight.toml")],
    "campaign": [*(ROOT / "examples").glob("*.toml")],
}  # fmt: skip


def problems(kind: str, tables: dict) -> list[str]:
    return [error.message for error in jsonschema.Draft7Validator(SCHEMAS[kind]).iter_errors(tables)]


@pytest.mark.parametrize("kind", SCHEMAS)
def test_a_schema_is_one_and_says_what_each_key_is(kind: str) -> None:
    jsonschema.Draft7Validator.check_schema(SCHEMAS[kind])
    assert SHIPPED[kind]
    for path in SHIPPED[kind]:
        assert problems(kind, tomllib.loads(path.read_text(encoding="utf-8"))) == [], path.name


EXPERIMENT = tomllib.loads(
    (PACKAGE / "flight" / "experiments" / "library" / "paper.toml").read_text(encoding="utf-8")
)
PRESET = tomllib.loads((PACKAGE / "control" / "presets" / "hybrid.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("surface", "friction", -0.1),
        ("surface", "frictoin", 0.2),
        ("surface", "kind", "cilinder"),
        ("surface", "size", [1.0]),
        ("trajectory", "shape", "sqare"),
        ("trajectory", "radius", "0.3"),
        ("trajectory", "strokes", 2.5),
        ("trajectory", "speed", 0.0),
        ("phases", "settle", True),
        ("sensors", "nonsense", 1),
    ],
)
def test_a_wrong_experiment_is_refused_by_both(table: str, key: str, value: object) -> None:
    wrong = {**EXPERIMENT, table: {**EXPERIMENT.get(table, {}), key: value}}
    assert problems("experiment", wrong)
    with pytest.raises(ConfigError):
        experiment_from_mapping(wrong, "test")


@pytest.mark.parametrize(
    ("slot", "changes"),
    [
        ("shape", {"stiffness": -1.0}),
        ("shape", {"law": "admitance"}),
        ("translation", {"proportional": [1.0, 1.0, 1.0]}),
        ("estimation", {"law": 3}),
    ],
)
def test_a_wrong_preset_is_refused_by_both(slot: str, changes: dict) -> None:
    wrong = {**PRESET, slot: {**PRESET.get(slot, {}), **changes}}
    assert problems("controller", wrong)
    with pytest.raises(ConfigError):
        preset_from_mapping(wrong, Path("test.toml"))


@pytest.mark.parametrize(
    ("table", "fine"),
    [
        ({"translation": {"force": 2.0}}, True),
        ({"translation": {"law": "following", "force": 2.0}, "shape": {"arm_share": 0.5}}, True),
        ({"translation": {"forse": 2.0}}, False),
        ({"translations": {"force": 2.0}}, False),
        (3, False),
    ],
)
def test_a_table_of_a_robot_may_leave_out_what_it_does_not_change(table: object, fine: bool) -> None:
    assert (problems("controller", {**PRESET, "robots": {"dragon": table}}) == []) is fine


PUSH = {"kind": "push", "time": 1.0, "duration": 0.5}


@pytest.mark.parametrize(
    "event",
    [
        PUSH,
        {**PUSH, "force": [1.0, 0, 0], "link": "link4"},
        {"kind": "gain", "time": 1, "key": "shape.mass", "value": 3.0},
        {"kind": "gain", "time": 1.0, "key": "translation.damping_ratio", "value": [1.0, 1.0, 1.0]},
        {"kind": "surface", "time": 1.0, "present": False},
    ],
)
def test_events_of_every_kind_are_welcome(event: dict) -> None:
    assert problems("experiment", {**EXPERIMENT, "events": [PUSH, event]}) == []
    assert experiment_from_mapping({**EXPERIMENT, "events": [PUSH, event]}, "test").events


@pytest.mark.parametrize(
    "events",
    [
        [{**PUSH, "kind": "psh"}],
        [{key: value for key, value in PUSH.items() if key != "kind"}],
        [{"kind": "push", "time": 1.0}],
        [PUSH, {**PUSH, "forse": [1.0, 0.0, 0.0]}],
        [{**PUSH, "force": [1.0, 0.0]}],
        [{**PUSH, "force": [1.0, 0.0, 101.0]}],
        [{**PUSH, "duration": 0.0}],
        [{"kind": "surface", "time": 1.0, "force": [1.0, 0.0, 0.0]}],
        {"kind": "push"},
    ],
)
def test_a_wrong_event_is_refused_by_both(events: object) -> None:
    assert problems("experiment", {**EXPERIMENT, "events": events})
    with pytest.raises(ConfigError):
        experiment_from_mapping({**EXPERIMENT, "events": events}, "test")


def test_a_law_of_ones_own_and_any_surface_are_welcome() -> None:
    assert problems("controller", {**PRESET, "shape": {"law": "mine.py", "gain": 3.0}}) == []
    assert problems("controller", {key: value for key, value in PRESET.items() if key != "shape"})
    assert problems("experiment", {"surface": {"kind": "cylinder", "radius": 0.8}}) == []
    assert problems("experiment", {"surface": {"friction": 1}}) == []


def test_units_ranges_and_defaults_are_in_it() -> None:
    radius = SCHEMAS["experiment"]["properties"]["trajectory"]["properties"]["radius"]
    assert radius["description"].endswith("half the width (m)")
    assert (radius["minimum"], radius["maximum"], radius["default"]) == (0.01, 5.0, 0.3)


def test_the_command_writes_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "--schema", str(tmp_path / "schemas"), "--page", str(tmp_path / "keys.md")]) == 0
    out = capsys.readouterr().out
    assert "#:schema" in out
    for name, schema in schemas().items():
        assert json.loads((tmp_path / "schemas" / name).read_text()) == json.loads(json.dumps(schema))
    assert (tmp_path / "keys.md").read_text().startswith("# Keys")
