"""The verb that looks keys up: `keys`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.base.errors import ConfigError


def keys(
    word: Annotated[str, arg("What to look for; every key without it.", "WORD")] = "",
    *,
    schema: Annotated[str, arg("Write JSON schemas into this folder.", "DIR")] = "",
    page: Annotated[str, arg("Write all keys as a page of Markdown.", "FILE.md")] = "",
) -> None:
    """Search the keys of everything that can be set, with unit, range and meaning.

    First come the keys of that name, then those with the word in their name or meaning. A word that is found
    nowhere finds what is spelled alike. Without a word, every key is listed.

    Examples:
        skylimb keys friction
        skylimb keys stiffness
        skylimb keys --schema schemas       JSON schemas, for editors that complete and check TOML
    """
    if schema:
        _write_schemas(Path(schema))
    if page:
        from skylimb.apps.catalogue.page import keys_page

        _write(Path(page), keys_page())
    if not (schema or page):
        _print_found(word)


def _print_found(word: str) -> None:
    """The keys that a word finds; a pipe gets a line each, its parts between tabs."""
    from rich.padding import Padding
    from rich.text import Text

    from skylimb.apps.catalogue.search import all_keys, search
    from skylimb.apps.cli.key_tables import for_a_person
    from skylimb.base.keys import brief

    found = search(word) if word else all_keys()
    if not found:
        raise ConfigError(f"no key has anything to do with '{word}'; `skylimb keys` lists them all")
    console = output.console_for() if for_a_person() else None
    for one in found:
        info, of = one.info, _named(one.of)
        value, about = brief(info.default), (info.range, info.meaning)
        if console is None:
            print("\t".join((one.key, value, info.unit, *about, of)))
        else:
            console.print(Text.assemble((one.key, "cyan"), f" = {value} {info.unit}".rstrip()))
            told = "; ".join(filter(None, (*about, f"of {of}")))
            console.print(Padding(Text(told, "dim"), (0, 0, 0, 4)))


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
