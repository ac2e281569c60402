"""A real browser without a window, that draws in software and talks to nobody."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright import sync_api

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium here; the build machine installs it"
)

PAINTED = (
    "const c = document.createElement('canvas'); c.width = c.height = 64;"
    " const g = c.getContext('2d'); g.drawImage(t.canvas, 0, 0, 64, 64);"
    " return new Set(g.getImageData(0, 0, 64, 64).data).size;"
)
"""Body of a function in the page: how many different values the pixels of the scene view `t` have."""

_ARGUMENTS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
]


def serious(page: sync_api.Page) -> list[str]:
    """What axe finds on a page that keeps people from using it: each rule, and the first element."""
    found = Axe().run(page).response["violations"]
    return [
        f"{one['id']}: {one['nodes'][0]['html'][:150]} {one['nodes'][0]['failureSummary'][:200]}"
        for one in found
        if one["impact"] in ("serious", "critical")
    ]


@contextmanager
def chromium() -> Iterator[sync_api.Browser]:
    """The browser, until the end of the block."""
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=_ARGUMENTS)
        yield browser
        browser.close()


@contextmanager
def silent_page(browser: sync_api.Browser, **context: object) -> Iterator[sync_api.Page]:
    """A page; at the end of the block the browser must have had nothing to say of it."""
    surroundings = browser.new_context(viewport={"width": 1000, "height": 800}, **context)  # type: ignore[arg-type]
    page = surroundings.new_page()
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    yield page
    surroundings.close()
    assert [line for line in said if "GPU stall" not in line] == []
