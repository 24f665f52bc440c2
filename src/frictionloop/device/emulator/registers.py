"""The registers of the MK20DX256 that the firmware may touch: name, address, width, value, and what an access does.

Written after the K20 Sub-Family Reference Manual, K20P64M72SF1RM, and compared with the vendor's SVD file by
firmware/boards/teensy31/check_registers.py. What is not in that file (DEMCR, DWT): the ARMv7-M Architecture Reference
Manual.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from frictionloop.quantities import FrictionloopError


class Register(NamedTuple):
    """A register: width in bytes, value after reset."""

    name: str
    address: int
    width: int
    reset: int = 0

    @property
    def block(self) -> str:
        """The peripheral that it belongs to."""
        return self.name.partition("_")[0]


def _block(prefix: str, base: int, width: int, names: dict[str, int], resets: dict[str, int]) -> list[Register]:
    return [Register(f"{prefix}_{name}", base + offset, width, resets.get(name, 0)) for name, offset in names.items()]


_ADC = {
    "SC1A": 0x00, "SC1B": 0x04, "CFG1": 0x08, "CFG2": 0x0C, "RA": 0x10, "RB": 0x14, "SC2": 0x20, "SC3": 0x24,
    "PG": 0x2C, "MG": 0x30, "CLPD": 0x34, "CLPS": 0x38, "CLP4": 0x3C, "CLP3": 0x40, "CLP2": 0x44, "CLP1": 0x48,
    "CLP0": 0x4C,
}  # fmt: skip
_ADC_RESET = {
    "SC1A": 0x1F, "SC1B": 0x1F, "PG": 0x8200, "MG": 0x8200, "CLPD": 0x0A, "CLPS": 0x20, "CLP4": 0x200, "CLP3": 0x100,
    "CLP2": 0x80, "CLP1": 0x40, "CLP0": 0x20,
}  # fmt: skip
_UART = {
    "BDH": 0x00, "BDL": 0x01, "C1": 0x02, "C2": 0x03, "S1": 0x04, "D": 0x07, "C4": 0x0A, "PFIFO": 0x10, "CFIFO": 0x11,
    "TWFIFO": 0x13, "TCFIFO": 0x14, "RWFIFO": 0x15, "RCFIFO": 0x16,
}  # fmt: skip
_PDB = {
    "SC": 0x00, "MOD": 0x04, "IDLY": 0x0C, "CH0C1": 0x10, "CH0S": 0x14, "CH0DLY0": 0x18, "CH1C1": 0x38, "CH1S": 0x3C,
    "CH1DLY0": 0x40,
}  # fmt: skip
_FTM = {"SC": 0x00, "CNT": 0x04, "MOD": 0x08, "C0SC": 0x0C, "C0V": 0x10, "CNTIN": 0x4C}
_PIT = {"MCR": 0x00, "LDVAL0": 0x100, "CVAL0": 0x104, "TCTRL0": 0x108, "TFLG0": 0x10C}
_SIM = {"SCGC3": 0x1030, "SCGC4": 0x1034, "SCGC5": 0x1038, "SCGC6": 0x103C, "CLKDIV1": 0x1044, "UIDL": 0x1060}
_WDOG = {"STCTRLH": 0x00, "TOVALH": 0x04, "TOVALL": 0x06, "REFRESH": 0x0C, "UNLOCK": 0x0E, "PRESC": 0x16}
_WDOG_RESET = {
    "STCTRLH": 0x01D3, "TOVALH": 0x4C, "TOVALL": 0x4B4C, "REFRESH": 0xB480, "UNLOCK": 0xD928, "PRESC": 0x0400,
}  # fmt: skip

REGISTERS = (
    *_block("SIM", 0x40047000, 4, _SIM, {"SCGC4": 0xF0100030, "SCGC5": 0x40182, "SCGC6": 0x40000001}),
    *_block("MCG", 0x40064000, 1, {"C1": 0, "C2": 1, "C5": 4, "C6": 5, "S": 6}, {"C1": 0x04, "C2": 0x80, "S": 0x10}),
    Register("OSC_CR", 0x40065000, 1),
    *_block("RCM", 0x4007F000, 1, {"SRS0": 0, "SRS1": 1}, {"SRS0": 0x82}),
    *_block("WDOG", 0x40052000, 2, _WDOG, _WDOG_RESET),
    *_block("ADC0", 0x4003B000, 4, _ADC, _ADC_RESET),
    *_block("ADC1", 0x400BB000, 4, _ADC, _ADC_RESET),
    *_block("PDB", 0x40036000, 4, _PDB, {"MOD": 0xFFFF, "IDLY": 0xFFFF}),
    *_block("FTM0", 0x40038000, 4, _FTM, {}),
    *_block("PIT", 0x40037000, 4, _PIT, {"MCR": 0x02}),
    *_block("UART0", 0x4006A000, 1, _UART, {"BDL": 0x04, "S1": 0xC0, "RWFIFO": 0x01}),
    Register("PORTB_PCR16", 0x4004A040, 4),
    Register("PORTB_PCR17", 0x4004A044, 4),
    Register("PORTC_PCR1", 0x4004B004, 4),
    Register("GPIOC_PCOR", 0x400FF088, 4),
    Register("GPIOC_PDDR", 0x400FF094, 4),
    *(Register(f"NVIC_ISER{word}", 0xE000E100 + 4 * word, 4) for word in range(4)),
    *(Register(f"NVIC_IPR{interrupt}", 0xE000E400 + interrupt, 1) for interrupt in range(95)),
    Register("DEMCR", 0xE000EDFC, 4),
    Register("DWT_CTRL", 0xE0001000, 4, 0x40000000),
    Register("DWT_CYCCNT", 0xE0001004, 4),
)
"""All of them. What is not here, the firmware may not touch."""
GATES = {
    "ADC1": ("SIM_SCGC3", 27), "UART0": ("SIM_SCGC4", 10), "PORTB": ("SIM_SCGC5", 10), "PORTC": ("SIM_SCGC5", 11),
    "PDB": ("SIM_SCGC6", 22), "PIT": ("SIM_SCGC6", 23), "FTM0": ("SIM_SCGC6", 24), "ADC0": ("SIM_SCGC6", 27),
}  # fmt: skip
"""Register and bit of a block's clock, off after reset: the processor faults at a block whose clock is off."""
PAGE = 0x1000
PAGES = tuple(sorted({register.address // PAGE * PAGE for register in REGISTERS}))
FLASH, RAM = 0, 0x1FFF8000
UART0_INTERRUPT, PIT0_INTERRUPT = 45, 68
"""Numbers of the interrupts."""


PLACES = {(each.address, each.width): (each.name, *GATES.get(each.block, ("", 0))) for each in REGISTERS}
"""Name of the register at an address, whole, and register and bit of the clock that it needs."""


class Bank:
    """Values of all registers by name, with the effects of the peripherals.

    A peripheral puts a function into `on_read[name]`, which gives the value, or `on_write[name]`, which is called after
    the value was stored. An access to anything but a whole register of `REGISTERS` is an error of the firmware, and so
    is one to a block whose clock is off: there the processor faults. `begun` are values that differ from those after
    power comes.
    """

    def __init__(self, begun: Mapping[str, int] | None = None) -> None:
        self._begun = {register.name: register.reset for register in REGISTERS} | dict(begun or {})
        self.values: dict[str, int] = dict(self._begun)
        self.on_read: dict[str, Callable[[], int]] = {}
        self.on_write: dict[str, Callable[[int], None]] = {}

    def read(self, address: int, width: int) -> int:
        """Return what the processor reads."""
        name = self._reached("reads", address, width)
        effect = self.on_read.get(name)
        return effect() if effect else self.values[name]

    def write(self, address: int, width: int, value: int) -> None:
        """Take what the processor writes."""
        name = self._reached("writes", address, width)
        self.values[name] = value
        effect = self.on_write.get(name)
        if effect:
            effect(value)

    def untouched(self, but: str) -> bool:
        """Return whether all registers are as after reset, except for one."""
        return all(self.values[name] == value for name, value in self._begun.items() if name != but)

    def _reached(self, does: str, address: int, width: int) -> str:
        name, gate, bit = PLACES.get((address, width), ("", "", 0))
        if not name:
            raise FrictionloopError(f"image {does} 0x{address:08x}, {width} bytes: no register", "BAD-IMAGE")
        if gate and not self.values[gate] >> bit & 1:
            raise FrictionloopError(f"image {does} {name}: clock off, {gate} bit {bit}", "BAD-IMAGE")
        return name
