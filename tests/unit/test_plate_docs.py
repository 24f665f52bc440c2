"""The page about the plate: its blocks run and print what the text around them says."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import matplotlib as mpl
import pytest

DOCS = Path(__file__).parents[2] / "docs"
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", (DOCS / "plate.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


@pytest.fixture
def page(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(DOCS / "_tools"))
    mpl.use("Agg")
    from page import Page

    yield Page(tmp_path)
    for name in [name for name, module in sys.modules.items() if str(DOCS) in str(getattr(module, "__file__", ""))]:
        del sys.modules[name]


def test_the_blocks_print_what_the_page_says(page):
    shown = [page.run(language, text) for language, text in BLOCKS]
    text = "".join(printed for printed, _ in shown)
    for words in (
        "26.29",
        "46.26",
        "12 lines  3.00 mm  46.26 kHz  268 g   thickness and frequency",
        "45.977 kHz, 391 levels",
    ):
        assert words in text


def test_the_code_fits_the_page():
    assert [line for _, text in BLOCKS for line in text.splitlines() if len(line) > 88] == []
