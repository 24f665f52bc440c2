"""What the package weighs: lines of the command line, words that it can say, codes of the catalogue."""

from __future__ import annotations

import ast
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
