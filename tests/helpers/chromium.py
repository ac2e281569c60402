"""A real browser without a window, that draws in software and talks to nobody."""

import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

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

WORDS = """(page) => {
    const { sceneView: view } = window[page], { camera, canvas } = view, found = [];
    for (const [i, left, top, w, h] of view.cells()) {
        const high = h * canvas.clientHeight, part = 2 * Math.tan(camera.fov * Math.PI / 360) / high;
        view.scenes[i].traverseVisible((one) => {
            if (!one.isSprite || one.material.opacity === 0) return;
            const place = view.placeOf(i, one.getWorldPosition(camera.position.clone()));
            if (!place) return;
            const [width, height] = [one.scale.x / part, one.scale.y / part];
            found.push([place[0] * canvas.clientWidth - one.center.x * width,
                        place[1] * canvas.clientHeight - (1 - one.center.y) * height, width, height]);
        });
    }
    return found;
}"""
"""Where a page's picture has words, px: left, top, width, height; takes the name of the page's object."""

PATIENCE = 60.0
"""Seconds for which a test waits for anything, on a machine that has much else to do."""


def wait_for(true: Callable[[], Any]) -> None:
    """Wait until it is so."""
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end, "it did not come true"
        time.sleep(0.02)


def until(page: sync_api.Page, expression: str) -> None:
    """Wait in the test, as the studio's policy forbids a page to evaluate texts."""
    wait_for(lambda: page.evaluate(expression))


def overlapping(boxes: list[list[float]]) -> list[tuple[list[float], list[float]]]:
    """Pairs of boxes (left, top, width, height) that lie on each other."""
    return [
        (a, b)
        for k, a in enumerate(boxes)
        for b in boxes[:k]
        if min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0]) > 0.5
        and min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1]) > 0.5
    ]


def beyond(page: sync_api.Page) -> list[str]:
    """What does not fit a page's width: what stands out of it, and what must be scrolled sideways."""
    return page.evaluate(
        "() => [...document.querySelectorAll('body *')]"
        ".filter((one) => one.checkVisibility() && one.clientWidth)"
        ".filter((one) => one.getBoundingClientRect().right > innerWidth + 1"
        " || getComputedStyle(one).overflowX !== 'visible' && one.scrollWidth > one.clientWidth + 1)"
        ".map((one) => one.outerHTML.slice(0, 120))"
    )


_ARGUMENTS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-accelerated-2d-canvas",
    "--disable-gpu-rasterization",
]

_SELDOM = "window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 100);"
"""Ten pictures a second: a browser that draws in software takes two processors, and tests fly beside it."""


def serious(page: sync_api.Page, *rules: str, within: Sequence[str] = ()) -> list[str]:
    """What axe finds that keeps people from using a page, or parts of it: each rule and its first element."""
    options = {"resultTypes": ["violations"]} | ({"runOnly": list(rules)} if rules else {})
    parts = {"include": [[part] for part in within]} if within else None
    found = Axe().run(page, context=parts, options=options).response["violations"]
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
    surroundings.add_init_script(_SELDOM)
    page = surroundings.new_page()
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    yield page
    surroundings.close()
    assert [line for line in said if "GPU stall" not in line] == []
