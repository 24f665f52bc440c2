"""A progress bar on a terminal, and silence elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


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

    def compiling(self, begins: bool) -> None:
        """Say beside the part under way that something is compiled, or that it is done."""
        self._name(self._what + "; compiling the loop, once after an installation" * begins)


def silent() -> Bar:
    """Return a bar that shows nothing."""
    return Bar("", lambda: None, lambda _: None)


@contextmanager
def progress_bar(title: str, total: int, show: bool | None = None) -> Iterator[Bar]:
    """Yield a bar; ``show`` None means only on a terminal."""
    if not (sys.stderr.isatty() if show is None else show):
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

    from frictionloop.quantities.compiled import on_compiling

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
