"""A System as the parameter table of the microcontroller, and as the image that runs it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from frictionloop.analysis.stability import rings_if_linear
from frictionloop.control.cost import BEYOND, CYCLES, highest_hz, worst_tick
from frictionloop.control.laws import law_of
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row
from frictionloop.firmware import image
from frictionloop.firmware.board_fit import amplitude_left, board_findings, carrier_hz, ceiling_findings, period_ticks
from frictionloop.firmware.board_law import board_law
from frictionloop.firmware.compiled_core import tick_hz
from frictionloop.firmware.emulated_core import Counted, counted
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.words import fingerprint, write_table
from frictionloop.parameters import ResonantPlate, System
from frictionloop.parameters.summary import gains_said
from frictionloop.quantities import must_be
from frictionloop.quantities.extra import all_needed
from frictionloop.quantities.schema import table_hash


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
    rate_hz: float
    tick_instructions: int | None
    """Of the worst tick, on a reference image with two force axes or on the image built; None if not counted."""
    highest_hz: float | None
    """Rate that `control.cost.CYCLES` for each of these allow."""
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
        if self.tick_instructions and self.highest_hz:
            up_to = f"up to {self.highest_hz:,.0f} Hz at {CYCLES} cycles each"
            rows.append(("tick", f"{self._counted} instructions, {up_to}"))
        return [*rows, ("values", f"{self.values}, {self.words} words, layout {self.layout}")]

    @property
    def _counted(self) -> str:
        return f"{self.tick_instructions:,}"


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
    loop = rings_if_linear(system)
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
        "rate_hz": controller.rate_hz,
        **_cost(worst_tick(controller.kind)),
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


def _cost(instructions: int | None) -> dict[str, Any]:
    return {"tick_instructions": instructions, "highest_hz": highest_hz(instructions) if instructions else None}


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
    law_instructions: int | None = None
    """Of the worst tick's for law, inverse and overdrive; None if not counted."""

    def rows(self) -> list[Row]:
        """Return the image, and what the table has beside the delay."""
        sizes = f"flash {self.flash_bytes:,}, memory {self.ram_bytes:,} bytes"
        return [(Path(self.hex).name, sizes), *(row for row in super().rows() if row[0] != "delay")]

    @property
    def _counted(self) -> str:
        law = f" (law {self.law_instructions:,})" if self.law_instructions else ""
        return super()._counted + law


def build(system: System, out: str | os.PathLike[str], board: str = image.FLASHED) -> Built:
    """Build the image that runs a System's controller, with its table beside it; the first time takes half a minute.

    The law is translated from its step, one from outside (`fl.register`) like a built-in one. Beside it the image has the
    lookup: state open, and the law of a table of kind lookup.

    Parameters
    ----------
    system
        The bench with its controller.
    out
        Folder for the files; made if it is missing.
    board
        teensy41, or mps2 or mps2-scenario for qemu-system-arm.

    Raises
    ------
    FrictionloopError
        NO-C for a law with something that has no C; for what the firmware cannot do, an unknown board, sources that do
        not compile, and a rate far beyond what the counted instructions allow.
    """
    all_needed("ziglang", "elftools", "cobs", "fastcrc", "intelhex")
    words, folder, rate_hz = firmware_words(system), Path(out), tick_hz(system.controller.rate_hz)
    law = board_law(law_of(system.controller))
    made = image.build(board, words.tolist(), law, folder, rate_hz=rate_hz, carrier_ticks=period_ticks(system))
    count = counted(made.elf, rate_hz) if find_spec("unicorn") else None
    write_table(system, words, folder)
    table = described_table(system, words, folder)
    if count is not None:
        table |= {**_cost(count.tick), "law_instructions": count.law}
        table["findings"] = (*table["findings"], *_late(count, rate_hz))
    table |= {"image": str(made.elf), "hex": str(made.hex), "map": str(made.map)}
    return Built(**table, board=board, flash_bytes=made.flash_bytes, ram_bytes=made.ram_bytes)


def _late(count: Counted, rate_hz: int) -> Iterator[Finding]:
    """Yield that ticks may be late at a rate; refuse one that no counter of a board could make right."""
    highest = highest_hz(count.tick)
    if rate_hz > BEYOND * highest:
        raise must_be("controller.rate_hz", rate_hz, f"at most {BEYOND * highest:.0f}", "Hz", "TICK-LATE")
    if rate_hz > highest:
        yield Finding("TICK-LATE", value=rate_hz, unit="Hz", limit=highest, more={"instructions": count.tick})
