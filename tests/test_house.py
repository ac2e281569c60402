"""The documents, the import rules and the files around the code."""

import ast
import functools
import graphlib
import importlib
import inspect
import itertools
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any, get_type_hints

import pytest

import skylimb
from skylimb.apps.cli.arguments import parse
from skylimb.apps.cli.verbs import VERBS
from skylimb.base.errors import EXTRAS
from skylimb.control.laws import Laws
from skylimb.control.laws.slots import SLOTS, traced_functions
from skylimb.flight.loading import load_flight

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted([ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "docs").rglob("*.md")])
NO_ORDER = {"skylimb.simulation.surfaces"}
"""Rooms of a wing that has no other: the order of the wings rules them."""
LOOKED_UP = {"keys.md", "faults.md"}
"""Pages of tables that programs write, longer than anybody reads at once."""
OPTIONAL = ("compiler", *EXTRAS)
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

FLOWN = ("skylimb run", "skylimb compare", "skylimb draw", "skylimb fly", "skylimb plan")
"""Commands that name an experiment, controllers and keys."""

documents = pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def without_code(text: str) -> str:
    return re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)


def anchors(document: Path) -> set[str]:
    titles = re.findall(r"^#+ (.*)$", without_code(document.read_text(encoding="utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def tracked_files() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    return [path for name in listed.stdout.split("\0") if name and (path := ROOT / name).is_file()]


def test_the_import_rules_are_kept() -> None:
    # In a process of its own: the linter turns off all loggers that exist.
    program = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(no_cache=True))"
    found = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stdout + found.stderr


def imported_by(module: ast.Module) -> Iterator[str]:
    """What a file imports, anywhere in it and by name as well; what only a type checker sees is left out."""
    unseen = {
        id(inner)
        for node in ast.walk(module)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for inner in ast.walk(node)
    }
    for node in ast.walk(module):
        if id(node) in unseen:
            continue
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value  # for importlib


def test_no_files_import_each_other_in_a_circle() -> None:
    source = ROOT / "src"
    paths = [path for path in (source / "skylimb").rglob("*.py") if path.name != "__init__.py"]
    files = {".".join(path.relative_to(source).with_suffix("").parts): path for path in paths}
    graph = {name: {*imported_by(ast.parse(path.read_text()))} & {*files} for name, path in files.items()}
    assert sum(map(len, graph.values())) > len(files)
    order = [*graphlib.TopologicalSorter(graph).static_order()]  # a CycleError names the circle
    assert len(order) == len(files)


def test_every_test_asserts_something() -> None:
    called: dict[str, set[str]] = {}
    for path in (ROOT / "tests").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                called.setdefault(node.name, set()).update(calls_of(node))
    asserting: set[str] = set()
    while (
        fresh := {name for name, calls in called.items() if calls & asserting or "assert" in calls}
        - asserting
    ):
        asserting |= fresh
    assert sorted(name for name in {*called} - asserting if name.startswith("test_")) == []


def calls_of(function: ast.FunctionDef) -> Iterator[str]:
    """Names that a function calls; "assert" for what can fail by what it says."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assert | ast.Raise):
            yield "assert"
        elif isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            yield "assert" if name.startswith(("assert", "raises", "warns", "fail")) else name


def test_every_room_is_in_an_import_rule() -> None:
    contracts = PROJECT["tool"]["importlinter"]["contracts"]
    ruled = {
        f"{container}.{name.strip()}"
        for contract in contracts
        for container in contract.get("containers", [])
        for layer in contract["layers"]
        for name in layer.split("|")
    }
    package = ROOT / "src" / "skylimb"
    rooms = [path.parent.relative_to(package.parent) for path in package.glob("*/*/__init__.py")]
    names = {".".join(room.parts) for room in rooms}
    assert names - ruled - NO_ORDER == set()


@documents
def test_links_lead_somewhere(document: Path) -> None:
    text = without_code(document.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith(("https://", "http://")):
            continue
        path, _, anchor = target.partition("#")
        found = (document.parent / path).resolve() if path else document
        assert found.exists(), f"{document.name} links to {target}"
        assert not anchor or anchor in anchors(found), f"{document.name} links to {target}"


def test_a_guide_is_read_in_one_sitting() -> None:
    # What was measured is in docs/reports.
    guides = [path for path in (ROOT / "docs").glob("*.md") if path.name not in LOOKED_UP]
    assert len(guides) > 40
    for guide in guides:
        words = re.findall(r"\S*\w\S*", without_code(guide.read_text(encoding="utf-8")))
        assert len(words) <= 1200, guide.name


def test_the_site_shows_every_page_once() -> None:
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    shown = re.findall(r"^ +- [^:\n]+: (\S+\.md)$", site[site.index("\nnav:") :], re.MULTILINE)
    pages = [path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")]
    assert sorted(shown) == sorted(pages)
    styles = re.search(r"^extra_css: \[(\S+)\]$", site, re.MULTILINE)
    assert styles is not None
    assert (ROOT / "docs" / styles[1]).is_file()


def test_every_picture_is_shown_on_a_page() -> None:
    pages = "".join(path.read_text(encoding="utf-8") for path in DOCUMENTS)
    pictures = [path for path in (ROOT / "docs" / "images").rglob("*.*") if path.is_file()]
    assert len(pictures) > 40
    assert [path.name for path in pictures if f"/{path.name})" not in pages] == []


def test_the_search_of_the_site_knows_keys_by_their_parts_and_scores_as_a_whole() -> None:
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    separator = re.search(r"^ +separator: '(.+)'", site, re.MULTILINE)
    assert separator is not None
    words = re.split(separator[1], "`approach.standoff` = 0.25, `pen_behind`")
    assert {"approach", "standoff", "0.25", "pen_behind"} <= {*words}


def commands(document: Path) -> list[str]:
    """Every command that a page shows: to be typed, in a text, or within a sentence."""
    text = document.read_text(encoding="utf-8").replace("\\\n", " ")
    typed = "".join(blocks(text, "(?:console|sh)")).splitlines()
    shown = re.findall(r"^(?:\$ )?(skylimb [^:\n]*)$", "".join(blocks(text, "text")), re.MULTILINE)
    # What is told of former days need not be typed today.
    told = (
        [] if document.name == "CHANGELOG.md" else re.findall(r"`(skylimb [a-z][^`]*)`", without_code(text))
    )
    return [*filter(None, typed), *shown, *told]


def typed(line: str) -> tuple[str, Any]:
    """Program of a command, and where it is skylimb the verb with its arguments filled in."""
    program, *words = shlex.split(line.replace("...", ""), comments=True)
    if program != "skylimb":
        return program, words
    verb, *rest = words
    if rest and f"{verb} {rest[0]}" in VERBS:
        verb, *rest = f"{verb} {rest[0]}", *rest[1:]
    return program, parse(verb, VERBS[verb], rest) if rest else VERBS[verb]


@documents
def test_commands_in_the_documents_can_be_typed(document: Path) -> None:
    made = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    for line in commands(document):
        program, words = typed(line)
        if program == "make":
            assert set(words) <= set(made), line
        else:
            assert program in {".", "python", "skylimb"}, line


def test_every_verb_is_shown_on_a_page() -> None:
    shown = [line for document in DOCUMENTS for line in commands(document)]
    for verb in VERBS:
        assert any(f"{line} ".startswith(f"skylimb {verb} ") for line in shown), verb


def test_experiments_controllers_and_keys_in_the_documents_are_those_that_there_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    guides = "\n".join(
        path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("extending*.md"))
    )
    for name, text in re.findall(r"^```\w+\n# file: (\S+)\n(.*?)^```", guides, re.DOTALL | re.MULTILINE):
        (tmp_path / name).write_text(text, encoding="utf-8")
    loaded = set[str]()
    for line in sorted(set(itertools.chain.from_iterable(map(commands, DOCUMENTS)))):
        program, call = typed(line)
        if program != "skylimb" or not line.startswith(FLOWN):
            continue
        defaults = {one.name: one.default for one in inspect.signature(call).parameters.values()}
        given: dict[str, Any] = {**defaults, **getattr(call, "keywords", {})}
        experiment = given.get("experiment", given.get("surface", "paper"))
        controller = given.get("controllers", given.get("controller"))
        controllers = [controller] if controller is None or isinstance(controller, str) else controller
        files = [name for name in (experiment, *controllers) if name and ("/" in name or "." in name)]
        if all(Path(name).exists() for name in files) and "robots/mine" not in line:
            for name in controllers:
                load_flight(experiment, name, given.get("seed"), given.get("set"))
            loaded.add(line)
    assert len(loaded) > 50


@documents
def test_files_that_the_documents_name_exist(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    named = re.findall(r"`((?:src|tests|examples|benchmarks|docs)/[\w./-]+)`", text)
    for name in named:
        assert (ROOT / name).exists(), f"{document.name} names {name}"


def test_python_in_the_documents_runs() -> None:
    ran = 0
    for document in DOCUMENTS:
        names: dict[str, Any] = {}  # a block goes on from those before it
        for code in blocks(document.read_text(encoding="utf-8"), "python"):
            if code.startswith(("import ", "from ")):
                exec(compile(code, str(document), "exec"), names)
                ran += 1
    assert ran > 12


def test_files_in_the_guide_are_what_they_say(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    guides = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").glob("extending*.md"))]
    written = re.findall(r"^```\w+\n# file: (\S+)\n(.*?)^```", "\n".join(guides), re.DOTALL | re.MULTILINE)
    for name, text in written:
        (tmp_path / name).write_text(text, encoding="utf-8")
        # What an example is as well is one text; `skylimb new` begins with it.
        assert {path.read_text(encoding="utf-8") for path in (ROOT / "examples").rglob(name)} <= {text}, name
    monkeypatch.chdir(tmp_path)
    robot = skylimb.load_robot("hydrus_xi_quad")
    for name in ("slow_line.toml", "pillar.toml", "mine.toml", "dunes.toml"):
        assert skylimb.load_experiment(name).description
    for name in ("firm.toml", "spring.toml"):
        assert skylimb.load_controller(name, robot).name == name.removesuffix(".toml")
    for law in ("regulator.py", "splined.py"):
        cascade = skylimb.load_controller("spring.toml", robot, {"translation.law": law})
        assert bool(cascade.in_python) == (law == "splined.py")  # type: ignore[attr-defined]
    assert {name for name, _ in written} == {path.name for path in tmp_path.glob("*.*")}


def test_the_guide_of_laws_calls_their_functions_as_the_slots_do() -> None:
    rows = re.findall(
        r"^\| ([a-z, ]+) \| (`(?:step|aim)\(.*) \|$", (ROOT / "docs/extending_laws.md").read_text(), re.M
    )
    told = {slot: {*re.findall(r"`(.+?)`", calls)} for slots, calls in rows for slot in slots.split(", ")}
    for slot, kind in get_type_hints(Laws).items():
        made = {
            name: [*inspect.signature(getattr(kind, name)).parameters][1:] for name in traced_functions(slot)
        }
        assert told[slot] == {f"{name}({', '.join(arguments)})" for name, arguments in made.items()}, slot
    assert set(told) == set(SLOTS)


def test_the_paper_map_names_what_there_is() -> None:
    text = (ROOT / "docs" / "paper_map.md").read_text(encoding="utf-8")
    functions = re.findall(r"`(skylimb\.[\w.]+)`", text)
    tests = re.findall(r"`(tests/[\w./]+)::(\w+)`", text)
    assert len(functions) > 20
    assert len(tests) > 20
    for name in functions:
        found, parts = None, name.split(".")
        for cut in range(len(parts), 0, -1):
            try:
                found = importlib.import_module(".".join(parts[:cut]))
            except ModuleNotFoundError:
                continue
            for attribute in parts[cut:]:
                found = getattr(found, attribute)
            break
        assert found is not None, name
    for path, name in tests:
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        assert name in {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}, name


def test_the_names_that_stand_for_symbols_are_in_the_code() -> None:
    text = (ROOT / "docs" / "notation.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\|([^|]*)\|([^|]*)\|", text.partition("## Symbols and names")[2], re.MULTILINE)
    names = {name for _, code in rows for name in re.findall(r"`[\w.]*?(\w+)(?:\[[^`]*\])?`", code)}
    assert {"joint_angles", "allocation_C", "normalized_stiffness"} <= names
    written = set(
        re.findall(r"\w+", " ".join(path.read_text("utf-8") for path in (ROOT / "src").rglob("*.py")))
    )
    assert not names - written


def test_every_label_in_the_code_is_on_the_paper_map() -> None:
    text = (ROOT / "docs" / "paper_map.md").read_text(encoding="utf-8").replace("*", "")
    labels = sorted(re.findall(r"eq:[\w \-]+\w", text), key=len, reverse=True)
    for path in (ROOT / "src").rglob("*.py"):
        flat = " ".join(path.read_text(encoding="utf-8").split())
        for at in [match.start() for match in re.finditer(r"\beq:", flat)]:
            assert flat[at:].startswith(tuple(labels)), f"{path}: {flat[at : at + 50]}"


def test_versions_agree() -> None:
    version = PROJECT["project"]["version"]
    assert version == skylimb.__version__
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"## {version}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def imported_packages(folder: Path) -> set[str]:
    """Top-level names that the code in a folder imports."""
    names = set()
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.add(node.module.partition(".")[0])
    return names


@functools.cache
def installed_packages() -> Mapping[str, list[str]]:
    """The distributions that bring each package; a search through the whole environment."""
    return packages_distributions()


def canonical(requirement: str) -> str:
    return re.sub(r"[-_.]+", "-", re.split(r"[\[<>=~ ]", requirement)[0]).lower()


def test_dependencies_are_what_is_imported() -> None:
    declared = {canonical(requirement) for requirement in PROJECT["project"]["dependencies"]}
    extras = PROJECT["project"]["optional-dependencies"]
    optional = {canonical(requirement) for name in OPTIONAL for requirement in extras[name]}
    # ROS 1 comes from Debian, not from an index of Python packages.
    known = {*sys.stdlib_module_names, "skylimb", "rospy", "rosgraph", "genpy", "genmsg"}
    foreign = imported_packages(ROOT / "src") - known
    providers = installed_packages()
    for name in foreign:
        provided_by = {canonical(provider) for provider in providers[name]}
        assert provided_by & (declared | optional), f"{name} is not declared"
    # xarray opens a log through h5netcdf, trimesh reads .dae through pycollada; neither is imported by name.
    provided = {canonical(provider) for name in foreign for provider in providers[name]} | {
        "h5netcdf",
        "pycollada",
    }
    assert declared <= provided, f"declared but not imported: {sorted(declared - provided)}"


def test_every_dependency_is_pinned() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.\-]+==[\w.]+", line) for line in pins)
    pinned = {canonical(line) for line in pins}
    project = PROJECT["project"]
    wanted = [*project["dependencies"], *itertools.chain(*project["optional-dependencies"].values())]
    for requirement in wanted:
        # The project's own extras stand in the list themselves.
        assert requirement.startswith("skylimb[") or canonical(requirement) in pinned, requirement


def test_renewing_the_pins_asks_for_every_extra() -> None:
    """What the environment of the tools does not hold is named in the recipe itself."""
    extras = PROJECT["project"]["optional-dependencies"]
    held, open_ = set[str](), ["dev", "docs", "report", "video"]
    while open_:
        held.add(name := open_.pop())
        asked = (part for one in extras[name] for part in re.findall(r"^skylimb\[([\w,-]+)\]", one))
        open_ += [extra for part in asked for extra in part.split(",") if extra not in held]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    recipe = makefile.partition("\nconstraints:")[2].partition("\n\n")[0]
    assert {name for name in extras if name not in held} == set(re.findall(r"'\.\[(\w+)\]'", recipe))


def test_files_beside_the_code_are_packaged() -> None:
    patterns = PROJECT["tool"]["setuptools"]["package-data"]["skylimb"]
    package = ROOT / "src" / "skylimb"
    packaged = {path for pattern in patterns for path in package.glob(pattern)}
    beside = {
        path
        for path in tracked_files()
        if path.is_relative_to(package) and path.suffix != ".py" and path.name != "py.typed"
    }
    assert beside <= packaged


def test_nothing_tells_of_the_machine_it_was_made_on() -> None:
    leaks = [
        r"(?<![\w.])/(?:root|home|work|opt|mnt|tmp|Users)/\w",
        r"[A-Z]:\\\\?Users",
        r"(?i)extra-index-url|find-links|trusted-host|py[p]i\.org|python[h]osted",
        r"(?i)(?:api|secret|access)[_-]?(?:key|token)\s*[=:]",
        r"BEGIN (?:RSA |OPENSSH )?PRIVATE KEY",
    ]
    for path in tracked_files():
        if path == Path(__file__):
            continue
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        for leak in leaks:
            found = re.search(leak, text)
            assert found is None, f"{path.relative_to(ROOT)}: {found[0] if found else ''}"


@pytest.mark.parametrize("extra", EXTRAS)
def test_a_missing_package_names_the_extra_that_installs_it(extra: str) -> None:
    installed = {canonical(line) for line in PROJECT["project"]["optional-dependencies"][extra]}
    providers = installed_packages()
    for package in EXTRAS[extra]:
        assert {canonical(provider) for provider in providers[package]} & installed, package


def test_what_flies_needs_few_packages() -> None:
    assert len(PROJECT["project"]["dependencies"]) <= 12


def test_the_page_of_the_python_interface_has_every_name() -> None:
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    missing = [name for name in dir(skylimb) if not re.search(rf"`{name}\b", page)]
    assert missing == []
