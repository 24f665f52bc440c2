"""What a command shows: results on stdout, everything else on stderr, JSON with nothing around it."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from frictionloop.cli.flags import RESULT
from frictionloop.findings.render import lines
from frictionloop.findings.result import Result, plain


def _shown(said: str) -> Parameter:
    return Parameter(group=RESULT, help=said, show_default=False)


WIDEST = 100
"""Columns of the terminal beyond which lines are no longer easy to follow (chosen)."""
GAP = 2
"""Between columns."""


DOES_NOT_HOLD = 3
"""Exit code of an answer that is no error, and no."""


@Parameter(name="*")
@dataclass(frozen=True)
class Shown:
    """How an answer is shown."""

    json: Annotated[bool, _shown("Print one JSON object.")] = False
    all: Annotated[bool, _shown("All tables and findings.")] = False
    html: Annotated[Path | None, _shown("Write a page here (.html).")] = None

    def show(self, found: Result, saved: Mapping[str, Any] | None = None) -> None:
        """Write an answer to stdout, and what was saved where."""
        if self.html is not None:
            self.html.write_text(found.to_html(), encoding="utf-8")
        paths = {what: path for what, path in {**(saved or {}), "page": self.html}.items() if path}
        if self.json:
            show_json(found.to_dict() | {"saved": paths})
            return
        from rich.console import Console
        from rich.text import Text

        console = Console(highlight=False, markup=False)
        for line in lines(found, self.all):
            console.print(Text.assemble(*line), soft_wrap=True)
        for what, path in paths.items():
            print(f"saved {what}: {path}")


BRIEFLY = Shown()


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during work that keeps what is done; ``resumable`` if the same command with --resume goes on."""

    def __init__(self, said: str, resumable: bool) -> None:
        super().__init__(said)
        self.resumable = resumable


def interrupted(said: str, out: Any) -> Interrupted:
    """Return what to raise after Ctrl-C: how much is done, and whether a file keeps it."""
    kept = f"kept in {out}" if out else "not kept (--out FILE keeps it)"
    return Interrupted(f"{said}, {kept}", resumable=out is not None)


def say(line: str) -> None:
    """Write one line to stderr."""
    print(line, file=sys.stderr, flush=True)


def show(*renderables: Any) -> None:
    """Write to stdout as wide as the terminal, at most `WIDEST`, or as wide as a table needs for all its numbers."""
    from rich.console import Console

    console = Console(highlight=False, markup=False)
    width = min(console.width, WIDEST)
    for renderable in renderables:
        whole = isinstance(renderable, str)  # lines of text stay as they are
        console.width = max(width, getattr(renderable, "min_width", None) or 0)
        console.print(renderable, soft_wrap=whole)


def show_json(result: Mapping[str, Any]) -> None:
    """Write one JSON object to stdout; NaN becomes null, infinity a string."""
    print(json.dumps(plain(result), indent=2, ensure_ascii=False, allow_nan=False))


def wrapped(text: str) -> Any:
    """Return prose that is broken where the terminal ends."""
    from rich.text import Text

    return Text(text)


def columns(rows: Sequence[tuple[str, ...]]) -> Any:
    """Return rows as a borderless table: the first column a name, the last one free to wrap."""
    from rich.table import Table

    grid, last = Table.grid(padding=(0, GAP, 0, 0)), len(rows[0]) - 1
    for index in range(last + 1):
        grid.add_column(style="bold" if index == 0 else None, overflow="fold", no_wrap=index < last)
    for row in rows:
        grid.add_row(*row)
    return grid


def about(value: float) -> str:
    """Return a duration that is only estimated: 20 s, 3 min, 2 h."""
    for unit, size, most in (("s", 1.0, 90.0), ("min", 60.0, 90.0)):
        if value / size < most:
            number = value / size
            return f"{round(number, -1 if number >= 20 else 0):g} {unit}"
    return f"{value / 3600.0:.0f} h"
