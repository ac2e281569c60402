"""Files of a user's: read once, by one function, with everything that a Python file imports beside it."""

import ast
import hashlib
import os
import sys
from pathlib import Path

import pytest

from skylimb.base.errors import UnreadableError, UserCodeError
from skylimb.base.keys.fields import fields_of
from skylimb.base.keys.listing import keys_of
from skylimb.base.sources import read_source
from skylimb.base.user_modules import load_module, sources_of_module
from skylimb.control.planning.trajectory_config import TrajectoryConfig
from skylimb.simulation.surfaces import SURFACES, FrictionMap

SRC = Path(__file__).parents[2] / "src" / "skylimb"


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def test_a_source_is_content_and_digest_as_they_were_read(tmp_path: Path) -> None:
    file = write(tmp_path / "a.toml", "x = 1\n")
    (tmp_path / "link.toml").symlink_to(file)
    source = read_source(tmp_path / "link.toml")
    file.write_text("x = 2\n")
    assert source.content == b"x = 1\n"
    assert source.digest == hashlib.sha256(b"x = 1\n").hexdigest()
    assert source.path == file.resolve()
    assert not source.shipped
    assert read_source(SRC / "base" / "errors.py").shipped


def test_a_file_that_is_not_there_names_the_nearest_of_its_kind(tmp_path: Path) -> None:
    write(tmp_path / "relief.png", "")
    write(tmp_path / "relieve.txt", "")
    with pytest.raises(UnreadableError, match=r"relieff\.png'; did you mean '.*relief\.png'"):
        read_source(tmp_path / "relieff.png")
    with pytest.raises(UnreadableError, match=r"cannot read '.*': Is a directory"):
        read_source(tmp_path)


def test_a_module_finds_what_lies_beside_it_and_says_which_files_were_read(tmp_path: Path) -> None:
    write(tmp_path / "gear" / "__init__.py", "from gear.teeth import COUNT\n")
    write(tmp_path / "gear" / "teeth.py", "COUNT = 3\n")
    write(tmp_path / "unused.py", "")
    helper = write(tmp_path / "helper_of_mine.py", "import gear\nVALUE = gear.COUNT\n")
    main = write(tmp_path / "law.py", "import helper_of_mine\nVALUE = helper_of_mine.VALUE\n")
    module = load_module(main, ("VALUE",))
    assert module.VALUE == 3
    read = sources_of_module(module)
    assert [source.path.relative_to(tmp_path.resolve()).as_posix() for source in read] == [
        "law.py", "helper_of_mine.py", "gear/__init__.py", "gear/teeth.py",
    ]  # fmt: skip
    # Edited within the same second, to the same length: no compiled copy may come in its place.
    helper.write_text("import gear\nVALUE = gear.COUNT+1"[:36] + "\n", encoding="utf-8")
    assert load_module(main, ()).VALUE == 4
    assert not list(tmp_path.rglob("__pycache__"))


def test_two_folders_may_have_helpers_of_the_same_name(tmp_path: Path) -> None:
    for name in ("one", "two"):
        write(tmp_path / name / "common_name.py", f"NAME = '{name}'\n")
        write(tmp_path / name / "law.py", "import common_name\nNAME = common_name.NAME\n")
    first, second = (load_module(tmp_path / name / "law.py", ()) for name in ("one", "two"))
    assert (first.NAME, second.NAME) == ("one", "two")


