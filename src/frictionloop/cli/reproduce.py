"""``frictionloop reproduce``: the paper's figures and claims on one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb


@verb("reproduce [OPTIONS]", "", "--out my-report --json", "--only fig-5a,closed-loop-r2")
def command(
    *,
    out: flags.Result[Path] = Path("report"),
    only: Annotated[flags.Result[str | None], Parameter(metavar="NAME,...")] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Rebuild the paper's figures and check its numbers.

    Parameters
    ----------
    out
        Folder for the page and the claims.
    only
        Make these figures and claims alone, with their numbers, and no page: fig-5a,closed-loop-r2. The page names
        each.
    """
    file_arguments.check_drawing()
    names = [name.strip() for name in only.split(",")] if only else []
    shown.show(fl.reproduce(out, names))
