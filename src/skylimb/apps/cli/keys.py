"""The verbs that look keys up: `keys` and `completion`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import Positional, arg
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.apps.catalogue.search import FoundKey


@dataclass(frozen=True)
class Keys:
    """Search the keys of everything that can be set, with unit, range and meaning.

    First come the keys of that name, then those with the word in their name or meaning. A word that is found
    nowhere finds what is spelled alike. Without a word, every key is listed.
    """

    examples: ClassVar[str] = """
        skylimb keys friction
        skylimb keys stiffness
        skylimb keys --schema schemas       JSON schemas, for editors that complete and check TOML
    """

    word: Annotated[Positional[str], arg(metavar="WORD", help="What to look for; every key without it.")] = ""
    schema: Annotated[str, arg(metavar="DIR", help="Write JSON schemas into this folder.")] = ""
    page: Annotated[str, arg(metavar="FILE.md", help="Write all keys as a page of Markdown.")] = ""

    def __call__(self) -> int:
        """Print what was found, or write the files."""
        if self.schema:
            _write_schemas(Path(self.schema))
        if self.page:
            from skylimb.apps.catalogue.page import keys_page

            _write(Path(self.page), keys_page())
        if self.schema or self.page:
            return 0
        from skylimb.apps.catalogue.search import all_keys, search

        found = search(self.word) if self.word else all_keys()
        if not found:
            raise ConfigError(f"no key has anything to do with '{self.word}'; `skylimb keys` lists them all")
        output.keys(_rows(found))
        return 0


def _rows(found: Sequence[FoundKey]) -> list[tuple[str, ...]]:
    from skylimb.base.keys import brief

    return [
        (
            each.key,
            brief(each.info.default),
            each.info.unit,
            each.info.range,
            each.info.meaning,
            _named(each.of),
        )
        for each in found
    ]


def _named(of: Sequence[str]) -> str:
    """What has a key, in a few words."""
    kinds = {name.partition(".")[0] for name in of}
    many = len(of) > 3 and len(kinds) == 1
    return f"every {kinds.pop()}" if many else ", ".join(of)


def _write_schemas(folder: Path) -> None:
    import json

    from skylimb.apps.catalogue.schema import schemas

    for name, schema in schemas().items():
        _write(folder / name, json.dumps(schema, indent=1) + "\n")
    place = (folder / "experiment.schema.json").as_posix()
    print(f"In VS Code with Even Better TOML, begin your file with the line  #:schema {place}")


def _write(path: Path, text: str) -> None:
    from skylimb.base.files import replace_text, writing

    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_text(path, text)
    print(f"  {path}")


@dataclass(frozen=True)
class Completion:
    """Print what a shell needs to complete verbs, options, names and keys."""

    examples: ClassVar[str] = """
        skylimb completion bash > ~/.local/share/bash-completion/completions/skylimb
        skylimb completion zsh > ~/.zfunc/_skylimb
        skylimb completion fish > ~/.config/fish/completions/skylimb.fish
    """

    shell: Annotated[Positional[Literal["bash", "zsh", "fish"]], arg(help="Which shell.")]

    def __call__(self) -> int:
        """Print the script."""
        from skylimb.apps.cli.completion import completion

        print(completion(self.shell), end="")
        return 0


VERBS = {"keys": Keys, "completion": Completion}
