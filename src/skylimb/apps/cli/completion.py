"""Scripts that complete the command line in bash, zsh and fish."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence

from skylimb.apps.catalogue.entries import entries
from skylimb.apps.catalogue.search import all_keys
from skylimb.apps.cli.arguments import Verb, flags
from skylimb.base.keys import ANY_NAME, ANY_NUMBER


def script(shell: str, verbs: Mapping[str, Verb]) -> str:
    """The script of a shell for some verbs."""
    options = {name: ["--help", *flags(verb)] for name, verb in verbs.items() if " " not in name}
    if shell == "fish":
        return _fish(options)
    if shell == "zsh":
        return f"#compdef skylimb\nautoload -U +X bashcompinit && bashcompinit\n{_bash(options)}"
    return _bash(options)


def _words() -> dict[str, list[str]]:
    """What may follow a verb or an option, besides files."""
    known = entries()
    named = {
        kind: [entry.name for entry in known if entry.kind == kind]
        for kind in ("experiment", "controller", "robot")
    }
    keys = [each for each in all_keys() if ANY_NAME not in each.key and ANY_NUMBER not in each.key]
    return {
        "run": named["experiment"],
        "compare": named["experiment"],
        "show": [entry.name for entry in known if entry.kind != "metric"],
        "keys": sorted({each.key.rpartition(".")[2] for each in keys}),
        "completion": ["bash", "zsh", "fish"],
        "--controller": named["controller"],
        "--controllers": named["controller"],
        "--surface": named["experiment"],
        "--robot": named["robot"],
        "--set": [f"{each.key}=" for each in keys if each.of[0] not in ("campaign", "flight")],
    }


def _cases(table: Mapping[str, Sequence[str]]) -> str:
    return "".join(f"    {name}) words={shlex.quote(' '.join(words))};;\n" for name, words in table.items())


def _bash(verbs: Mapping[str, list[str]]) -> str:
    words = _words()
    after = {name: found for name, found in words.items() if name.startswith("--")}
    named = {name: [*words.get(name, []), *options] for name, options in verbs.items()}
    return f"""\
# Completes skylimb; made by `skylimb completion`.
_skylimb() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} verb=${{COMP_WORDS[1]}} words="" option="" i
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W {shlex.quote(" ".join([*verbs, "--help", "--version"]))} -- "$word"))
    return
  fi
  for ((i = 2; i < COMP_CWORD; i++)); do
    case ${{COMP_WORDS[i]}} in --*) option=${{COMP_WORDS[i]}};; esac
  done
  case $verb in
{_cases(named)}  esac
  case $word in -*) ;; *) case $option in
{_cases(after)}  esac;; esac
  COMPREPLY=($(compgen -W "$words" -- "$word") $(compgen -f -- "$word"))
  case ${{COMPREPLY[0]}} in *=) compopt -o nospace 2>/dev/null;; esac
}}
complete -F _skylimb skylimb
"""


def _fish(verbs: Mapping[str, list[str]]) -> str:
    words = _words()
    lines = ["# Completes skylimb; made by `skylimb completion`."]
    lines.append(f"complete -c skylimb -n __fish_use_subcommand -f -a '{' '.join(verbs)}'")
    for verb, options in verbs.items():
        here = f"complete -c skylimb -n '__fish_seen_subcommand_from {verb}'"
        if verb in words:
            lines.append(f"{here} -a '{' '.join(words[verb])}'")
        for option in options:
            choices = f" -x -a '{' '.join(words[option])}'" if option in words else ""
            lines.append(f"{here} -l {option.removeprefix('--')}{choices}")
    return "\n".join(lines) + "\n"
