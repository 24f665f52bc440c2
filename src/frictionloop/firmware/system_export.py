"""A System as the parameter table of the microcontroller, and as the image that runs it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.analysis.stability import rings_if_linear
from frictionloop.control.instruction_cost import BEYOND, highest_rate_hz, worst_tick
from frictionloop.control.laws import law_of
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row
from frictionloop.firmware import image
from frictionloop.firmware.board_compatibility import (
    amplitude_left,
    board_findings,
    carrier_hz,
    ceiling_findings,
    converter_findings,
    period_ticks,
)
from frictionloop.firmware.compiled_core import tick_hz
from frictionloop.firmware.image_files import FLASH_BYTES, RAM_BYTES
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_files import fingerprint, write_table
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.parameters import ResonantPlate, System
from frictionloop.parameters.summary import gains_said
from frictionloop.quantities import must_be
from frictionloop.quantities.optional_libraries import all_needed
from frictionloop.quantities.protocol_schema import table_hash

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]


class Exported(Result, schema="firmware.export/1"):
    """The parameter table of a System, written into a folder."""

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
    worst_tick_instructions: int | None
    """Of the law's worst tick on a reference image with two force axes, or of the image built; None if not counted."""
    highest_rate_hz: float | None
    """Of ticks that take so many, at 20 cycles each."""
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
        if self.worst_tick_instructions:
            highest = f"up to {1e-3 * (self.highest_rate_hz or 0.0):.3g} kHz at 20 cycles each"
            rows.append(("tick", f"{self.worst_tick_instructions:,} instructions, {highest}{self._counted}"))
        return [*rows, ("values", f"{self.values}, {self.words} words, layout {self.layout}")]

    @property
    def _counted(self) -> str:
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
        "worst_tick_instructions": worst,
        "highest_rate_hz": highest_rate_hz(worst) if worst else None,
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


Counts = Mapping[str, int]
"""Instructions of a tick period by what they go to."""


class Built(Exported, schema="firmware.build/1"):
    """An image and the table that it begins with."""

    board: str
    image: str
    """ELF file, for emulators and debuggers."""
    hex: str
    """Intel hex, to be flashed."""
    map: str
    flash_bytes: int
    ram_bytes: int
    instructions: Counts | None = None
    """Of this image: tick, law, tick with the longest effect, interrupts of a full line, background."""

    def rows(self) -> list[Row]:
        """Return the image, and what the table has beside the delay."""
        flash, ram = (
            ("", "") if not self.board.startswith(image.FLASHED) else (f" of {FLASH_BYTES:,}", f" of {RAM_BYTES:,}")
        )
        sizes = f"flash {self.flash_bytes:,}{flash}, memory {self.ram_bytes:,}{ram} bytes"
        return [(Path(self.hex).name, sizes), *(row for row in super().rows() if row[0] != "delay")]

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the instructions of a tick period."""
        if self.instructions is None:
            return {}
        import pandas as pd

        return {"instructions": pd.DataFrame([dict(self.instructions)], index=["at most"])}

    @property
    def _counted(self) -> str:
        return "" if self.instructions else super()._counted


def build(
    system: System,
    out: str | os.PathLike[str],
    board: str = image.FLASHED,
    trace: Callable[[str], Counts | None] | None = None,
) -> Built:
    """Build the image that runs a System's controller, with its table beside it; the first time takes half a minute.

    The law is translated from its step, one from outside (`fl.register`) like a built-in one. Beside it the image has
    the lookup: state open, and the law of a table of kind lookup.

    Parameters
    ----------
    system
        The bench with its controller.
    out
        Folder for the files; made if it is missing.
    board
        teensy41, or teensy41-ads8688 with that converter; mps2 or mps2-scenario for qemu-system-arm.
    trace
        What counts the instructions of an image to be flashed, such as ``fl.device.instructions``.

    Raises
    ------
    FrictionloopError
        NO-C for a law with something that has no C; for what the firmware cannot do, an unknown board, sources that do
        not compile, and a rate above four times that of 20 cycles an instruction.
    """
    all_needed("ziglang", "elftools", "cobs", "fastcrc", "intelhex")
    words, folder, law = firmware_words(system), Path(out), board_law(law_of(system.controller))
    rate_hz = tick_hz(system.controller.rate_hz)
    made = image.build(board, words.tolist(), law, folder, rate_hz=rate_hz, carrier_ticks=period_ticks(system))
    counts = trace(str(made.elf)) if trace is not None and board.startswith(image.FLASHED) else None
    write_table(system, words, folder)
    table = described_table(system, words, folder)
    if counts:
        most = max(counts["tick"], counts["effect"])
        table |= {"worst_tick_instructions": most, "highest_rate_hz": highest_rate_hz(most)}
        table["findings"] = (*table["findings"], *_late(system.controller.rate_hz, most))
    if board == image.FLASHED:
        table["findings"] = (*table["findings"], *converter_findings(system))
    table |= {"image": str(made.elf), "hex": str(made.hex), "map": str(made.map)}
    return Built(**table, board=board, flash_bytes=made.flash_bytes, ram_bytes=made.ram_bytes, instructions=counts)


def _late(rate_hz: float, instructions: int) -> Iterator[Finding]:
    """Yield that ticks of so many instructions may be late at a rate; refuse where they will be."""
    highest_hz = highest_rate_hz(instructions)
    if rate_hz > BEYOND * highest_hz:
        raise must_be("controller.rate_hz", rate_hz, f"at most {BEYOND * highest_hz:.0f}", "Hz", "TICK-LATE")
    if rate_hz > highest_hz:
        yield Finding("TICK-LATE", value=rate_hz, unit="Hz", limit=highest_hz, more={"instructions": instructions})
