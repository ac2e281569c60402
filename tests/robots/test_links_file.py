"""What was read from a URDF comes back from its file of links as it was, or not at all."""

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from skylimb.base.errors import DescriptionError
from skylimb.base.sources import Source, read_source
from skylimb.robots import SHIPPED, links_file
from skylimb.robots.links_file import links_text, tree_of
from skylimb.robots.urdf import read_urdf

URDFS = sorted(SHIPPED.glob("*/*.urdf"))


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "skylimb" / "links"


@pytest.fixture
def reads(monkeypatch):
    """How often a URDF is really read."""
    made = []
    monkeypatch.setattr(links_file, "read_urdf", lambda *given: made.append(given) or read_urdf(*given))
    return made


@pytest.fixture
def mine(tmp_path):
    """A user's own URDF: one that ships, and a comment more."""
    content = (SHIPPED / "tilted_hexarotor" / "tilted_hexarotor.urdf").read_bytes() + b"<!-- mine -->\n"
    path = tmp_path / "mine.urdf"
    path.write_bytes(content)
    return read_source(path)


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


@pytest.mark.parametrize("path", URDFS, ids=lambda path: path.stem)
def test_the_file_of_every_robot_that_ships_is_what_its_urdf_says(path, cache, reads):
    source = read_source(path)
    assert same(read_urdf(source), tree_of(source, None))
    copy = Source(Path("/elsewhere/robot.urdf"), source.content.replace(b"\n", b"\r\n"))
    assert same(read_urdf(source), tree_of(copy, None))
    assert not reads
    assert not cache.exists()


def test_a_robot_that_ships_needs_no_reader_of_urdfs():
    code = "import sys; sys.modules['yourdfpy'] = None; import skylimb; skylimb.load_robot('dragon')"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_new_urdf_without_the_reader_is_one_line_with_the_command(mine, cache, monkeypatch):
    monkeypatch.setitem(sys.modules, "yourdfpy", None)
    with pytest.raises(DescriptionError, match=r"has not been read yet.*pip install 'skylimb\[import\]'"):
        tree_of(mine, None)


def test_a_urdf_of_a_users_is_read_once(mine, cache, reads):
    first = tree_of(mine, None)
    assert same(first, tree_of(mine, None))
    assert len(reads) == 1
    assert tree_of(mine, first[0])[0] == first[0]
    tree_of(Source(mine.path, mine.content + b" "), None)
    assert len(reads) == 3  # another root, another content


@pytest.mark.parametrize("damage", ["", "{", "[]", "null", '{"key": 1}', "wrong links"])
def test_a_damaged_file_is_not_used(mine, cache, reads, damage):
    tree = tree_of(mine, None)
    file = next(cache.glob("*.json"))
    kept = file.read_bytes()
    data = json.loads(kept)
    file.write_text(damage if damage != "wrong links" else json.dumps({**data, "tree": ["a", [{}], []]}))
    with pytest.warns(UserWarning, match="damaged"):
        assert same(tree, tree_of(mine, None))
    assert len(reads) == 2
    assert file.read_bytes() == kept


def test_a_mass_that_was_doubled_in_the_file_beside_a_urdf_is_not_believed(mine, cache, reads):
    tree = tree_of(mine, None)
    links = json.loads(links_text(mine, None, tree, mine.path.parent))
    for link in links["tree"][1]:
        link["inertial"]["mass"] *= 2.0
    mine.path.with_suffix(".links.json").write_text(json.dumps(links))
    with pytest.warns(UserWarning, match="changed by hand or damaged"):
        assert same(tree, tree_of(mine, None))


def test_meshes_are_named_from_the_folder_of_the_file(tmp_path, cache, reads):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "a.stl").write_text("solid")
    visual = '<visual><geometry><mesh filename="meshes/a.stl"/></geometry></visual>'
    text = f'<robot name="a"><link name="a">{visual}</link></robot>'
    (tmp_path / "a.urdf").write_text(text)
    source = read_source(tmp_path / "a.urdf")
    tree = read_urdf(source)
    assert '"meshes/a.stl"' in links_text(source, None, tree, source.path.parent)
    assert same(tree, tree_of(source, None))
    assert same(tree, tree_of(source, None))
    assert len(reads) == 1
    (tmp_path / "meshes" / "a.stl").unlink()
    assert tree_of(source, None)[1][0].visuals == ()  # left out with a warning, and looked for the next time
    assert len(reads) == 2


def test_a_cache_that_cannot_be_written_is_no_mistake(tmp_path, mine, monkeypatch, reads):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert same(tree_of(mine, None), tree_of(mine, None))
    assert len(reads) == 2


def test_without_a_home_nothing_is_left_in_the_working_folder(tmp_path, mine, monkeypatch):
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_: Path("~/.cache/skylimb"))
    tree_of(mine, None)
    assert not list((tmp_path / "empty").iterdir())
