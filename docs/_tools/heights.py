"""Height of every built page in a browser: python docs/_tools/heights.py docs/_build/html.

Prints pages that are too high to read, and ends with 1 if there are any. Needs chromium; without one it says so.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HIGHEST_PX, WIDTH_PX = 8000, 1280
LOOKED_UP = ("parameters", "findings", "command-line", "protocol", "reference", "genindex", "search")
"""Pages that things are looked up in, and folders of such pages."""
MEASURE = """<!doctype html><meta charset="utf-8"><body><script>
const pages = PAGES, heights = {};
for (const page of pages) {
  const frame = document.createElement("iframe");
  frame.width = WIDTH; frame.height = 800; frame.src = page;
  frame.onload = () => setInterval(() => {
    heights[page] = frame.contentDocument.documentElement.scrollHeight;
    document.body.dataset.heights = JSON.stringify(heights);
  }, 500);
  document.body.append(frame);
}
</script></body>"""


def browser() -> str | None:
    """Return the browser of this machine, if there is one."""
    found = (shutil.which(name) for name in ("chromium", "chromium-browser", "google-chrome"))
    return next((name for name in found if name), None)


def heights(folder: Path, program: str) -> dict[str, int]:
    """Return the height of each page in pixels."""
    pages = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.html"))
    pages = [page for page in pages if not page.startswith(("_", *LOOKED_UP))]
    frames = folder / "_heights.html"
    frames.write_text(MEASURE.replace("PAGES", json.dumps(pages)).replace("WIDTH", str(WIDTH_PX)), encoding="utf-8")
    flags = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--dump-dom")
    try:
        with tempfile.TemporaryDirectory() as data:
            options = (f"--user-data-dir={data}", "--allow-file-access-from-files", "--virtual-time-budget=20000")
            call = [program, *flags, *options, frames.resolve().as_uri()]
            dom = subprocess.run(call, capture_output=True, text=True, check=True, timeout=600).stdout
    finally:
        frames.unlink()
    told = re.search(r'data-heights="([^"]*)"', dom)
    measured = json.loads(told[1].replace("&quot;", '"')) if told else {}
    if set(measured) != set(pages):
        raise RuntimeError(f"not measured: {sorted(set(pages) - set(measured))}")
    return measured


def main(folder: str) -> int:
    """Print what is too high; return whether anything is."""
    program = browser()
    if program is None:
        print("no chromium here: heights of pages are not measured")
        return 0
    high = {page: px for page, px in heights(Path(folder), program).items() if px > HIGHEST_PX}
    for page, px in sorted(high.items(), key=lambda one: -one[1]):
        print(f"{page}: {px} px, at most {HIGHEST_PX}")
    return int(bool(high))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
