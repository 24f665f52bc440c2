"""The code blocks of a page, run from top to bottom in one folder and one namespace.

``python`` blocks run, and show figures that they name or `plt.show`; if the last line ends with ``# refused``
the error is what the block shows. ``toml`` blocks whose first line is ``# some-name.toml`` become that file. Lines
``$ frictionloop ...`` of ``console`` blocks run, also with ``| head -n 3`` or ``| tail -n 3`` after them.
"""

from __future__ import annotations

import contextlib
import io
import logging
import os
import shlex
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from frictionloop import FrictionloopError

LANGUAGES = ("python", "toml", "console")
REFUSED = "# refused"


@dataclass
class Page:
    """What the blocks of one page share."""

    folder: Path
    style: dict[str, Any] = field(default_factory=dict)
    names: dict[str, Any] = field(default_factory=lambda: {"__name__": "__main__"})

    def run(self, language: str, text: str) -> tuple[str, list[Figure]]:
        """Run one block; return what it printed (for ``console`` the block with the answers in it) and its figures."""
        logging.disable(logging.WARNING)  # a cluster that starts and stops has much to say
        try:
            with contextlib.chdir(self.folder), warnings.catch_warnings(), mpl.rc_context(self.style):
                warnings.simplefilter("error")
                if language == "python":
                    return self._python(text)
                return (_file(text) if language == "toml" else _console(text)), []
        finally:
            logging.disable(logging.NOTSET)

    def _python(self, code: str) -> tuple[str, list[Figure]]:
        printed, figures = io.StringIO(), []

        def show() -> None:
            figures.extend(plt.figure(number) for number in plt.get_fignums())
            plt.close("all")

        before = {id(value) for value in self.names.values()}
        shown, plt.show = plt.show, show
        refused = code.rstrip().endswith(REFUSED)
        try:
            with contextlib.redirect_stdout(printed):
                exec(compile(code, "<block>", "exec", dont_inherit=True), self.names)
            if refused:
                raise AssertionError(f"nothing was refused in\n{code}")
        except FrictionloopError as error:
            if not refused:
                raise
            printed.write(f"FrictionloopError: {error}\n")
        finally:
            plt.show = shown
        figures += [each for each in self._drawn() if id(each) not in before and each not in figures]
        return printed.getvalue(), figures

    def _drawn(self) -> list[Figure]:
        """Return the figures that have names, but those of pyplot, which `plt.show` shows."""
        found = (value for value in self.names.values() if isinstance(value, Figure))
        return [each for each in found if not hasattr(each, "number")]


def _file(text: str) -> str:
    name = text.splitlines()[0].removeprefix("# ")
    if name.endswith(".toml") and "/" not in name:
        Path(name).write_text(text, encoding="utf-8")
    return ""


def _console(text: str) -> str:
    """Return the block with the output of each ``$ frictionloop`` command after it."""
    lines: list[str] = []
    started = ""
    for line in text.splitlines():
        lines.append(line)
        if line.startswith("$ frictionloop ") or started:
            started += line.removeprefix("$ frictionloop ").removesuffix("\\")
            if not line.endswith("\\"):
                words, _, pipe = started.partition(" | ")
                lines += [*_piped(command(words).splitlines(), pipe), ""]
                started = ""
    return "\n".join(lines).rstrip() + "\n"


def _piped(lines: list[str], pipe: str) -> list[str]:
    if not pipe:
        return lines
    program, option, count = pipe.split()
    assert program in ("head", "tail")
    assert option == "-n"
    return lines[: int(count)] if program == "head" else lines[-int(count) :]


def command(words: str, width: int = 80, ends: int = 0) -> str:
    """Return what ``frictionloop`` prints when called with these words; another exit code is an error here.

    That something does not hold is an answer.
    """
    from frictionloop.cli import main
    from frictionloop.cli.screen import DOES_NOT_HOLD

    screen, columns = io.StringIO(), os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(width)
    try:
        with contextlib.redirect_stdout(screen), contextlib.redirect_stderr(screen):
            main(shlex.split(words, comments=True))
    except SystemExit as end:
        if (end.code or 0) not in (ends, DOES_NOT_HOLD):
            raise RuntimeError(f"frictionloop {words}: exit code {end.code}\n{screen.getvalue()}") from None
    finally:
        os.environ.pop("COLUMNS")
        os.environ.update({"COLUMNS": columns} if columns else {})
    # A page does not show how far long work was after some seconds: that is of the machine that built it.
    lines = [line.rstrip() for line in screen.getvalue().splitlines() if not line.endswith(" s so far")]
    return "\n".join(lines).strip("\n") + "\n"