def test_a_script_keeps_its_own_copy_of_a_helper(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "helper_of_script.py", "VALUE = 1\n")
    main = write(tmp_path / "law.py", "import helper_of_script\nVALUE = helper_of_script.VALUE\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    __import__("helper_of_script")
    mine = sys.modules["helper_of_script"]
    write(tmp_path / "helper_of_script.py", "VALUE = 22\n")
    module = load_module(main, ())
    assert module.VALUE == 22
    assert [source.path.name for source in sources_of_module(module)] == ["law.py", "helper_of_script.py"]
    assert sys.modules.pop("helper_of_script") is mine


def test_a_folder_cannot_replace_pythons_own_modules(tmp_path: Path) -> None:
    write(tmp_path / "math.py", "raise RuntimeError('not this one')\n")
    write(tmp_path / "numpy" / "__init__.py", "")
    main = write(tmp_path / "law.py", "import math, numpy\nVALUE = math.pi\n")
    assert load_module(main, ()).VALUE > 3.0
    assert sys.modules["numpy"].array([1.0])[0] == 1.0


def test_what_is_no_users_module_has_no_sources() -> None:
    assert sources_of_module(sys) == ()
    assert sources_of_module(object()) == ()


def test_a_module_that_fails_leaves_the_imports_as_they_were(tmp_path: Path) -> None:
    before = list(sys.meta_path)
    with pytest.raises(UserCodeError, match="ZeroDivisionError"):
        load_module(write(tmp_path / "law.py", "1 / 0\n"), ())
    assert sys.meta_path == before


CONFIGURATIONS = [TrajectoryConfig, FrictionMap, *SURFACES.values()]


@pytest.mark.parametrize("cls", CONFIGURATIONS)
def test_a_configuration_that_names_a_file_says_what_was_read(cls: type) -> None:
    names_a_file = any(key is not None and key.file for _, key in fields_of(cls).values())
    assert names_a_file == hasattr(cls, "sources")
    for name, info in keys_of(cls).items():
        assert info.key.file == (name.rpartition(".")[2] == "file")


_READERS = {
    "open", "read_text", "read_bytes", "load", "loadtxt", "load_mesh", "imread", "spec_from_file_location",
}  # fmt: skip
_READ_OTHER_THINGS = {
    # Files of this package, records, caches, pages and other results; none is a file that a user names.
    "analysis", "campaign", "exchange", "recording", "reproduction", "studio", "verification", "cli",
}  # fmt: skip
_ALLOWED = {
    "studies/envs/fleet.py": {"load"},  # the campaign's controllers
    "base/files.py": {"open"},
    "base/sources.py": {"open"},
    "base/yaml_text.py": {"load"},
    "control/planning/drawing_sources.py": {"load"},
    "studies/calibration/public.py": {"load"},
    "apps/robot_import/meshes.py": {"load"},
    "apps/robot_import/picture.py": {"load"},
    "robots/packages.py": {"read_text"},
    "flight/experiments/listing.py": {"read_text"},
    "simulation/compiling.py": {"open", "read_bytes"},
    "simulation/surfaces/collision.py": {"read_text"},
    "simulation/surfaces/meshes.py": {"load_mesh"},
    "simulation/surfaces/tables.py": {"load", "loadtxt", "open"},
    "flight/export/files.py": {"read_text"},
    "flight/drivers/native/library.py": {"read_text"},
    "robots/urdf.py": {"load"},
    "base/user_modules.py": {"spec_from_file_location"},
    "base/aside.py": {"open"},
}
"""Those that read their own files, or bytes that `read_source` has read."""


def test_no_file_of_a_users_is_read_in_another_way() -> None:
    for path in SRC.rglob("*.py"):
        name = path.relative_to(SRC).as_posix()
        if {*path.relative_to(SRC).parts} & _READ_OTHER_THINGS:
            continue
        calls = {
            node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Call)
        }
        assert calls & _READERS <= _ALLOWED.get(name, set()), name


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no such pipes")
def test_only_regular_files_are_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "endless.toml").symlink_to("endless.toml")
    (tmp_path / "device.toml").symlink_to("/dev/zero")
    for name, why in (("pipe", "no regular file"), ("endless", "link"), ("device", "no regular file")):
        with pytest.raises(UnreadableError, match=why):
            read_source(tmp_path / f"{name}.toml")


def test_a_file_larger_than_its_kind_is_refused_before_it_is_read(tmp_path: Path) -> None:
    with (tmp_path / "large.toml").open("wb") as file:
        file.truncate(10**12)  # with holes: it takes no place
    with pytest.raises(UnreadableError, match=r"more than 0\.25 MB, the most for a \.toml file"):
        read_source(tmp_path / "large.toml")
    (tmp_path / "large.toml").rename(tmp_path / "large.stl")
    with pytest.raises(UnreadableError, match=r"10 MB, .* \.stl file; a mesh of fewer triangles does"):
        read_source(tmp_path / "large.stl")


def test_a_file_that_changes_the_working_folder_leaves_paths_as_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    Path("moves.py").write_text("import os; os.chdir('elsewhere')\nGains = 1\n", encoding="utf-8")
    with pytest.warns(
        UserWarning, match=r"'moves\.py' changes the working folder to '.*elsewhere'; it is set back"
    ):
        load_module(Path("moves.py"), ("Gains",))
    assert Path.cwd() == tmp_path
