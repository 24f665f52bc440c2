"""Golden files: what a person is shown, kept as text. FRICTIONLOOP_GOLDEN=1 writes them anew."""

from __future__ import annotations

import os
from pathlib import Path

from frictionloop.findings.render import LINES, WIDTH

GOLDEN = Path(__file__).parents[1] / "golden"
REWRITE = "FRICTIONLOOP_GOLDEN"


def check_golden(name: str, text: str) -> None:
    """Compare a text with tests/golden/NAME, or write it there."""
    path, text = GOLDEN / name, "\n".join(line.rstrip() for line in text.splitlines()) + "\n"
    if os.environ.get(REWRITE):
        path.write_text(text, encoding="utf-8")
    assert path.exists(), f"{path.name} is not there: {REWRITE}=1 writes it"
    assert text == path.read_text(encoding="utf-8"), f"{path.name} differs: {REWRITE}=1 writes it anew"


def check_screen(name: str, text: str) -> None:
    """Compare a screen with tests/golden/NAME.txt; it fits a terminal."""
    check_golden(f"{name}.txt", text)
    rows = text.splitlines()
    assert len(rows) <= LINES and max(map(len, rows)) <= WIDTH
