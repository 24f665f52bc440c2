"""A System as the parameter table of the microcontroller, and as the image that runs it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from frictionloop.analysis.stability import rings_if_linear
from frictionloop.control.cost import BUDGET_CYCLES, LATE_CYCLES, worst_tick
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row
from frictionloop.firmware import image
from frictionloop.firmware.board_fit import amplitude_left, board_findings, carrier_hz, ceiling_findings, period_ticks
from frictionloop.firmware.image_files import FLASH_BYTES, RAM_BYTES
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.words import fingerprint, write_table
from frictionloop.parameters import ResonantPlate, System
from frictionloop.parameters.summary import gains_said
from frictionloop.quantities.extra import all_needed
from frictionloop.quantities.schema import table_hash

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]


@dataclass(frozen=True, kw_only=True)
class Exported(Result):
    """The parameter table of a System, written into a folder."""

    SCHEMA: ClassVar[str] = "firmware.export/1"
    system: System
    law: str
    clamp_n: tuple[float, float]
    ceiling_um: float
    """Largest amplitude that the board ever commands."""
    carrier_hz: float | None
    """Of the image; None of a plate without a resonance."""
    carrier_share: float | None
    """Amplitude of the plate at the carrier, over that at its resonance."""
    delay_us: float
    """From sample to amplitude."""
    whole_delay_us: float
    """With half the hold."""
    worst_tick_cycles: int | None
    """Of the law's worst tick on a reference image with two force axes, or of the image built; None if not traced."""
    tick_cycles: int
    stable: bool | None
    """Whether the linear loop is, at the forces asked for, dry and moist; None where that is not known."""
    words: int
    layout: str
    values: str
    """Fingerprint."""
    folder: str
    """Folder of the files."""

    def rows(self) -> list[Row]:
        """Return the law, what limits it, what it costs, and the fingerprint."""
        low, high = self.clamp_n
        rows = [
            (self.law, gains_said(self.system)),
            ("clamp", f"{low:.4g} to {high:.4g} N, at most {self.ceiling_um:g} um"),
            ("delay", f"{self.delay_us:g} us, {self.whole_delay_us:.4g} us with half the hold"),
        ]
        if self.carrier_hz is not None:
            rows.append(
                ("carrier", f"{self.carrier_hz:.0f} Hz, {100.0 * (self.carrier_share or 0.0):.3g} % of the resonance")
            )
        if self.worst_tick_cycles:
            rows.append(("tick", f"{self.worst_tick_cycles:,} of {self.tick_cycles:,} cycles{self._traced}"))
        return [*rows, ("values", f"{self.values}, {self.words} words, layout {self.layout}")]

    @property
    def _traced(self) -> str:
        return ", reference image"


def export(system: System, out: str | os.PathLike[str]) -> Exported:
    """Write the parameter table of a System into a folder, which is made if it is missing.

    parameters.bin has the words, parameters.csv the numbers with units, values.txt their fingerprint, system.toml the
    System.

    Raises
    ------
    FrictionloopError
        For what the firmware cannot do, and a folder that cannot be written.
    """
    words, folder = firmware_words(system), Path(out)
    write_table(system, words, folder)
    return Exported(**described_table(system, words, folder))


def described_table(system: System, words: np.ndarray, folder: Path) -> dict[str, Any]:
    """Return the fields of `Exported`."""
    controller, plate = system.controller, system.plate
    worst, loop = worst_tick(controller.kind), rings_if_linear(system)
    resonant = isinstance(plate, ResonantPlate)
    at_hz = carrier_hz(system) if resonant else None
    own_um = system.board.ceiling_um
    return {
        "system": system,
        "law": controller.kind,
        "clamp_n": (controller.model.floor_n, controller.model.nominal_n),
        "ceiling_um": plate.max_amplitude_um if own_um is None else own_um,
        "carrier_hz": at_hz,
        "carrier_share": amplitude_left(plate, at_hz) if isinstance(plate, ResonantPlate) and at_hz else None,
        "delay_us": 1e6 * controller.delay_s,
        "whole_delay_us": 1e6 * (controller.delay_s + 0.5 / controller.rate_hz),
        "worst_tick_cycles": worst.cycles if worst else None,
        "tick_cycles": BUDGET_CYCLES,
        "stable": loop and loop.stable,
        "words": len(words),
        "layout": f"{table_hash():08x}",
        "values": fingerprint(words),
        "folder": str(folder),
        "findings": tuple(_findings(system, loop.finding if loop else None)),
    }


def _findings(system: System, rings: Finding | None) -> Iterator[Finding]:
    if rings is not None:
        yield rings
    yield from board_findings(system)
    yield from ceiling_findings(system)


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
