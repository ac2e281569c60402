"""Says in the first line of each bundle what it was made from; `make web` runs it, a test checks the lines.

python web/stamp.py
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

WEB = Path(__file__).parent
_PACKAGE = WEB.parent / "src" / "skylimb"
BUNDLES = tuple(
    _PACKAGE / name
    for name in (
        "analysis/viewer/vendor.js",
        "analysis/viewer/viewer.js",
        "analysis/viewer/viewer.css",
        "apps/studio/page/studio.js",
        "apps/studio/page/studio.css",
    )
)


def first_line(content: str) -> str:
    """What stands before a bundle's content: digests of sources and content, and versions of what is inside.

    Args:
        content: of the bundle, without that line.
    """
    package = json.loads((WEB / "package.json").read_text(encoding="utf-8"))
    versions = {**package["dependencies"], **package["devDependencies"]}
    listed = ", ".join(f"{name} {version}" for name, version in versions.items())
    return f"/* make web: sources {_sources()}, content {_digest(content.encode())}, {listed} */\n"


def _sources() -> str:
    """Digest of everything that bundles are made from, whatever the ends of its lines are."""
    found = [
        path
        for path in sorted(WEB.rglob("*"))
        if path.suffix in (".js", ".cjs", ".css", ".json") and "node_modules" not in path.parts
    ]
    texts = [f"{path.relative_to(WEB).as_posix()}\n{path.read_text(encoding='utf-8')}" for path in found]
    return _digest("\0".join(texts).encode())


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


if __name__ == "__main__":
    for bundle in BUNDLES:
        made = bundle.read_text(encoding="utf-8")
        bundle.write_text(first_line(made) + made, encoding="utf-8", newline="\n")
