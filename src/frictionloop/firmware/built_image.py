"""The image that runs a System's controller, with its parameter table beside it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from frictionloop.control.cost import BUDGET_CYCLES, LATE_CYCLES
from frictionloop.findings import Finding
from frictionloop.findings.result import Row
from frictionloop.firmware import image
from frictionloop.firmware.board_fit import period_ticks
from frictionloop.firmware.exported import Exported, described_table
from frictionloop.firmware.image_checks import FLASH_BYTES, RAM_BYTES
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.table_files import write_table
from frictionloop.parameters import System
from frictionloop.quantities.extra import all_needed

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]

Cycles = Mapping[str, Mapping[str, int]]
"""What the cycles of a tick period go to, by what is assumed of the waits."""
PARTS = ["tick", "interrupts", "background", "sum"]


@dataclass(frozen=True, kw_only=True)
class Built(Exported):
    """An image and the table that it begins with."""

    SCHEMA: ClassVar[str] = "firmware.build/1"
    board: str
    image: str
    """ELF file, for emulators and debuggers."""
    hex: str
    """Intel hex, to be flashed."""
    map: str
    flash_bytes: int
    ram_bytes: int
    cycles: Cycles | None = None
    """Of this image: tick, interrupts, background, their sum; with the longest effect, and a host that never stops."""

    def rows(self) -> list[Row]:
        """Return the image, and what the table has beside the delay."""
        flash, ram = ("", "") if self.board != image.FLASHED else (f" of {FLASH_BYTES:,}", f" of {RAM_BYTES:,}")
        sizes = f"flash {self.flash_bytes:,}{flash}, memory {self.ram_bytes:,}{ram} bytes"
        return [(Path(self.hex).name, sizes), *(row for row in super().rows() if row[0] != "delay")]

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the cycles of a tick, and what more was traced."""
        if self.cycles is None:
            return {}
        import pandas as pd

        whole = pd.DataFrame(dict(self.cycles)).T.rename_axis(f"cycles of {BUDGET_CYCLES:,}")
        return {"cycles": whole[PARTS], "more cycles": whole.drop(columns=PARTS)}

    @property
    def _traced(self) -> str:
        return ", this image" if self.cycles else super()._traced


def build(
    system: System,
    out: str | os.PathLike[str],
    board: str = image.FLASHED,
    laws: Sequence[str] | None = None,
    trace: Callable[[str], Cycles | None] | None = None,
) -> Built:
    """Build the image that runs a System's controller, with its table beside it; the first time takes half a minute.

    Parameters
    ----------
    system
        The bench with its controller.
    out
        Folder for the files; made if it is missing.
    board
        teensy31, or mps2 or mps2-scenario for qemu-system-arm.
    laws
        Kinds of controller to build in; None: all.
    trace
        What traces the cycles of an image to be flashed, such as ``fl.device.cycles``.

    Raises
    ------
    FrictionloopError
        For what the firmware cannot do, an unknown board or law, and sources that do not compile.
    """
    all_needed("ziglang", "elftools", "cobs", "fastcrc", "intelhex")
    words, folder = firmware_words(system), Path(out)
    made = image.build(board, words.tolist(), folder, laws=laws, carrier_ticks=period_ticks(system))
    cycles = trace(str(made.elf)) if trace is not None and board == image.FLASHED else None
    write_table(system, words, folder)
    table = described_table(system, words, folder)
    if cycles:
        table["worst_tick_cycles"] = next(iter(cycles.values()))["tick"]
        table["findings"] = (*table["findings"], *_late(cycles))
    table |= {"image": str(made.elf), "hex": str(made.hex), "map": str(made.map)}
    return Built(**table, board=board, flash_bytes=made.flash_bytes, ram_bytes=made.ram_bytes, cycles=cycles)


def _late(cycles: Cycles) -> Iterator[Finding]:
    """Yield that tick and interrupts exceed a period, and that an interrupt of the port makes ticks late."""
    name, worst = max(cycles.items(), key=lambda item: item[1]["tick"] + item[1]["interrupts"])
    alone, longest = worst["tick"] + worst["interrupts"], next(iter(cycles.values()))["longest_interrupt"]
    if alone > BUDGET_CYCLES:
        yield Finding("TICK-LATE", value=alone, limit=BUDGET_CYCLES, more={"waits": f"tick and interrupts, {name}"})
    if longest > LATE_CYCLES:
        yield Finding("TICK-LATE", value=longest, limit=LATE_CYCLES, more={"waits": "an interrupt of the port"})
