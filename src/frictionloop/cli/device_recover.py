"""``frictionloop device recover``: what a recording holds whose process was killed, written as a finished file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.quantities.units import FrictionloopError

ARGUMENTS = "FILE [--out FILE] [--json]"
EXAMPLES = """Examples

  frictionloop device recover run.partial-1a2b3c4d.h5
  frictionloop device recover run.partial-1a2b3c4d.h5 --out mended.h5
"""
PARTIAL = ".partial-"
SPACING_S = 100.0
"""The first part of a file, that tells the time between two samples: at least two at any decimation."""


def command(
    file: Annotated[flags.Described[Path], Parameter(name="FILE")],
    /,
    *,
    out: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Write what an unfinished recording holds as a finished file, and say what that is; FILE stays as it is.

    Parameters
    ----------
    file
        The file that the recording left, with .partial- in its name.
    out
        Save it here (.h5); by default under the name that the recording was to have, if that is free.
    """
    out = _out(file, out)
    from frictionloop.loop.record import load
    from frictionloop.loop.unfinished import recovered

    with screen.waiting("reading"):
        rows, damaged = recovered(file, out)
    first = load(out, until_s=SPACING_S)
    spacing_s = float(first["time"][1] - first["time"][0]) if first.sizes["time"] > 1 else 0.0
    lost, source = int(first.attrs.get("lost_samples", 0)), str(first.attrs.get("source", "not told"))
    if json:
        numbers = {"samples": rows, "seconds": rows * spacing_s, "lost_samples": lost, "damaged_samples": damaged}
        screen.show_json({**numbers, "source": source, "saved": out})
        return
    table = [
        ("holds", f"{rows:,} samples, {rows * spacing_s:.6g} s"),
        ("lost", f"{lost:,} samples before they were recorded" if lost else "nothing"),
        ("damaged", f"{damaged:,} samples, which are empty now" if damaged else "nothing"),
        ("source", source),
    ]
    screen.show(screen.columns(table), f"saved as {out}")


def _out(file: Path, out: Path | None) -> Path:
    if not file.is_file():
        raise FrictionloopError(f"{file}: cannot be read (no such file)")
    if out is None:
        if PARTIAL not in file.name:
            raise FrictionloopError(f"{file}: says no name to save it under; give --out FILE.h5")
        out = file.with_name(f"{file.name.partition(PARTIAL)[0]}.h5")
        checks.check_new("out", out)
    checks.check_output("out", out, checks.RUN_FILES)
    if out.exists() and file.exists() and out.samefile(file):
        raise FrictionloopError(f"out = {str(out)!r}: is the file to recover; choose another name")
    return out
