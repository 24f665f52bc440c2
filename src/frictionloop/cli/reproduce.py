"""``frictionloop reproduce``: the paper's figures and claims on one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import checks, flags, screen

ARGUMENTS = "[OPTIONS]"
EXAMPLES = (
    "",
    "--out my-report --json",
    "--only fig-5a,closed-loop-r2",
    "--only fig-5a --sensor.resonance_hz 200",
)

Changed = Annotated[
    list[str] | None,
    Parameter(
        name=flags.DOTTED,
        metavar="VALUE",
        help="Another bench, or PI gains, for --only fig-5a.",
        group=flags.RESULT,
    ),
]


def command(
    *,
    out: flags.Result[Path] = Path("report"),
    only: Annotated[flags.Result[str | None], Parameter(metavar="NAME,...")] = None,
    overrides: Changed = None,
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
    checks.check_drawing()
    names = [name.strip() for name in only.split(",")] if only else []
    shown.show(fl.reproduce(out, names, flags.overrides_of(overrides)))
