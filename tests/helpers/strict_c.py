"""C that a test builds, as strictly as it can be; what was compiled in a run is not compiled again."""

import hashlib
import os
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

from skylimb.simulation.compiling import compile_c

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off", "-fPIC")


class StrictC:
    """Compiles and links.

    Args:
        folder: where objects are kept by their digest, for all workers alike.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(exist_ok=True)
        self._folder = folder

    def compiled(self, source: Path) -> Path:
        """The object of a source, which includes headers of its own folder alone."""
        seen = b"".join(path.read_bytes() for path in (source, *sorted(source.parent.glob("*.h"))))
        made = self._folder / f"{hashlib.sha256(seen).hexdigest()[:24]}.o"
        if not made.exists():
            if gcc := shutil.which("gcc"):  # another may build it; what gcc has to say of it is heard as well
                subprocess.run([gcc, *STRICT, "-fsyntax-only", source], check=True)
            aside = made.with_suffix(f".{os.getpid()}.o")
            # What is only linked is named here, too, which clang would refuse as strictly.
            compile_c([source], aside, (*STRICT, "-Wno-unused-command-line-argument", "-c"))
            aside.replace(made)
        return made

    def link(self, sources: Iterable[Path], target: Path, *flags: str) -> None:
        """A program of some sources, or a library with the flag for it."""
        compile_c([self.compiled(source) for source in sources], target, flags)
