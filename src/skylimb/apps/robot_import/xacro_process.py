"""Expands one xacro file and prints the URDF: `python xacro_process.py FILE PACKAGES ARGUMENTS`.

Packages and arguments are JSON. Run as a file, not as a module, so that nothing of skylimb is imported.
"""

import json
import sys


def _main(path: str, names: str, arguments: str) -> None:
    from xacrodoc import XacroDoc, packages

    packages.update_package_cache(json.loads(names))
    try:
        given = json.loads(arguments)
        text = XacroDoc.from_file(path, walk_up=True, resolve_packages=False, subargs=given).to_urdf_string()
    except RecursionError:
        sys.exit("its macros call each other without end")
    except Exception as error:  # xacro lets every kind through
        words = " ".join(str(error).split()) or type(error).__name__
        sys.exit(words.rpartition("Error'>: ")[2])
    sys.stdout.write(text)


if __name__ == "__main__":
    _main(*sys.argv[1:])
