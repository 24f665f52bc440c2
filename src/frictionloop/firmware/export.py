"""The parameter table of a System as files: words for the device, and numbers with units for a person."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.control.cost import BUDGET_CYCLES, worst_tick
from frictionloop.firmware.words import from_words
from frictionloop.parameters import System, write_toml
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.quantities.schema import parameter_words, table_hash

HEADING = ("word", "name", "value", "unit", "raw", "meaning")


@dataclass(frozen=True)
class Table:
    """A System and its words, int32, in the order of protocol/frictionloop.toml."""

    system: System
    words: np.ndarray

    def rows(self) -> Iterator[tuple[Any, ...]]:
        """Yield every number: first word, name, value in its unit, unit, raw words, meaning."""
        for word in parameter_words().values():
            each = word.words // word.count
            value = np.atleast_1d(from_words(word, self.words[word.first : word.first + word.words]))
            for k in range(word.count):
                first = word.first + k * each
                raw = self.words[first : first + each].tolist()
                name = f"{word.name}[{k}]" if word.count > 1 else word.name
                yield first, name, value[k], word.unit, " ".join(map(str, raw)), word.text

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
            "table_hash": table_hash(),
        }

    def write(self, folder: Path) -> None:
        """Write parameters.bin (little-endian int32), parameters.csv and system.toml into a folder.

        Raises
        ------
        FrictionloopError
            For a folder that cannot be made or written.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(HEADING)
        writer.writerows(self.rows())
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise FrictionloopError(f"out = {str(folder)!r}: cannot be made ({error.strerror})") from None
        with replacing(folder / "parameters.bin") as fresh:
            fresh.write_bytes(self.words.astype("<i4").tobytes())
        with replacing(folder / "parameters.csv") as fresh:
            fresh.write_text(text.getvalue(), encoding="utf-8")
        write_toml(self.system, folder / "system.toml")
