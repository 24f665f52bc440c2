"""A progress bar on a terminal; elsewhere silence, or plain lines if a program asks for them."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from frictionloop.quantities.compiling import COMPILING, on_compiling

FIRST_S, RARER, LOOK_S = 2.5, 4.0, 0.25
"""Until the first plain line, the factor from one wait to the next (five lines in 14 min), and how often to look."""
QUIET_S = 3.0
"""Work without parts that is done sooner is not told where there is no terminal (assumed)."""
_so_far_s = [0.0]
"""Since plain lines began."""

under_way: list[Callable[[], str]] = []
"""What is done while there is no terminal to show it on, the innermost last; empty text is not told."""

on_step: list[Callable[[str], None]] = []
"""Who is told which step of long work is under way, the innermost last."""


def step(said: str) -> None:
    """Say which step is under way to whom waits for it; to nobody else."""
    if on_step:
        on_step[-1](said)


class Bar:
    """Call it once per finished part; ``doing`` names the part under way, ``compiling`` says what it waits for."""

    def __init__(self, title: str, finish: Callable[[], None], name: Callable[[str], None]) -> None:
        self.title, self._finish, self._name, self._what = title, finish, name, title

    def __call__(self) -> None:
        """Count a part."""
        self._finish()

    def doing(self, what: str) -> None:
        """Say what is under way."""
        self._what = f"{self.title}: {what}"
        self._name(self._what)

    def inner(self) -> Bar:
        """Return a bar that counts nothing, and says on this one what is under way."""
        return Bar(self.title, lambda: None, self._name)

    def compiling(self, begins: bool) -> None:
        """Say beside the part under way that something is compiled, or that it is done."""
        self._name(self._what + COMPILING * begins)


@contextmanager
def _among(some: list[Any], one: Any) -> Iterator[None]:
    """Have one more who is told, or asked, of what is under way."""
    some.append(one)
    try:
        yield
    finally:
        some.remove(one)


def silent() -> Bar:
    """Return a bar that shows nothing."""
    return Bar("", lambda: None, lambda _: None)


@contextmanager
def progress_bar(title: str, total: int, show: bool | None = None) -> Iterator[Bar]:
    """Yield a bar; ``show`` None means on a terminal, and elsewhere for `plain_lines`."""
    if not (sys.stderr.isatty() if show is None else show):
        if show is None:
            with _plain_bar(title, total) as bar:
                yield bar
        else:
            yield silent()
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as bars:
        task = bars.add_task(title, total=total)
        bar = Bar(title, lambda: bars.advance(task), lambda text: bars.update(task, description=text))
        with _among(on_compiling, bar.compiling):
            yield bar


@contextmanager
def plain_lines(write: Callable[[str], None]) -> Iterator[None]:
    """Write what is under way: nothing for work that is soon done, then a line ever more rarely."""
    ended = threading.Event()

    def write_rarely() -> None:
        _so_far_s[0], next_s, wait_s = 0.0, FIRST_S, FIRST_S
        while not ended.wait(LOOK_S):
            _so_far_s[0] += LOOK_S
            said = under_way[-1]() if under_way else ""
            if said and _so_far_s[0] >= next_s:
                write(f"{said}, {_so_far_s[0]:.0f} s so far")
                wait_s *= RARER
                next_s = _so_far_s[0] + wait_s

    teller = threading.Thread(target=write_rarely, daemon=True)
    teller.start()
    try:
        yield
    finally:
        ended.set()
        teller.join()


@contextmanager
def waiting(text: str) -> Iterator[None]:
    """Show what is under way and its step, elsewhere than on a terminal by plain lines after `QUIET_S`."""
    if sys.stderr.isatty():
        from rich.console import Console

        with Console(stderr=True).status(text) as status, _steps(lambda said: status.update(text + said)):
            yield
        return
    begun_s, last = _so_far_s[0], [""]

    def now() -> str:
        return "" if _so_far_s[0] - begun_s < QUIET_S else text + last[-1]

    with _among(under_way, now), _steps(lambda said: last.__setitem__(-1, said)):
        yield


@contextmanager
def _steps(tell: Callable[[str], None]) -> Iterator[None]:
    """Have the steps of what is under way reported, and that something is compiled."""
    now = ""

    def report(said: str) -> None:
        nonlocal now
        now = f": {said}"
        tell(now)

    def compiling(begins: bool) -> None:
        tell(now + COMPILING * begins)

    with _among(on_step, report), _among(on_compiling, compiling):
        yield


@contextmanager
def _plain_bar(title: str, total: int) -> Iterator[Bar]:
    """Yield a bar that can tell in a line what is under way, and how much of it is done."""
    done, text, begun_s = 0, title, _so_far_s[0]

    def advance() -> None:
        nonlocal done
        done += 1

    def name(said: str) -> None:
        nonlocal text
        text = said

    def now() -> str:
        left_s = (total - done) * (_so_far_s[0] - begun_s) / done if done else 0.0
        return f"{text}: {done} of {total} done" + f", about {left_s:.0f} s left" * bool(left_s)

    bar = Bar(title, advance, name)
    with _among(on_compiling, bar.compiling), _among(under_way, now):
        yield bar
