"""The parameter table of a System as files: words for the device, and numbers with units for a person."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from frictionloop.firmware.values import Number, fingerprint, numbers
from frictionloop.parameters import System, write_toml
from frictionloop.quantities import must_be, replacing

FINGERPRINT = "values.txt"
"""File with the fingerprint of the values, as `device info` prints it."""


def write_table(system: System, words: np.ndarray, folder: Path) -> None:
    """Write parameters.bin (little-endian int32), parameters.csv, values.txt and system.toml into a folder.

    Raises
    ------
    FrictionloopError
        For a folder that cannot be made or written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Number._fields)
    writer.writerows(numbers(words))
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise must_be("out", str(folder), f"a folder ({error.strerror})") from None
    with replacing(folder / "parameters.bin") as fresh:
        fresh.write_bytes(words.astype("<i4").tobytes())
    with replacing(folder / "parameters.csv") as fresh:
        fresh.write_text(text.getvalue(), encoding="utf-8")
    with replacing(folder / FINGERPRINT) as fresh:
        fresh.write_text(f"values {fingerprint(words)}\n", encoding="ascii")
    write_toml(system, folder / "system.toml")
