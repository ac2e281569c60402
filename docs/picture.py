"""Film the replay of a flight: the moving picture of the README.

    make picture        (or: python docs/picture.py --out docs/images/hybrid.webp)

A headless Chromium shows the replay's page, one moment after the other, so that the film is the same however
fast the machine is. Needs the extra `dev` (Playwright's client) and a Chromium.
"""

from __future__ import annotations

import argparse
import io
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from PIL import Image
from playwright import sync_api

import skylimb
from skylimb.analysis.viewer.page import FlightViewer
from skylimb.base.files import replacing

SIZE = (720, 600)
"""Pixels of the film."""

FRAMES_A_SECOND = 12.5
SPEED = 4.0
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
LOOK = """
main { padding: 0 !important; max-width: none !important; } .replay { margin: 0 !important; }
.replay .bar, .replay .u-legend { display: none !important; }
.replay .picture { border-radius: 0 !important; border: 0 !important; }
.replay .picture > canvas { height: 405px !important; }
.replay .plots { grid-template-columns: 1fr 1fr !important; gap: 0 !important; padding: .3rem .2rem 0 0; }
"""
PANELS = ("Centre of gravity along z (m)", "Pressing force (N)")


def browser() -> str:
    """The Chromium of this machine.

    Raises:
        SystemExit: when there is none.
    """
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        raise SystemExit(f"none of {', '.join(BROWSERS)} is installed")
    return found


def put(pictures: Mapping[Path, bytes], most: int) -> int:
    """Write pictures in the place of those that are there; the number of bytes.

    Raises:
        SystemExit: when they have more than `most` bytes together. Those that are there stay.
    """
    size = sum(map(len, pictures.values()))
    if size > most:
        names = ", ".join(path.name for path in pictures)
        raise SystemExit(f"{names}: {1e-6 * size:.1f} MB, more than {1e-6 * most:g} MB; nothing was written")
    for path, picture in pictures.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as aside:
            aside.write_bytes(picture)
    return size


def film(controller: str, path: Path, most: int) -> int:
    """Fly, film, write; the number of bytes."""
    chromium = browser()
    run = skylimb.run("paper", controller)
    with tempfile.TemporaryDirectory() as folder:
        page_file = Path(folder) / "page.html"
        page_file.write_text(FlightViewer({controller: run}).page, encoding="utf-8")
        frames = _frames(chromium, page_file)
    moving = io.BytesIO()
    frames[0].save(
        moving,
        format="WebP",
        save_all=True,
        append_images=frames[1:],
        duration=round(1000 / FRAMES_A_SECOND),
        loop=0,
        quality=62,
        method=6,
    )
    return put({path: moving.getvalue()}, most)


def _frames(browser: str, page_file: Path) -> list[Image.Image]:
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=browser, args=ARGUMENTS)
        page = chromium.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme="light")
        page.goto(page_file.as_uri())
        page.wait_for_selector("#replay[data-ready]")
        page.add_style_tag(content=LOOK)
        page.evaluate(
            "(titles) => { const { plots, sceneView } = skylimbReplay;"
            " for (const panel of document.querySelectorAll('.replay .panel'))"
            "  if (!titles.includes(panel.querySelector('.u-title').textContent)) panel.remove();"
            " plots.plots = plots.plots.filter((plot) => plot.root.isConnected);"
            " plots.resize(); sceneView.showAxes(false); sceneView.adapt(60, false); sceneView.zoom(0.85); }",
            list(PANELS),
        )
        end = page.evaluate("skylimbReplay.clock.end")
        frames = []
        step = SPEED / FRAMES_A_SECOND
        for k in range(int(end / step) + 1):
            page.evaluate(
                "(time) => { skylimbReplay.clock.set(time); skylimbReplay.sceneView.render(); }", k * step
            )
            shot = page.screenshot(type="png", animations="disabled")
            frames.append(Image.open(io.BytesIO(shot)).convert("RGB"))
        chromium.close()
    return frames


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--controller", default="hybrid")
    parser.add_argument("--out", type=Path, default=Path("docs/images/hybrid.webp"))
    parser.add_argument("--most", type=int, default=2_000_000, metavar="BYTES")
    given = parser.parse_args()
    size = film(given.controller, given.out, given.most)
    print(f"{given.out}: {1e-6 * size:.2f} MB")


if __name__ == "__main__":
    main()
