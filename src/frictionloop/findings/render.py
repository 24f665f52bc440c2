"""The one way in which answers are shown: lines for a terminal, a fragment for a notebook, a page for a browser."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING

from frictionloop.findings.catalogue import explain
from frictionloop.findings.shown import shown

if TYPE_CHECKING:
    from frictionloop.findings.finding import Finding
    from frictionloop.findings.result import Result, Table

WIDTH, LINES, WORST, GAP = 80, 23, 5, 2
"""Columns and lines of an answer (a 24th says what was saved), its findings, and the space between columns."""
Piece = tuple[str, str]
"""Text and its style, as rich names it."""
Line = list[Piece]
STYLE = {"error": "bold red", "warning": "bold yellow", "note": "dim"}


def text(result: Result, everything: bool = False) -> str:
    """Return the lines of an answer; with ``everything`` all tables and findings."""
    return "\n".join("".join(piece for piece, _ in line).rstrip() for line in lines(result, everything))


def lines(result: Result, everything: bool = False) -> list[Line]:
    """Return the styled lines of an answer: its rows, its first table, the worst findings and how many more."""
    rows, tables = list(result.rows()), list(result.tables().items())
    found = [*_rows(rows)]
    for name, frame in tables if everything else tables[:1]:
        found += [*([[]] if found else []), *([[(name, "bold")]] if everything else []), *_table(frame)]
    told = result.findings if everything else result.findings[:WORST]
    left = len(result.findings) - len(told)
    room = LINES - len(found) - 1 - (left > 0)
    found += [[]] if told else []
    found += _findings(told, len(told) + 99 if everything else room)
    found += [[(f"{left} more: --all", "dim")]] if left else []
    return found


def _rows(rows: Sequence[tuple[str, str]]) -> Iterator[Line]:
    """Yield names and what is said of them, in two columns, the second wrapped."""
    width = max((len(name) for name, _ in rows), default=0) + GAP
    for name, said in rows:
        for k, part in enumerate(_wrapped(said, WIDTH - width) or [""]):
            yield [("" if k else name, "bold"), (" " * (width - len("" if k else name)), ""), (part, "")]


def _table(frame: Table) -> Iterator[Line]:
    """Yield a table with its numbers to the right."""
    columns = [[str(frame.index.name or ""), *(str(each) for each in frame.index)]]
    columns += [[str(head), *map(shown, frame[head].tolist())] for head in frame.columns]
    left = [True, *(all(isinstance(each, str) for each in frame[head]) for head in frame.columns)]
    widths = [max(map(len, column)) for column in columns]
    for k, cells in enumerate(zip(*columns, strict=True)):
        padded = [c.ljust(w) if at else c.rjust(w) for c, w, at in zip(cells, widths, left, strict=True)]
        yield [((" " * GAP).join(padded), "bold" if k == 0 else "")]


def _findings(told: Sequence[Finding], most: int) -> Iterator[Line]:
    """Yield findings, broken where the terminal ends; the last of them cut to a line where they need more than most."""
    width = max((len(each.code) for each in told), default=0) + GAP
    wrapped = [_wrapped(str(each), WIDTH - 8 - width) for each in told]
    for k in range(len(told) - 1, -1, -1):
        if sum(map(len, wrapped)) > most:
            wrapped[k] = [textwrap.shorten(str(told[k]), WIDTH - 8 - width, placeholder=" ...")]
    for each, parts in zip(told, wrapped, strict=True):
        for k, part in enumerate(parts):
            head = f"{each.severity:<8}" if k == 0 else " " * 8
            yield [(head, STYLE[str(each.severity)]), ((each.code if k == 0 else "").ljust(width), ""), (part, "")]


def _wrapped(said: str, width: int) -> list[str]:
    """Return lines between which no number is parted from its %."""
    return [part.replace("\u00a0", " ") for part in textwrap.wrap(said.replace(" %", "\u00a0%"), width)]


def fragment(result: Result) -> str:
    """Return everything as HTML for a notebook or within a page."""
    rows = "".join(f"<tr><th>{escape(name)}</th><td>{escape(said)}</td></tr>" for name, said in result.rows())
    parts = [f"<table>{rows}</table>"] if rows else []
    for name, frame in result.tables().items():
        parts.append(f"<h4>{escape(name)}</h4>{_table_html(frame)}")
    return "\n".join([*parts, *([findings_html(result.findings)] if result.findings else [])])


def findings_html(found: Sequence[Finding]) -> str:
    """Return findings as a table in HTML, the explanation behind each."""
    told = "".join(
        f'<tr title="{escape(explain(each.code).explanation)}"><td>{each.severity}</td>'
        f"<td><code>{each.code}</code></td><td>{escape(str(each))}</td></tr>"
        for each in found
    )
    return f"<table>{told}</table>"


def _table_html(frame: Table) -> str:
    heads = "".join(f"<th>{escape(str(each))}</th>" for each in (frame.index.name or "", *frame.columns))
    body = "".join(
        f"<tr><th>{escape(str(name))}</th>{''.join(f'<td>{escape(shown(each))}</td>' for each in cells)}</tr>"
        for name, cells in zip(frame.index, frame.itertuples(index=False), strict=True)
    )
    return f"<table><tr>{heads}</tr>{body}</table>"


PAGE = """<!doctype html><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #1a1a1a }}
table {{ border-collapse: collapse; margin: 1em 0 }} th, td {{ padding: .2em 1em .2em 0; text-align: left;
border-bottom: 1px solid #e6e6e6; vertical-align: top; font-variant-numeric: tabular-nums }}
code {{ white-space: nowrap }}
</style><h1>{title}</h1>{body}
"""


def page(result: Result) -> str:
    """Return a page of its own."""
    verb, rows = result.SCHEMA.partition("/")[0].replace(".", " "), result.rows()
    title = f"{verb}: {' '.join(rows[0])}" if rows else verb
    return PAGE.format(title=escape(title), body=fragment(result))
