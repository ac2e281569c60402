"""Flip operators of the core, one at a time, and see whether the tests of their own room notice.

    nice -n 10 python benchmarks/mutants.py --count 200 --seed 1 --out out/mutants.json
    python benchmarks/mutants.py --rooms flight/realtime --count 20

A mutant is one operator of one file: `<` becomes `<=`, `+` becomes `-`, `and` becomes `or`. It is made in a
scratch copy of the tree with a cache of its own. First those tests of its wing run that mirror its file or
name it, then the others of its folder, until one fails or the time is over. Tests that fail without any
mutant kill none: every test that killed is run once more on the tree as it is. Exits with 1 when fewer than
the wanted share are killed.
"""

from __future__ import annotations

import argparse
import ast
import copy
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from skylimb.base.cache import cache_folder

ROOT = Path(__file__).parents[1]
ROOMS = ("base", "robots", "control", "simulation", "flight")
SHARE_WANTED = 0.92
KILLED, SURVIVED, TIMEOUT, UNJUDGED = "killed", "survived", "out of time", "not judged"

FLIPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn,
    ast.NotIn: ast.In, ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.And: ast.Or, ast.Or: ast.And, ast.USub: ast.UAdd,
}  # fmt: skip
"""What an operator becomes. Powers, remainders and products of matrices stay: they fail at once."""


@dataclass(frozen=True)
class Mutant:
    """One flipped operator.

    Attributes:
        file: below the root.
        line: of the expression.
        before: the expression as it stands.
        after: with the operator flipped.
        start: place of the expression in the file's bytes.
        end: of its end.
    """

    file: str
    line: int
    before: str
    after: str
    start: int
    end: int


@dataclass(frozen=True)
class Result:
    """What became of a mutant: the verdict, the test that failed, and how long it took, s."""

    mutant: Mutant
    verdict: str
    test: str
    seconds: float


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Every operator of a file that can be flipped; none of annotations and messages."""
    content = path.read_bytes()
    lines = [0]
    for line in content.splitlines(keepends=True):
        lines.append(lines[-1] + len(line))
    for node in _running(ast.parse(content)):
        for flipped in _flipped(node):
            assert isinstance(node, ast.expr | ast.AugAssign)
            start = lines[node.lineno - 1] + node.col_offset
            end = lines[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
            after = ast.unparse(flipped)
            text = after if isinstance(node, ast.AugAssign) else f"({after})"
            before = " ".join(content[start:end].decode().split())
            yield Mutant(path.relative_to(ROOT).as_posix(), node.lineno, before, text, start, end)


def _running(node: ast.AST) -> Iterator[ast.AST]:
    """Every node below one that does something when the file runs."""
    for name, value in ast.iter_fields(node):
        if name in {"annotation", "returns", "decorator_list"} or isinstance(node, ast.Raise | ast.JoinedStr):
            continue
        for child in value if isinstance(value, list) else [value]:
            typing_only = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
            if isinstance(child, ast.AST) and not typing_only and not _is_of_types(child):
                yield child
                yield from _running(child)


def _is_of_types(node: ast.AST) -> bool:
    """Whether a node joins types or texts, which are messages."""
    if not isinstance(node, ast.BinOp):
        return False
    words = [getattr(side, "value", None) for side in (node.left, node.right)]
    return isinstance(node.op, ast.BitOr) or any(isinstance(word, str | bytes) for word in words)


def _flipped(node: ast.AST) -> Iterator[ast.AST]:
    """The node with each of its operators flipped."""
    if isinstance(node, ast.Compare):
        for k, op in enumerate(node.ops):
            if type(op) in FLIPS:
                made = copy.deepcopy(node)
                made.ops[k] = FLIPS[type(op)]()  # type: ignore[call-overload]
                yield made
    elif isinstance(node, ast.BinOp | ast.BoolOp | ast.AugAssign | ast.UnaryOp) and type(node.op) in FLIPS:
        made = copy.deepcopy(node)
        made.op = FLIPS[type(node.op)]()  # type: ignore[assignment]
        yield made


def tests_of(file: str) -> tuple[list[str], list[str]]:
    """Test files of a module's wing: those that mirror or name it, then the others of its folder."""
    module = Path(file).relative_to("src/skylimb").with_suffix("")
    dotted = ".".join(("skylimb", *module.parts))
    package, _, stem = dotted.rpartition(".")
    imports = re.compile(rf"{re.escape(dotted)}\b|from {re.escape(package)} import .*\b{stem}\b")
    wing = ROOT / "tests" / module.parts[0]
    every = sorted(path for path in wing.rglob("test_*.py"))
    mirrored = [path for path in every if path.name == f"test_{stem}.py"]
    naming = [path for path in every if imports.search(path.read_text("utf-8")) and path not in mirrored]
    folder = ROOT / "tests" / module.parent
    beside = [
        path
        for path in every
        if path not in mirrored + naming and path.is_relative_to(folder if folder.is_dir() else wing)
    ]

    def names(paths: list[Path]) -> list[str]:
        return [path.relative_to(ROOT).as_posix() for path in paths]

    return names(mirrored + naming), names(beside)


