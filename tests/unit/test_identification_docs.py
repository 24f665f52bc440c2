"""The page on calibration: its code runs and prints what it shows, and its table holds what the functions give."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

import frictionloop.identification as find

PAGE = (Path(__file__).parents[2] / "docs" / "calibration.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def test_the_code_prints_what_the_page_shows():
    names: dict[str, object] = {}
    shown = 0
    for k, (language, text) in enumerate(BLOCKS):
        if language != "python":
            continue
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(text, names)
        if printed.getvalue():
            assert BLOCKS[k + 1] == ("text", printed.getvalue())
            shown += 1
    assert shown == 5


def test_the_table_of_floors():
    rows = re.findall(r"^\|[^|]+\| ([\d.e-]+) \| ([\d.e-]+) \| ([\d.]+) \|$", PAGE, re.MULTILINE)
    for row, reading in zip(rows, find.floor_readings().values(), strict=True):
        # As printed: two digits, and a tenth of a decibel.
        assert [float(cell) for cell in row] == [
            pytest.approx(reading.density_n_rthz, rel=0.05),
            pytest.approx(reading.rms_n, rel=0.05),
            pytest.approx(reading.range_db, abs=0.051),
        ]


def test_code_fits_the_page():
    assert [line for _, text in BLOCKS for line in text.splitlines() if len(line) > 88] == []
