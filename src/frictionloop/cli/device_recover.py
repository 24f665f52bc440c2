"""``frictionloop device recover``: what a recording holds whose process was killed, written as a finished file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen

ARGUMENTS = "FILE [--out FILE] [OPTIONS]"
EXAMPLES = (
    "run.partial-1a2b3c4d.h5",
    "run.partial-1a2b3c4d.h5 --out mended.h5",
)


def command(
    file: Annotated[flags.Described[Path], Parameter(name="FILE")],
    /,
    *,
    out: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Write what an unfinished recording holds as a finished file, and say what that is; FILE stays as it is.

    Parameters
    ----------
    file
        The file that the recording left, with .partial- in its name.
    out
        Save it here (.h5); by default under the name that the recording was to have, if that is free.
    """
    file_arguments.check_output("out", out, file_arguments.RUN_FILES)
    with fl.progress.waiting("reading"):
        found = fl.device.recover(file, out)
    shown.show(found)
