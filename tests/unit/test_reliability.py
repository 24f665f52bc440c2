"""docs/reliability.md: every fault with all that is to be known of it, and commands that run a test."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TABLE = re.compile(r"^\|(?P<head>.+)\|\n\|[-|]+\|\n(?P<rows>(?:\|.+\|\n)+)", re.MULTILINE)
PAGE = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
TABLES = [found.groupdict() for found in TABLE.finditer(PAGE)]
ROWS = [row.strip("| ").split(" | ") for table in TABLES for row in table["rows"].splitlines()]


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table["rows"][:40])
def test_a_table_tells_all_of_a_fault(table):
    columns = [column.strip() for column in table["head"].split("|")]
    assert columns[:2] == ["fault", "what happens"] and columns[-1] == "shown by"
    assert any(column.startswith("time to safe") for column in columns[2:-1])
    assert {row.count(" | ") for row in table["rows"].splitlines()} == {len(columns) - 1}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_a_command_is_there(row):
    command = row[-1].strip("`")
    if not command.startswith("pytest "):
        assert (ROOT / command).is_file()
        return
    paths = [ROOT / word for word in command.split() if word.startswith("tests/")]
    assert paths and all(path.is_file() for path in paths)
    word, text = command.partition(" -k ")[2], "".join(path.read_text(encoding="utf-8") for path in paths)
    assert word in text + (ROOT / "tests/helpers/broken_sensors.py").read_text(encoding="utf-8")
