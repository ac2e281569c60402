"""How large the house is: statements, files and rooms of each wing, required packages and their size.

    python benchmarks/house.py [--root .] [--megabytes]

A statement is a node of Python's syntax tree that is one, without imports and docstrings: formatting changes
nothing. `--root` counts another checkout. `--megabytes` adds what the required packages, and all that they
require themselves, take on this machine.
"""

from __future__ import annotations

import argparse
import ast
import tomllib
from collections import Counter
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement


def statements(source: str) -> int:
    """Statements of a Python file, without imports and docstrings."""
    found = 0
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            found += not isinstance(node.value.value, str)
        elif isinstance(node, ast.stmt) and not isinstance(node, ast.Import | ast.ImportFrom):
            found += 1
    return found


def required(project: str, seen: set[str]) -> set[str]:
    """A package with all that it requires, by their names as they are installed here."""
    if project in seen:
        return seen
    seen.add(project)
    for line in metadata.requires(project) or []:
        need = Requirement(line)
        if need.marker is None or need.marker.evaluate({"extra": ""}):
            required(need.name.lower().replace("_", "-"), seen)
    return seen


def megabytes(project: str) -> float:
    """What a package takes on this machine, without compiled Python."""
    files = [Path(str(file.locate())) for file in metadata.files(project) or [] if file.suffix != ".pyc"]
    return sum(file.stat().st_size for file in files if file.is_file()) / 1e6


def main() -> None:
    """Count and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--root", type=Path, default=Path(__file__).parents[1])
    parser.add_argument("--megabytes", action="store_true")
    options = parser.parse_args()
    package = options.root / "src" / "skylimb"
    counts, files, rooms = Counter[str](), Counter[str](), dict[str, set[str]]()
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).parts
        wing = parts[0] if len(parts) > 1 else "(at the top)"
        counts[wing] += statements(path.read_text(encoding="utf-8"))
        files[wing] += 1
        rooms.setdefault(wing, set()).add("/".join(parts[:2]) if len(parts) > 2 else wing)
    print(f"{'wing':<14}{'statements':>12}{'files':>8}{'rooms':>8}")
    for wing, count in counts.most_common():
        print(f"{wing:<14}{count:>12}{files[wing]:>8}{len(rooms[wing]):>8}")
    print(f"{'all':<14}{sum(counts.values()):>12}{sum(files.values()):>8}{sum(map(len, rooms.values())):>8}")
    project = tomllib.loads((options.root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    direct = [Requirement(line).name for line in project["dependencies"]]
    print(f"{len(direct)} required packages: {', '.join(direct)}")
    if options.megabytes:
        every = set[str]()
        for name in direct:
            required(name, every)
        sizes = sorted(((megabytes(name), name) for name in every), reverse=True)
        print(f"{sum(size for size, _ in sizes):.0f} MB in {len(sizes)} packages:")
        print(", ".join(f"{name} {size:.0f}" for size, name in sizes if size >= 1))


if __name__ == "__main__":
    main()
