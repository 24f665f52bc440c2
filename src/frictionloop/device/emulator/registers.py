"""The registers of the MIMXRT1062 that the firmware may touch: name, address, width, value, and what an access does.

Written after the i.MX RT1060 Processor Reference Manual, and compared with the vendor's SVD file by
firmware/boards/teensy41/check_registers.py. What is not in that file (MPU, DEMCR, DWT): the ARMv7-M Architecture
Reference Manual.
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
        return self.name.rpartition("_TRIG")[0] or self.name.partition("_")[0]


def _block(
    prefix: str, base: int, width: int, names: dict[str, int], resets: dict[str, int] | None = None
) -> list[Register]:
    at_reset = resets or {}
    return [Register(f"{prefix}_{name}", base + offset, width, at_reset.get(name, 0)) for name, offset in names.items()]


_CCM = {
    "CBCDR": 0x14, "CBCMR": 0x18, "CSCMR1": 0x1C, "CSCDR1": 0x24, "CLPCR": 0x54, "CCGR1": 0x6C, "CCGR2": 0x70,
    "CCGR3": 0x74, "CCGR4": 0x78, "CCGR5": 0x7C,
}  # fmt: skip
_CCM_RESET = {
    "CBCDR": 0xA8300, "CBCMR": 0x2DAE8324, "CSCMR1": 0x04900000, "CSCDR1": 0x06490B00, "CLPCR": 0x79,
    "CCGR1": 0xFFFFFFFF, "CCGR2": 0xFC3FFFFF, "CCGR3": 0xFFFFFFCF, "CCGR4": 0xFFFFFFFF, "CCGR5": 0xFFFFFFFF,
}  # fmt: skip
_ADC, _ADC_RESET = {"HC0": 0, "HC1": 4, "CFG": 0x44, "GC": 0x48, "GS": 0x4C}, {"HC0": 0x1F, "HC1": 0x1F, "CFG": 0x200}
_TRIGGER = {"CTRL": 0x00, "COUNTER": 0x04, "CHAIN_1_0": 0x08, "RESULT_1_0": 0x18}
_PWM = {
    "SM0INIT": 0x02, "SM0CTRL2": 0x04, "SM0CTRL": 0x06, "SM0VAL1": 0x0E, "SM0VAL2": 0x12, "SM0VAL3": 0x16,
    "OUTEN": 0x180, "MCTRL": 0x188, "FCTRL0": 0x18C, "FSTS0": 0x18E,
}  # fmt: skip
_PIT = {"MCR": 0x00, "LDVAL0": 0x100, "CVAL0": 0x104, "TCTRL0": 0x108, "TFLG0": 0x10C}
_LPUART = {"BAUD": 0x10, "STAT": 0x14, "CTRL": 0x18, "DATA": 0x1C, "FIFO": 0x28, "WATER": 0x2C}
_LPUART_RESET = {"BAUD": 0x0F000004, "STAT": 0x00C00000, "DATA": 0x1000, "FIFO": 0x00C00011}
_LPSPI = {"CR": 0x10, "SR": 0x14, "CFGR1": 0x24, "CCR": 0x40, "TCR": 0x60, "TDR": 0x64, "RDR": 0x74}
_MUX = {
    "AD_B0_02": 0xC4, "AD_B0_03": 0xC8, "AD_B1_08": 0x11C, "B0_00": 0x13C, "B0_01": 0x140, "B0_02": 0x144,
    "B0_03": 0x148,
}  # fmt: skip
_PAD = {"AD_B0_03": 0x2B8, "AD_B1_00": 0x2EC, "AD_B1_06": 0x304, "AD_B1_07": 0x308, "AD_B1_14": 0x324}
_SCB = {"VTOR": 0x08, "CCR": 0x14, "SHCSR": 0x24, "CPACR": 0x88, "ICIALLU": 0x250}

REGISTERS = (
    *_block("CCM", 0x400FC000, 4, _CCM, _CCM_RESET),
    *_block("SRC", 0x400F8000, 4, {"SCR": 0, "SRSR": 8}, {"SCR": 0xA0480520, "SRSR": 1}),
    *_block("RTWDOG", 0x400BC000, 4, {"CS": 0, "CNT": 4, "TOVAL": 8, "WIN": 0xC}, {"CS": 0x2980, "TOVAL": 0x400}),
    *_block("ADC1", 0x400C4000, 4, _ADC, _ADC_RESET),
    *_block("ADC2", 0x400C8000, 4, _ADC, _ADC_RESET),
    Register("ADC_ETC_CTRL", 0x403B0000, 4, 0xC0000000),
    *_block("ADC_ETC_TRIG0", 0x403B0010, 4, _TRIGGER),
    *_block("ADC_ETC_TRIG4", 0x403B00B0, 4, _TRIGGER),
    *_block("XBARA1", 0x403BC000, 2, {"SEL51": 0x66, "SEL53": 0x6A}),
    *_block("PWM4", 0x403E8000, 2, _PWM, {"SM0CTRL": 0x400}),
    *_block("PIT", 0x40084000, 4, _PIT, {"MCR": 0x02}),
    *_block("LPUART6", 0x40198000, 4, _LPUART, _LPUART_RESET),
    *_block("LPSPI4", 0x403A0000, 4, _LPSPI, {"SR": 1, "TCR": 0x1F}),
    *_block("IOMUXC_MUX", 0x401F8000, 4, _MUX, dict.fromkeys(_MUX, 5)),
    *_block("IOMUXC_PAD", 0x401F8000, 4, _PAD, dict.fromkeys(_PAD, 0x10B0)),
    Register("IOMUXC_LPUART6_RX_SELECT_INPUT", 0x401F8550, 4),
    *_block("IOMUXC_GPR", 0x400AC000, 4, {"GPR14": 0x38, "GPR16": 0x40, "GPR17": 0x44}, {"GPR16": 0x200003}),
    *_block("GPIO1", 0x401B8000, 4, {"GDIR": 0x04, "DR_CLEAR": 0x88}),
    *(Register(f"NVIC_ISER{word}", 0xE000E100 + 4 * word, 4) for word in range(5)),
    *(Register(f"NVIC_IPR{interrupt}", 0xE000E400 + interrupt, 1) for interrupt in range(158)),
    *_block("SCB", 0xE000ED00, 4, _SCB, {"CCR": 0x40000}),
    *_block("MPU", 0xE000ED94, 4, {"CTRL": 0, "RBAR": 8, "RASR": 0xC}),
    Register("DEMCR", 0xE000EDFC, 4),
    Register("DWT_CTRL", 0xE0001000, 4, 0x40000000),
    Register("DWT_CYCCNT", 0xE0001004, 4),
)
"""All of them. What is not here, the firmware may not touch."""
GATES = {
    "LPSPI4": ("CCM_CCGR1", 6), "ADC2": ("CCM_CCGR1", 8), "PIT": ("CCM_CCGR1", 12), "ADC1": ("CCM_CCGR1", 16),
    "GPIO1": ("CCM_CCGR1", 26), "XBARA1": ("CCM_CCGR2", 22), "LPUART6": ("CCM_CCGR3", 6), "PWM4": ("CCM_CCGR4", 22),
    "RTWDOG": ("CCM_CCGR5", 4),
}  # fmt: skip
"""Register and first of two bits of a block's clock. On after reset; here off, as a ROM may leave them."""
PAGE = 0x1000
PAGES = tuple(sorted({register.address // PAGE * PAGE for register in REGISTERS}))
LPUART6_INTERRUPT, PIT_INTERRUPT = 25, 122
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
        self.values: dict[str, int] = {register.name: register.reset for register in REGISTERS}
        for register, bit in GATES.values():
            self.values[register] &= ~(3 << bit)
        self.values |= begun or {}
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

    def _reached(self, does: str, address: int, width: int) -> str:
        name, gate, bit = PLACES.get((address, width), ("", "", 0))
        if not name:
            raise FrictionloopError(f"image {does} 0x{address:08x}, {width} bytes: no register", "BAD-IMAGE")
        if gate and self.values[gate] >> bit & 3 != 3:
            raise FrictionloopError(f"image {does} {name}: clock off, {gate} bit {bit}", "BAD-IMAGE")
        return name
