"""The parameter table of a System as files: words for the device, and numbers with units for a person."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.control.cost import BUDGET_CYCLES, worst_tick
from frictionloop.firmware.values import Number, fingerprint, numbers
from frictionloop.parameters import System, write_toml
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.quantities.schema import table_hash

FINGERPRINT = "values.txt"
"""File with the fingerprint of the values, as `device info` prints it."""


@dataclass(frozen=True)
class Table:
    """A System and its words, int32, in the order of protocol/frictionloop.toml."""

    system: System
    words: np.ndarray

    def summary(self) -> dict[str, Any]:
        """Return what one wants to know first, by name; the cycles are those of the law's worst tick, None untraced."""
        controller, model = self.system.controller, self.system.controller.model
        worst = worst_tick(controller.kind)
        return {
            "law": controller.kind,
            "clamp_n": (model.floor_n, model.nominal_n),
            "worst_tick_cycles": worst.cycles if worst else None,
            "tick_cycles": BUDGET_CYCLES,
            "words": len(self.words),
            "layout": f"{table_hash():08x}",
            "values": fingerprint(self.words),
        }

    def write(self, folder: Path) -> None:
        """Write parameters.bin (little-endian int32), parameters.csv, values.txt and system.toml into a folder.

        Raises
        ------
        FrictionloopError
            For a folder that cannot be made or written.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(Number._fields)
        writer.writerows(numbers(self.words))
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise FrictionloopError(f"out = {str(folder)!r}: cannot be made ({error.strerror})") from None
        with replacing(folder / "parameters.bin") as fresh:
            fresh.write_bytes(self.words.astype("<i4").tobytes())
        with replacing(folder / "parameters.csv") as fresh:
            fresh.write_text(text.getvalue(), encoding="utf-8")
        with replacing(folder / FINGERPRINT) as fresh:
            fresh.write_text(f"values {fingerprint(self.words)}\n", encoding="ascii")
        write_toml(self.system, folder / "system.toml")
