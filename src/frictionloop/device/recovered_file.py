"""What a recording holds whose process was killed, written as a finished file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row
from frictionloop.loop.growing_file import recovered
from frictionloop.loop.record import load
from frictionloop.quantities import FrictionloopError, must_be

PARTIAL = ".partial-"
SPACING_S = 100.0
"""The first part of a file, that tells the time between two samples: at least two at any decimation."""


class Recovered(Result, schema="device.recover/1"):
    """What an unfinished recording held."""

    samples: int
    duration_s: float
    lost_samples: int
    """Before they were recorded."""
    damaged_samples: int
    """Empty in the finished file."""
    source: str
    path: str

    def rows(self) -> list[Row]:
        """Return how much there is."""
        return [("holds", f"{self.samples:,} samples, {self.duration_s:.6g} s, {self.source}"), ("file", self.path)]


def recover(file: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> Recovered:
    """Write what an unfinished recording holds as a finished file; the unfinished one stays as it is.

    Parameters
    ----------
    file
        What the recording left, with .partial- in its name.
    out
        Finished file (.h5); None: the name that the recording was to have, which must be free.

    Raises
    ------
    FrictionloopError
        For a file that is no unfinished recording, is still recorded, or names no other.
    """
    path = _out(Path(file), None if out is None else Path(out))
    rows, damaged = recovered(file, path)
    first = load(path, until_s=SPACING_S)
    spacing_s = float(first["time"][1] - first["time"][0]) if first.sizes["time"] > 1 else 0.0
    lost = int(first.attrs.get("lost_samples", 0))
    return Recovered(
        samples=rows,
        duration_s=rows * spacing_s,
        lost_samples=lost,
        damaged_samples=damaged,
        source=str(first.attrs.get("source", "")),
        path=str(path),
        findings=tuple(_findings(rows, lost, damaged)),
    )


def _findings(rows: int, lost: int, damaged: int) -> Iterator[Finding]:
    for count, how in ((lost, "lost before they were recorded"), (damaged, "damaged, empty now")):
        if count:
            yield Finding("SAMPLES-LOST", value=count, limit=rows, more={"how": how})


def _out(file: Path, out: Path | None) -> Path:
    if not file.is_file():
        raise FrictionloopError(f"{file}: cannot be read (no such file)")
    if out is None:
        if PARTIAL not in file.name:
            raise must_be("file", str(file), f"named NAME{PARTIAL}..., or --out given")
        out = file.with_name(f"{file.name.partition(PARTIAL)[0]}.h5")
        if out.exists():
            raise must_be("--out", str(out), "a new file")
    if out.exists() and out.samefile(file):
        raise must_be("--out", str(out), "another file than the one to recover")
    return out
