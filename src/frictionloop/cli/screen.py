"""What a command shows: results on stdout, everything else on stderr, JSON with nothing around it."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Group, Parameter

from frictionloop.findings import Finding
from frictionloop.findings.render import lines
from frictionloop.findings.result import Result
from frictionloop.loop.progress import doing, on_step
from frictionloop.quantities.compiling import COMPILING, on_compiling

RESULT = Group("Result", sort_key=3)


def _shown(said: str) -> Parameter:
    return Parameter(group=RESULT, help=said, show_default=False)


QUIET_S = 3.0
"""Work without parts that is done sooner is not told where there is no terminal (chosen)."""
FORECAST_S = 6.0
"""Until when lines have the forecast as well: after the first of them, before the second (chosen)."""
WIDEST = 100
"""Columns of the terminal beyond which lines are no longer easy to follow (chosen)."""
NAME = 11
"""Least width of a column of names that wraps, in columns of the terminal (chosen)."""
GAP = 2
"""Between columns."""


DOES_NOT_HOLD = 3
"""Exit code of an answer that is no error, and no."""


@Parameter(name="*")
@dataclass(frozen=True)
class Shown:
    """How an answer is shown."""

    json: Annotated[bool, _shown("Print the answer as one JSON object.")] = False
    all: Annotated[bool, _shown("All tables and findings.")] = False
    html: Annotated[Path | None, _shown("Write the answer as a page here (.html).")] = None

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
    kept = f"kept in {out}" if out else "not kept: without --out there is nothing to continue from"
    return Interrupted(f"{said}, {kept}", resumable=out is not None)


_NOTES: list[str] = []


def note(line: str) -> None:
    """Keep a line for stderr until there is a result, or long work begins: bad input is one line."""
    _NOTES.append(line)


def note_findings(found: Iterable[Finding]) -> None:
    """Keep findings as lines."""
    for each in found:
        note(f"{each.severity} {each.code}: {each}")


def tell_notes() -> None:
    """Write what was kept."""
    while _NOTES:
        say(_NOTES.pop(0))


def forget_notes() -> None:
    """Drop what an earlier command has kept."""
    _NOTES.clear()


def say(line: str) -> None:
    """Write one line to stderr."""
    print(line, file=sys.stderr, flush=True)


def show(*renderables: Any) -> None:
    """Write to stdout as wide as the terminal, at most `WIDEST`, or as wide as a table needs for all its numbers."""
    from rich.console import Console

    tell_notes()
    console = Console(highlight=False, markup=False)
    width = min(console.width, WIDEST)
    for renderable in renderables:
        whole = isinstance(renderable, str)  # lines of text stay as they are
        console.width = max(width, getattr(renderable, "min_width", None) or 0)
        console.print(renderable, soft_wrap=whole)


def show_json(result: Mapping[str, Any]) -> None:
    """Write one JSON object to stdout; NaN and infinity, which JSON lacks, become null."""
    tell_notes()
    print(json.dumps(_plain(result), indent=2, ensure_ascii=False, allow_nan=False))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(name): _plain(inner) for name, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if hasattr(value, "tolist"):  # NumPy
        return _plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)


@contextmanager
def waiting(text: str, forecast: str = "") -> Iterator[None]:
    """Show what is under way and its step, elsewhere than on a terminal by plain lines after `QUIET_S`.

    ``forecast``, how much it is and how long it takes, follows the text; in lines, in the first.
    """
    if sys.stderr.isatty():
        from rich.console import Console

        whole = text + forecast
        with Console(stderr=True).status(whole) as status, _steps(lambda said: status.update(whole + said)):
            yield
        return
    began_s, step = time.perf_counter(), [""]

    def now() -> str:
        lasts_s = time.perf_counter() - began_s
        return "" if lasts_s < QUIET_S else text + forecast * (lasts_s < FORECAST_S) + step[-1]

    with doing(now), _steps(lambda said: step.__setitem__(-1, said)):
        yield


@contextmanager
def _steps(tell: Callable[[str], None]) -> Iterator[None]:
    """Have the steps of what is under way told, and that something is compiled."""
    now = ""

    def step(said: str) -> None:
        nonlocal now
        now = f": {said}"
        tell(now)

    def compiling(begins: bool) -> None:
        tell(now + COMPILING * begins)

    on_step.append(step)
    on_compiling.append(compiling)
    try:
        yield
    finally:
        on_step.remove(step)
        on_compiling.remove(compiling)


def wrapped(text: str) -> Any:
    """Return prose that is broken where the terminal ends."""
    from rich.text import Text

    return Text(text)


def columns(rows: Sequence[tuple[str, ...]]) -> Any:
    """Return rows as a borderless table: the first column a name, the last one free to wrap."""
    last = len(rows[0]) - 1
    return _grid(rows, [{"no_wrap": index < last} for index in range(last + 1)])


def table(rows: Sequence[tuple[str, ...]], whole: bool = False) -> Any:
    """Return rows under a heading, numbers to the right; in a narrow terminal the first column wraps alone.

    No number is cut: where they do not fit, lines are longer than the terminal is wide. The last column is of words.
    ``whole``: the first one is of names, and no name is broken in two.
    """
    longest, *widths = (max(map(len, column)) for column in zip(*rows, strict=True))
    first: dict[str, Any] = {"min_width": longest if whole else min(longest, NAME)}
    numbers: list[dict[str, Any]] = [{"no_wrap": True, "justify": "right", "min_width": width} for width in widths[:-1]]
    last: list[dict[str, Any]] = [{"no_wrap": True, "min_width": widths[-1]}] if widths[-1] else []
    kept = [first, *numbers, *last]
    grid = _grid([row[: len(kept)] for row in rows], kept)
    grid.min_width = sum(each["min_width"] for each in kept) + GAP * (len(kept) - 1)
    return grid


def _grid(rows: Sequence[tuple[str, ...]], columns: Sequence[Mapping[str, Any]]) -> Any:
    from rich.table import Table

    grid = Table.grid(padding=(0, GAP, 0, 0))
    for index, column in enumerate(columns):
        grid.add_column(style="bold" if index == 0 else None, overflow="fold", **column)
    for row in rows:
        grid.add_row(*row)
    return grid


def saved(paths: Mapping[str, Any], replaced: Collection[Any] = ()) -> list[str]:
    """Return a line for each file that was asked for, and that it replaced one of that name."""
    there = dict.fromkeys(replaced, ", which replaced the one that was there")
    return [f"saved {what} as {path}{there.get(path, '')}" for what, path in paths.items() if path]


def about(value: float) -> str:
    """Return a duration that is only estimated: 20 s, 3 min, 2 h."""
    for unit, size, most in (("s", 1.0, 90.0), ("min", 60.0, 90.0)):
        if value / size < most:
            number = value / size
            return f"{round(number, -1 if number >= 20 else 0):g} {unit}"
    return f"{value / 3600.0:.0f} h"


def seconds(value: float) -> str:
    """Return a duration with a readable unit: 2.1 ms, 3.4 s."""
    return f"{value * 1e3:.3g} ms" if value < 1 else f"{value:.3g} s"
