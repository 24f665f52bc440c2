"""The constants of this board's C files."""

from __future__ import annotations

import ast
import re
from pathlib import Path

BOARD = Path(__file__).parent


def source(name: str) -> str:
    """Return a file of the board."""
    return (BOARD / name).read_text(encoding="utf-8")


def constants(name: str) -> dict[str, int]:
    """Return the constants of a C file that are made of numbers."""
    text = re.sub(r"/\*.*?\*/", "", source(name), flags=re.DOTALL)
    known: dict[str, int] = {}
    members = ",".join(re.findall(r"\benum \{(.*?)\}", text, re.DOTALL))
    for key, expression in re.findall(r"(\w+) = ([^,]+)", members):
        known[key] = evaluate(expression, known)
    for key, expression in re.findall(r"#define (\w+) (\(\d.*<<.*\))\n", text):
        known[key] = evaluate(expression, known)
    return known


def evaluate(expression: str, known: dict[str, int]) -> int:
    """Return what a sum, shift or union of numbers and known names is; -1 for anything else."""

    def value(node: ast.expr) -> int:
        match node:
            case ast.Constant(int(number)):
                return number
            case ast.Name(name):
                return known[name]
            case ast.BinOp(left, ast.BitOr(), right):
                return value(left) | value(right)
            case ast.BinOp(left, ast.LShift(), right):
                return value(left) << value(right)
        raise KeyError(expression)

    try:
        return value(ast.parse(re.sub(r"\b(\d+)u\b", r"\1", expression.strip()), mode="eval").body)
    except (KeyError, SyntaxError):
        return -1
