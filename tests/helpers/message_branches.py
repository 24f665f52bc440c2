"""Branches on text of our own: what a lint of ``src`` refuses outside of renderers."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

METHODS = {"startswith", "endswith", "partition", "rpartition", "split", "removeprefix", "removesuffix", "find"}
PATTERNS = {"match", "search", "fullmatch", "findall", "finditer", "sub", "split"}


def branches_on_messages(path: Path) -> Iterator[int]:
    """Yield the lines of a file in which the text of an error is compared, searched, cut, or its ``args`` are read."""
    for handler in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(handler, ast.ExceptHandler) or handler.name is None or not _ours(handler.type):
            continue
        for node in (each for part in handler.body for each in ast.walk(part)):
            if _judged(node, handler.name):
                yield node.lineno


def _ours(caught: ast.expr | None) -> bool:
    names = [each.id for each in ast.walk(caught) if isinstance(each, ast.Name)] if caught else []
    return any(name.endswith("FrictionloopError") or name == "DeviceError" for name in names)


def _judged(node: ast.AST, error: str) -> bool:
    def text(each: ast.AST) -> bool:
        """Tell whether it is ``str(error)``, or an f-string with it."""
        call = isinstance(each, ast.Call) and isinstance(each.func, ast.Name) and each.func.id == "str"
        return call and any(isinstance(a, ast.Name) and a.id == error for a in each.args)  # type: ignore[attr-defined]

    if isinstance(node, ast.Attribute) and node.attr == "args" and isinstance(node.value, ast.Name):
        return node.value.id == error
    if isinstance(node, ast.Compare):
        return any(text(each) for each in (node.left, *node.comparators))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        cut = node.func.attr in METHODS and text(node.func.value)
        return cut or (node.func.attr in PATTERNS and any(text(each) for each in node.args))
    return False
