"""Draw docs/_static/studio.webp: one stroke there and back on the studio's page, on the page's own clock.

`.venv/bin/python docs/make_moving_picture.py`; it needs the extra `studio`, playwright, and a chromium on the PATH.
"""

from __future__ import annotations

import io
import shutil
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

import frictionloop as fl

TARGET = Path(__file__).parent / "_static" / "studio.webp"
SIZE, DRAWN = {"width": 1060, "height": 700}, {"width": 1060, "height": 622}
PERIOD_MS, STEP_MS, SETTLES_MS = 4000, 80, 4000
"""The ghost's way there and back: 76 mm at 40 mm/s and two turns of 0.1 s."""
PLAIN = "#fields, #box-signals, .gallery, #scale-open, #crowd-card, #ahead-told, label:has(#ahead), #tour, #look, #status, .foot { display: none !important }"


def frames(page: Page) -> list[Image.Image]:
    """Return the pictures of one period."""
    for _ in range(SETTLES_MS // STEP_MS):
        page.clock.run_for(STEP_MS)
    found = []
    for _ in range(PERIOD_MS // STEP_MS):
        page.clock.run_for(STEP_MS)
        shot = page.screenshot(clip={"x": 0, "y": 0, **DRAWN})
        found.append(Image.open(io.BytesIO(shot)).convert("RGB"))
    return found


def main() -> None:
    """Write the picture."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as started:
        play = fl.studio.export(Path(folder) / "play.html").path
        program, flags = shutil.which("chromium"), ["--no-sandbox"]
        browser = started.chromium.launch(executable_path=program, args=flags)
        page = browser.new_page(viewport=SIZE, color_scheme="light")
        page.clock.install(time=0)
        page.goto(play.as_uri())
        page.wait_for_function("document.body.dataset.build !== undefined")
        page.clock.pause_at(SETTLES_MS)
        page.add_style_tag(content=PLAIN)
        first, *rest = frames(page)
        browser.close()
    first.save(TARGET, save_all=True, append_images=rest, duration=STEP_MS, loop=0, quality=60, method=6)


if __name__ == "__main__":
    main()
