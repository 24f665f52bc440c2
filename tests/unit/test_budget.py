"""What the package weighs: lines of the command line, words that it can say, codes of the catalogue."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path

import pytest

import frictionloop

SRC = Path(frictionloop.__file__).parent
FEW = 6
"""Words of a literal below which it is a name, not a message."""
MOST_LINES = {"cli": 5000, "": 70_500}
MOST_WORDS = 10_000
"""Of messages, with titles and templates of the catalogue."""


def words_of(path: Path) -> int:
    """Return the words of text literals of six or more that are no docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    alone = [node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)]
    parts = [part for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values]
    skipped = {id(node) for node in [*alone, *parts]}
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            found.append("".join(part.value for part in node.values if isinstance(part, ast.Constant)))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in skipped:
            found.append(node.value)
    counts = [len(text.split()) for text in found]
    return sum(count for count in counts if count >= FEW)


@pytest.mark.parametrize("room", MOST_LINES)
def test_lines(room):
    files = (SRC / room).rglob("*.py")
    assert sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files) <= MOST_LINES[room]


def test_words_in_messages():
    catalogue = tomllib.loads((SRC / "findings" / "catalogue.toml").read_text(encoding="utf-8"))
    said = [f"{each['title']} {each.get('template', '')}" for each in catalogue.values()]
    assert sum(map(words_of, SRC.rglob("*.py"))) + sum(len(each.split()) for each in said) <= MOST_WORDS


# docs/reliability.md: every fault with all that is to be known of it, and commands that run a test.


ROOT = Path(__file__).parents[2]
TABLE = re.compile(r"^\|(?P<head>.+)\|\n\|[-|]+\|\n(?P<rows>(?:\|.+\|\n)+)", re.MULTILINE)
PAGE = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
TABLES = [found.groupdict() for found in TABLE.finditer(PAGE)]
ROWS = [row.strip("| ").split(" | ") for table in TABLES for row in table["rows"].splitlines()]


def test_a_table_tells_all_of_a_fault():
    assert TABLES
    for table in TABLES:
        columns = [column.strip() for column in table["head"].split("|")]
        assert columns[:2] == ["fault", "what happens"] and columns[-1] == "shown by"
        assert any(column.startswith("time to safe") for column in columns[2:-1])
        assert {row.count(" | ") for row in table["rows"].splitlines()} == {len(columns) - 1}


def test_a_command_is_there():
    broken_sensors = (ROOT / "tests/helpers/broken_sensors.py").read_text(encoding="utf-8")
    assert ROWS
    for row in ROWS:
        command = row[-1].strip("`")
        paths = [ROOT / word for word in command.split() if word.startswith("tests/")]
        if command.startswith("pytest "):
            assert paths and all(path.is_file() for path in paths), row
            word, text = command.partition(" -k ")[2], "".join(path.read_text(encoding="utf-8") for path in paths)
            assert word in text + broken_sensors, row
        else:
            assert (ROOT / command).is_file(), row


# Campaigns run outside continuous integration; what they found last is stored, and of which code.


def test_every_campaign_is_stored(campaigns):
    """A new or renamed campaign fails here until `make soak` has run it; a summary tells which are of other code.

    Hours of whole sensors may be fewer: docs/reliability.md tells how many.
    """
    there, stored = campaigns
    assert [name for name in there if name not in stored and "an_hour" not in name] == []
    assert [name for name, found in stored.items() if found["outcome"] not in ("passed", "xfailed", "failed")] == []
