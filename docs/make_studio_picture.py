"""Draw docs/_static/studio.png: the page that docs/studio.md shows, as a browser has it six seconds into the run.

`.venv/bin/python docs/make_studio_picture.py`; it needs the extra `studio`, playwright, and a chromium on the PATH.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_tools"))

from studio_page import demo  # noqa: E402

AT_ROWS, SIZE = 6000, {"width": 1240, "height": 860}


def main() -> None:
    """Write the picture."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as started:
        page_file = Path(folder) / "page.html"
        page_file.write_text(demo(), encoding="utf-8")
        browser = started.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = browser.new_page(
            viewport=SIZE, reduced_motion="reduce", color_scheme="light"
        )
        page.goto(page_file.as_uri())
        page.wait_for_selector("#scope canvas")
        page.evaluate(
            "(rows) => { const seek = document.getElementById('seek'); seek.value = rows;"
            " seek.dispatchEvent(new Event('input')); }",
            AT_ROWS,
        )
        page.wait_for_timeout(500)
        page.screenshot(path=HERE / "_static" / "studio.png")
        browser.close()


if __name__ == "__main__":
    main()