class Scratch:
    """A copy of the tree in which mutants live, one at a time, with a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.tree, self._cache, self._warm = folder / "tree", folder / "cache", folder / "warm"
        listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout
        for name in listed.decode().split("\0"):
            if name and (ROOT / name).is_file():
                (self.tree / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, self.tree / name)
        known = cache_folder()  # what was built before is not built for every mutant anew
        shutil.copytree(known, self._warm / known.name) if known.is_dir() else self._warm.mkdir()

    def test(self, tests: list[str], limit: float, fresh: bool = True) -> tuple[str, str]:
        """Run tests up to the first failure, for at most `limit` s: the verdict, and which test failed."""
        if fresh:  # what a mutant writes into the cache must not be believed by the next one
            shutil.rmtree(self._cache, ignore_errors=True)
            shutil.copytree(self._warm, self._cache, copy_function=os.link)
        cache = self._cache if fresh else self._warm
        variables = {"PYTHONPATH": str(self.tree / "src"), "XDG_CACHE_HOME": str(cache)}
        options = ["-x", "-q", "-n", "0", "-m", "not slow", "-p", "no:cacheprovider", "--tb=no", "-rfE"]
        process = subprocess.Popen(
            [sys.executable, "-B", "-m", "pytest", *options, *tests],
            cwd=self.tree, env={**os.environ, **variables}, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        try:
            said, _ = process.communicate(timeout=max(1.0, limit))
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            return TIMEOUT, ""
        failed = re.search(r"^(?:FAILED|ERROR) (\S+)", said, re.MULTILINE)
        if process.returncode in (0, 5):  # 5: there was nothing to run
            return SURVIVED, ""
        return KILLED, failed[1] if failed else "collection"

    def judge(self, mutant: Mutant, limit: float) -> Result:
        """Make a mutant, test it, and put the file back."""
        file, begun = self.tree / mutant.file, time.monotonic()
        content = file.read_bytes()
        file.write_bytes(content[: mutant.start] + mutant.after.encode() + content[mutant.end :])
        try:
            verdict, test = SURVIVED, ""
            for tests in tests_of(mutant.file):
                if tests and verdict == SURVIVED:
                    verdict, test = self.test(tests, limit - (time.monotonic() - begun))
        finally:
            file.write_bytes(content)
        return Result(mutant, verdict, test, time.monotonic() - begun)


def really_killed(results: list[Result], scratch: Scratch) -> list[Result]:
    """The results without the kills of tests that fail on the tree as it is."""
    wrong = set()
    for test in sorted({one.test for one in results if one.verdict == KILLED and one.test != "collection"}):
        if scratch.test([test], 300.0, fresh=False)[0] != SURVIVED:
            wrong.add(test)
    return [
        Result(one.mutant, UNJUDGED, one.test, one.seconds) if one.test in wrong else one for one in results
    ]


def main() -> int:
    """Make the mutants and print the survivors."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rooms", nargs="+", default=ROOMS, help="folders below src/skylimb")
    parser.add_argument("--limit", type=float, default=120.0, help="for a mutant, s")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="after which no mutant is begun")
    parser.add_argument("--out", type=Path, help="JSON file, written anew after every mutant")
    given = parser.parse_args()
    files = sorted(path for room in given.rooms for path in (ROOT / "src/skylimb" / room).rglob("*.py"))
    known = [mutant for file in files for mutant in mutants_of(file)]
    chosen = random.Random(given.seed).sample(known, min(given.count, len(known)))
    print(f"{len(known)} operators in {len(files)} files; {len(chosen)} of them flipped, seed {given.seed}")
    results, end = list[Result](), time.monotonic() + 60.0 * given.minutes
    with tempfile.TemporaryDirectory(prefix="skylimb-mutants-") as folder:
        scratch = Scratch(Path(folder))
        for mutant in chosen:
            if time.monotonic() > end:
                break
            results.append(scratch.judge(mutant, given.limit))
            _show(len(results), results[-1])
            if given.out:
                given.out.write_text(json.dumps([asdict(one) for one in results], indent=1) + "\n", "utf-8")
        results = really_killed(results, scratch)
    verdicts = [one.verdict for one in results]
    counts = {name: verdicts.count(name) for name in (KILLED, SURVIVED, TIMEOUT, UNJUDGED)}
    judged = counts[KILLED] + counts[SURVIVED]
    share = counts[KILLED] / judged if judged else 0.0
    print(", ".join(f"{name}: {count}" for name, count in counts.items()))
    print(f"{100.0 * share:.1f} % of the {judged} judged are killed")
    return int(share < SHARE_WANTED)


def _show(number: int, one: Result) -> None:
    """A line for a mutant."""
    mutant = one.mutant
    print(f"{number:4d} {one.verdict:9s} {one.seconds:5.0f} s  {mutant.file}:{mutant.line}", flush=True)
    if one.verdict != KILLED:
        print(f"       {mutant.before}  ->  {mutant.after}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
