"""The committed bundles are those of the sources in `web/`; looked at without Node."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

WEB = Path(__file__).parents[1] / "web"


def _stamp() -> ModuleType:
    spec = importlib.util.spec_from_file_location("stamp", WEB / "stamp.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


STAMP = _stamp()


@pytest.mark.parametrize("bundle", STAMP.BUNDLES, ids=lambda path: path.name)
def test_a_bundle_is_made_from_its_sources(bundle: Path) -> None:
    line, _, content = bundle.read_text(encoding="utf-8").partition("\n")
    assert f"{line}\n" == STAMP.first_line(content), "make it anew: make web"


def test_versions_are_fixed() -> None:
    line = STAMP.first_line("")
    assert len(re.findall(r"\b(?:three|uplot|esbuild) \d+\.\d+\.\d+\b", line)) == 3


def test_the_vendor_bundle_has_all_that_pages_use() -> None:
    names = re.compile(r"\{([^}]*)\}\s*from")
    there = names.findall((WEB / "shared" / "vendor.js").read_text(encoding="utf-8"))
    known = {name.rpartition(" as ")[2].strip() for part in there for name in part.split(",")}
    for path in WEB.glob("*/*.js"):
        for part in re.findall(r"import \{([^}]*)\} from \"vendor\"", path.read_text(encoding="utf-8")):
            wanted = {name.strip() for name in part.split(",")} - {""}
            assert wanted <= known, path.name
