"""Photograph the studio: the pictures of the guide, each size in light and dark.

    python docs/studio_pictures.py

One flight of `paper` is flown to its circle, pushed, and held there; every page shows that moment. Needs the
extra `dev` (Playwright's client) and a Chromium.
"""

from __future__ import annotations

import argparse
import io
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from picture import ARGUMENTS, browser, put  # beside this file
from PIL import Image
from playwright import sync_api

SIZES = ((1400, 900), (1920, 1080), (390, 844))
SCHEMES = ("light", "dark")
MOMENT = 17.0
"""Of the flight, s: the pen draws."""
PATIENCE = 120_000


def photograph(out: Path, controllers: list[str], most: int) -> int:
    """Fly, look, write; the number of bytes."""
    shown = browser()
    with sync_api.sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "skylimb", "studio", "paper", "--no-browser", "--out", folder]
        process = subprocess.Popen(
            [*command, *(["--controller", *controllers] if controllers else [])],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        address = re.search(r"http\S+", process.stdout.readline())
        if address is None:
            raise SystemExit("the studio has not begun; what it says stands above")
        url = address[0]
        chromium = playwright.chromium.launch(executable_path=shown, args=ARGUMENTS)
        try:
            _fly(chromium, url)
            pictures = {
                out / f"{size[0]}x{size[1]}-{scheme}.webp": _shot(chromium, url, size, scheme)
                for size in SIZES
                for scheme in SCHEMES
            }
        finally:
            chromium.close()
            process.terminate()
            process.wait(timeout=60)
    return put(pictures, most)


def _fly(chromium: sync_api.Browser, url: str) -> None:
    """Bring the flight to its moment, with a push on the way, and hold it there."""
    page = chromium.new_page()
    page.goto(url)
    page.wait_for_selector("body[data-ready]", timeout=PATIENCE)
    _until(page, "skylimbStudio.past.end > 3")
    page.get_by_role("tab", name="Poke").click()
    hold = page.get_by_role("button", name="Hold to poke")
    hold.focus()
    page.keyboard.down("Space")
    page.wait_for_timeout(500)
    page.keyboard.up("Space")
    _until(page, f"skylimbStudio.past.end > {MOMENT}")
    page.get_by_role("button", name="Pause").click()
    _until(page, "skylimbStudio.state.paused")
    page.close()


def _shot(chromium: sync_api.Browser, url: str, size: tuple[int, int], scheme: str) -> bytes:
    viewport: sync_api.ViewportSize = {"width": size[0], "height": size[1]}
    context = chromium.new_context(viewport=viewport, color_scheme="dark" if scheme == "dark" else "light")
    page = context.new_page()
    page.goto(url)
    page.wait_for_selector("body[data-ready]", timeout=PATIENCE)
    page.set_default_timeout(PATIENCE)
    # The seat of a page that has gone is given to the next one after some seconds.
    _until(page, "skylimbStudio.shell.seats.drives || document.getElementById('take-over').checkVisibility()")
    if (take := page.get_by_role("button", name="Take over")).is_visible():
        take.click(force=True)
    _until(page, "skylimbStudio.shell.seats.drives")
    page.get_by_role("button", name="Got it").click()
    page.wait_for_timeout(3000)  # drawn finely, once nothing moves
    shot = Image.open(io.BytesIO(page.screenshot(type="png", animations="disabled"))).convert("RGB")
    context.close()
    picture = io.BytesIO()
    shot.save(picture, format="WebP", quality=78, method=6)
    return picture.getvalue()


def _until(page: sync_api.Page, true: str) -> None:
    end = time.monotonic() + PATIENCE / 1000
    while not page.evaluate(true):
        if time.monotonic() > end:
            raise SystemExit(f"studio_pictures.py: waited in vain for {true}")
        time.sleep(0.01)


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=Path("docs/images/studio"))
    parser.add_argument("--controller", nargs="*", default=[], help="to be flown beside each other")
    parser.add_argument("--most", type=int, default=2_000_000, metavar="BYTES")
    given = parser.parse_args()
    size = photograph(given.out, given.controller, given.most)
    print(f"{given.out}: {1e-6 * size:.2f} MB")


if __name__ == "__main__":
    main()
