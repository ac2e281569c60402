"""What was read from a URDF comes back from the cache as it was, or not at all."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from skylimb.base.sources import Source
from skylimb.robots.kept_urdf import keep_tree, known_tree
from skylimb.robots.loader import list_robots, read_description


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "skylimb" / "urdf"


def tree_of(name):
    description = read_description(name)
    return (description.root, description.links, description.joints), description.sources[1]


def same(one, other):
    if isinstance(one, np.ndarray):
        return one.tobytes() == other.tobytes() and one.shape == other.shape and not other.flags.writeable
    if dataclasses.is_dataclass(one):
        return type(one) is type(other) and all(
            same(value, vars(other)[key]) for key, value in vars(one).items()
        )
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(same, one, other))
    return type(one) is type(other) and one == other


@pytest.mark.parametrize("name", list_robots())
def test_every_robot_that_ships_comes_back_to_the_bit(cache, name):
    tree, source = tree_of(name)
    assert known_tree(source, None) is None
    keep_tree(tree, source, None)
    assert same(tree, known_tree(source, None))


def test_another_file_or_root_is_another_robot(cache):
    tree, source = tree_of("tilted_hexarotor")
    keep_tree(tree, source, None)
    assert known_tree(source, "root") is None
    assert known_tree(Source(source.path, source.content + b" "), None) is None


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"root": "a", "links": [{}], "joints": []}'])
def test_a_damaged_file_is_as_good_as_none(cache, damage):
    tree, source = tree_of("tilted_hexarotor")
    keep_tree(tree, source, None)
    (file,) = cache.iterdir()
    assert json.loads(file.read_text())["root"] == tree[0]
    file.write_text(damage)
    assert known_tree(source, None) is None


def test_a_robot_with_meshes_is_not_kept(cache):
    tree, source = tree_of("tilted_hexarotor")
    keep_tree(tree, Source(source.path, source.content + b"<mesh/>"), None)
    assert not cache.exists()


def test_a_cache_that_cannot_be_written_is_no_mistake(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    tree, source = tree_of("tilted_hexarotor")
    keep_tree(tree, source, None)
    assert known_tree(source, None) is None


def test_without_a_home_nothing_is_left_in_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_: Path("~/.cache/skylimb"))
    tree, source = tree_of("tilted_hexarotor")
    keep_tree(tree, source, None)
    assert not list(tmp_path.iterdir())
