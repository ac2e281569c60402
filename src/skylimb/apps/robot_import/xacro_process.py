"""Expands one xacro file and prints the URDF: `python xacro_process.py FILE PACKAGES ARGUMENTS`.

Packages and arguments are JSON. Run as a file, not as a module, so that nothing of skylimb is imported.
"""

import json
import sys


class _Asked(dict[str, str]):
    """Arguments that remember which of them a file has."""

    def __init__(self, given: dict[str, str]) -> None:
        super().__init__(given)
        self.names: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.names.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.names.add(name)
        return super().__getitem__(name)


def _main(path: str, names: str, arguments: str) -> None:
    from xacrodoc import XacroDoc, packages

    packages.update_package_cache(json.loads(names))
    try:
        given = _Asked(json.loads(arguments))
        text = XacroDoc.from_file(path, walk_up=True, resolve_packages=False, subargs=given).to_urdf_string()
    except RecursionError:
        sys.exit("its macros call each other without end")
    except Exception as error:  # xacro lets every kind through
        words = " ".join(str(error).split()) or type(error).__name__
        sys.exit(words.rpartition("Error'>: ")[2])
    for name in json.loads(arguments):
        if name not in given.names:
            sys.exit(f"it has no argument '{name}', only {', '.join(sorted(given.names)) or 'none'}")
    sys.stdout.write(text)


if __name__ == "__main__":
    _main(*sys.argv[1:])
