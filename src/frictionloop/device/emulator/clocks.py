"""Clocks: what the generator's registers say, and the frequencies that come of them."""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.device.emulator.bank import Bank
from frictionloop.quantities import must_be

CRYSTAL_HZ = 16_000_000
INTERNAL_HZ = 20_971_520
"""Of the FLL after reset: 32.768 kHz times 640."""
HIGHEST_HZ = {"core": 72_000_000, "bus": 50_000_000, "flash": 25_000_000}
"""K20P64M72SF1 data sheet, device clock specifications."""
FLL, INTERNAL, EXTERNAL, PLL = range(4)
"""Source of the clock as MCG_S.CLKST has it."""


class Frequencies(NamedTuple):
    """Hz."""

    core: float
    bus: float
    flash: float


class Clocks:
    """Multipurpose clock generator (K20P64M72SF1RM): modes follow at once, a wrong order shows in the status."""

    def __init__(self, bank: Bank) -> None:
        self._values = bank.values
        bank.on_read["MCG_S"] = self._status
        bank.on_write["MCG_C1"] = bank.on_write["SIM_CLKDIV1"] = lambda _: self._refuse_too_fast()

    def _status(self) -> int:
        crystal = self._crystal()
        pll = crystal and self._values["MCG_C6"] >> 6 & 1
        internal = self._values["MCG_C1"] >> 2 & 1
        return crystal << 1 | self._source() << 2 | internal << 4 | pll << 5 | pll << 6

    def _crystal(self) -> int:
        """1 when the oscillator runs: EREFS, and a range for 16 MHz."""
        range_and_source = self._values["MCG_C2"] & 0x34
        return int(range_and_source in {0x14, 0x24, 0x34})

    def _source(self) -> int:
        wanted = self._values["MCG_C1"] >> 6
        if wanted == 2 and self._crystal():
            return EXTERNAL
        if wanted == 0 and self._values["MCG_C6"] >> 6 & 1 and self._crystal():
            return PLL
        return INTERNAL if wanted == 1 else FLL

    def frequencies(self) -> Frequencies:
        """Return the frequencies of core, bus and flash now.

        Raises
        ------
        FrictionloopError
            When the PLL is fed with what it does not take.
        """
        source = {FLL: INTERNAL_HZ, INTERNAL: 32_768.0, EXTERNAL: CRYSTAL_HZ}.get(self._source(), 0.0) or self._pll()
        dividers = self._values["SIM_CLKDIV1"]
        return Frequencies(*(source / ((dividers >> shift & 15) + 1) for shift in (28, 24, 16)))

    def _pll(self) -> float:
        reference = CRYSTAL_HZ / ((self._values["MCG_C5"] & 31) + 1)
        if not 2e6 <= reference <= 4e6:
            raise must_be("MCG_C5: PLL input", reference / 1e6, "2 to 4", "MHz", "BAD-IMAGE")
        return reference * ((self._values["MCG_C6"] & 31) + 24)

    def _refuse_too_fast(self) -> None:
        for name, hz in self.frequencies()._asdict().items():
            if hz > HIGHEST_HZ[name]:
                raise must_be(name, hz / 1e6, f"at most {HIGHEST_HZ[name] / 1e6:g}", "MHz", "BAD-IMAGE")
