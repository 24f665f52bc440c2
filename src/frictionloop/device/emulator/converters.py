"""The converters and the delay block that starts them."""

from __future__ import annotations

from frictionloop.device.emulator.bank import Bank
from frictionloop.quantities import FrictionloopError

CALIBRATE, DONE = 1 << 7, 1 << 7
INPUTS = {("ADC0", 8): 0, ("ADC1", 9): 1, ("ADC0", 12): 2, ("ADC1", 0): 3}
"""What the bench connects to which channel: force along and across the motion, load, position (docs: wiring)."""
HALF = 32768
PDB_ON, PDB_TIMER_0 = 1 << 7 | 1 << 0, 4
"""PDBEN, and LDOK that takes modulus and delays over; TRGSEL: the timer PIT0."""


class Converters:
    """ADC0, ADC1 and PDB: a conversion gives what the bench has at the input it is set to."""

    def __init__(self, bank: Bank) -> None:
        self._bank = bank
        for adc in ("ADC0", "ADC1"):
            bank.on_write[f"{adc}_SC3"] = lambda value, adc=adc: self._calibrated(adc, value)  # type: ignore[misc]

    def _calibrated(self, adc: str, value: int) -> None:
        if value & CALIBRATE:
            hertz = self._bank.values[f"{adc}_CFG1"]
            if hertz & 0x60 != 0x60:  # ADIV by 8: 36 MHz / 2 / 8 is below the 4 MHz that calibrating takes
                raise FrictionloopError(f"{adc}: calibrated above 4 MHz", "BAD-IMAGE")
            self._bank.values[f"{adc}_SC3"] = value & ~CALIBRATE

    def convert(self, counts: tuple[int, int, int, int]) -> None:
        """Convert force along and across, load, position (0 counts in the middle), if the delay block starts it."""
        values = self._bank.values
        if values["PDB_SC"] & PDB_ON != PDB_ON or values["PDB_SC"] >> 8 & 15 != PDB_TIMER_0:
            return
        for channel, adc in enumerate(("ADC0", "ADC1")):
            started = values[f"PDB_CH{channel}C1"]
            if not values[f"PDB_CH{channel}DLY0"] <= values["PDB_MOD"] <= values["PIT_LDVAL0"]:
                raise FrictionloopError(f"PDB_CH{channel}DLY0, PDB_MOD: {adc} not done in a tick", "BAD-IMAGE")
            for pretrigger, (control, result) in enumerate((("SC1A", "RA"), ("SC1B", "RB"))):
                if started >> pretrigger & 1:
                    source = INPUTS.get((adc, values[f"{adc}_{control}"] & 0x3F))
                    if source is None:
                        raise FrictionloopError(f"{adc}_{control} = {values[f'{adc}_{control}']:#x}: nothing connected")
                    values[f"{adc}_{result}"] = counts[source] + HALF
