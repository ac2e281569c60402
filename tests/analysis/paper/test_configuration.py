"""What a flight has otherwise than the paper's."""

import copy
import re
import tomllib

import pytest

from skylimb.analysis.paper.configuration import (
    CONTROLLERS,
    FILE,
    NOTHING,
    differences,
    differences_of,
    in_words,
    is_the_papers,
    not_the_papers,
)
from skylimb.base.config import put
from skylimb.control.controller import load_controller, resolved_tables
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.robots.loader import load_robot


def flown(controller="hybrid", **changes):
    """The configuration of a flight of the shipped experiment, some keys set otherwise."""
    own = {key.removeprefix("controller."): v for key, v in changes.items() if key.startswith("controller.")}
    world = {key: value for key, value in changes.items() if not key.startswith("controller.")}
    robot = load_robot("hydrus_xi_quad")
    preset = resolved_tables(load_controller(controller, robot, own))
    return {**load_experiment("paper", world).to_mapping(), "controller": preset}


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_the_shipped_experiment_and_presets_are_the_papers(controller):
    """Where this fails, a key or a value is new: give it to configuration.toml as well."""
    assert in_words(differences(flown(controller), controller)) == ""


@pytest.mark.parametrize(
    ("changes", "keys"),
    [
        ({"surface.kind": "cylinder"}, ["surface.kind"]),
        ({"trajectory.shape": "line"}, ["trajectory.shape"]),
        ({"surface.kind": "cylinder", "trajectory.shape": "line"}, ["trajectory.shape", "surface.kind"]),
        ({"surface.friction": 0.2}, ["surface.friction"]),
        ({"robot": "hydrus_xi_quad_mast"}, ["robot"]),
        ({"events": [{"kind": "push", "time": 1.0, "duration": 2.0}]}, ["events"]),
        ({"events": [{"kind": "gain", "time": 9.0, "key": "shape.mass", "value": 30.0}]}, ["events"]),
        ({"supervisor.on": True}, ["supervisor.on"]),
        ({"supervisor.on": False}, []),
        ({"controller.shape.mass": 41.0}, ["controller.shape.mass"]),
        ({"controller.shape.law": "fixed"}, ["controller.shape.law"]),
        ({"controller.allocation.leak.compensate": True}, ["controller.allocation.leak.compensate"]),
        ({"seed": 7, "name": "mine", "description": "", "terminations.tilt": 0.9}, []),
        ({"surface.slope": 0.34906585}, []),  # degrees that somebody typed in as radians
    ],
)
def test_what_differs_is_named(changes, keys):
    assert [found.key for found in differences(flown(**changes), "hybrid")] == keys


def test_an_event_that_differs_is_told_as_a_file_has_it():
    events = [{"kind": "gain", "time": 9.0, "key": "shape.mass", "value": 30.0}]
    (found,) = differences(flown(events=events), "hybrid")
    here = "{kind = gain, time = 9, duration = 0.5, key = shape.mass, value = 30}"
    assert str(found) == f"events = [{here}] (paper: not set)"


def test_a_preset_that_only_has_the_name_is_another_controller():
    keys = {found.key for found in differences(flown("following"), "hybrid")}
    assert {"controller.translation.law", "controller.contact.law", "controller.shape.law"} <= keys


def test_a_key_that_only_one_of_the_two_has_counts():
    config = flown()
    put(config, "surface.new_key", 1.0)
    del config["phases"]["settle"]
    found = {each.key: each for each in differences(config, "hybrid")}
    assert found["surface.new_key"].paper == NOTHING
    assert str(found["phases.settle"]) == "phases.settle = not set (paper: 5)"
    assert len(found) == 2
    del config["surface"]["kind"]
    assert "surface.kind" in {each.key for each in differences(config, "hybrid")}
    put(config, "surface.kind", "board")
    put(config, "surface.new_key", [])
    assert len(differences(config, "hybrid")) == 1


def test_every_value_of_the_papers_matters():
    """Changing any one of them is seen, however small."""

    def leaves(table, above=()):
        for key, value in table.items():
            if isinstance(value, dict):
                yield from leaves(value, (*above, key))
            else:
                yield (*above, key), value

    paper = tomllib.loads(FILE.read_text(encoding="utf-8"))
    tables = {**paper["experiment"], "controller": paper["controller"]["hybrid"]}
    for path, value in leaves(tables):
        changed = copy.deepcopy(tables)
        table = changed
        for key in path[:-1]:
            table = table[key]
        more = {bool: lambda v: not v, list: lambda v: [*v, 1.0], str: lambda v: f"{v}x"}
        table[path[-1]] = more.get(type(value), lambda v: v + 1e-5 * (1.0 + abs(v)))(value)
        assert ".".join(path) in {found.key for found in differences(changed, "hybrid")}


def test_runs_are_judged_by_what_they_store(make_run):
    run = make_run("hybrid")
    assert is_the_papers(run)
    run.log.attrs["config"] = run.config.replace("depth = 0.15", "depth = 0.12")
    assert in_words(differences_of(run)) == "approach.depth = 0.12 (paper: 0.15)"
    for nothing_known in ("", "not TOML", 'name = "paper"\n'):
        run.log.attrs["config"] = nothing_known
        assert not is_the_papers(run)
        assert in_words(differences_of(run)) == "configuration = not in the record (paper: paper with hybrid)"
    assert not is_the_papers(make_run("following"))


def test_what_differs_is_said_once_for_runs_that_differ_alike(make_run):
    runs = {name: make_run(name) for name in (*CONTROLLERS, "following")}
    assert not_the_papers(runs) == []
    for name in ("pid", "hybrid"):
        log = runs[name].log
        log.attrs["config"] = re.sub("friction = .*", "friction = 0.9", log.attrs["config"])
    assert not_the_papers(runs) == ["pid, hybrid: surface.friction = 0.9 (paper: 0.4)"]
    runs["pid"].log.attrs["experiment"] = "slippery"  # its name promises nothing
    assert not_the_papers(runs) == ["hybrid: surface.friction = 0.9 (paper: 0.4)"]


def test_of_many_differences_the_first_are_said(make_run):
    run = make_run("hybrid")
    run.log.attrs["config"] = re.sub(r"= \d+\.\d+\n", "= 0.77\n", run.config)
    assert re.search(r"paper: \S+\) and \d+ more$", in_words(differences_of(run)))
