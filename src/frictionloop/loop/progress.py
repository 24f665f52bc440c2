"""A progress bar on a terminal; elsewhere silence, or plain lines if a program asks for them."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from frictionloop.quantities.compiling import COMPILING, on_compiling

FIRST_S, LONGEST_S, LOOK_S = 2.5, 10.0, 0.25
"""Until the first plain line, between two at most (each wait is twice the one before), and how often to look."""

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
        on_compiling.append(bar.compiling)
        try:
            yield bar
        finally:
            on_compiling.remove(bar.compiling)


@contextmanager
def plain_lines(write: Callable[[str], None]) -> Iterator[None]:
    """Write what is under way: nothing for work that is soon done, then a line ever more rarely, and per new stage."""
    ended = threading.Event()

    def tell() -> None:
        so_far_s, next_s, wait_s = 0.0, FIRST_S, FIRST_S
        told_s, told = 0.0, None
        while not ended.wait(LOOK_S):
            so_far_s += LOOK_S
            now = under_way[-1] if under_way else None
            said = now() if now else ""
            new_stage = now is not told and so_far_s >= told_s + FIRST_S
            if said and (so_far_s >= next_s or (told is not None and new_stage)):
                told_s, told = so_far_s, now
                write(f"{said}, {so_far_s:.0f} s so far")
                wait_s = min(2 * wait_s, LONGEST_S)
                next_s = so_far_s + wait_s

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        ended.set()
        teller.join()


@contextmanager
def doing(now: Callable[[], str]) -> Iterator[None]:
    """Have it under way."""
    under_way.append(now)
    try:
        yield
    finally:
        under_way.remove(now)


@contextmanager
def _plain_bar(title: str, total: int) -> Iterator[Bar]:
    """Yield a bar that can tell in a line what is under way, and how much of it is done."""
    done, text = 0, title

    def advance() -> None:
        nonlocal done
        done += 1

    def name(said: str) -> None:
        nonlocal text
        text = said

    def now() -> str:
        return f"{text}: {done} of {total} done"

    bar = Bar(title, advance, name)
    on_compiling.append(bar.compiling)
    try:
        with doing(now):
            yield bar
    finally:
        on_compiling.remove(bar.compiling)
