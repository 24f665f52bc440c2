"""Registers, fields and interrupts of an SVD file (CMSIS System View Description), read by cmsis-svd."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.optional_libraries import needed

SHORTER = {r"^NVIC_NVICISER": "NVIC_ISER", r"^NVIC_NVICIP": "NVIC_IPR", r"^PIT_TIMER\[(\d)\]_(\w+)": r"PIT_\2\1",
           r"^IOMUXC_SW_(MUX|PAD)_CTL_PAD_GPIO_": r"IOMUXC_\1_"}  # fmt: skip
"""Where this project's names are shorter than the vendor's."""


class Svd:
    """What an SVD file says, by the names of registers.h."""

    def __init__(self, path: Path) -> None:
        parser = needed("cmsis_svd", "cmsis-svd", "test").SVDParser
        try:
            device = parser.for_xml_file(path).get_device()
        except (OSError, SyntaxError) as error:
            raise FrictionloopError(f"{path}: must be an SVD file: {error}") from None
        self.interrupts = {each.name: each.value for part in device.peripherals for each in part.interrupts or ()}
        self.registers: dict[str, tuple[int, Any]] = {}
        for part in device.peripherals:
            for register in part.get_registers():
                name = register.name if part.prepend_to_name else f"{part.name}_{register.name}"
                for long, short in SHORTER.items():
                    name = re.sub(long, short, name)
                self.registers[name] = (part.base_address + register.address_offset, register)

    def compare(self, name: str, address: int, width: int, reset: int | None = None) -> list[str]:
        """Return what is not as the file says, one line each."""
        if name not in self.registers:
            return [f"{name} is not in the SVD file"]
        there, register = self.registers[name]
        lines = []
        if address != there:
            lines.append(f"{name} is at {there:#x}, not {address:#x}")
        if 8 * width != register.size:
            lines.append(f"{name} has {register.size // 8} bytes, not {width}")
        if reset is not None and (reset ^ register.reset_value) & register.reset_mask:
            lines.append(f"{name} is {register.reset_value:#x} after reset, not {reset:#x}")
        return lines

    def value(self, name: str, settings: list[str]) -> int | None:
        """Return the register's value with fields set as `FIELD=number`; None where there is no such field."""
        if name not in self.registers:
            return None
        word, fields = 0, {each.name: each for each in self.registers[name][1].fields}
        for setting in settings:
            field, _, number = setting.partition("=")
            if field not in fields or int(number or 0) >> fields[field].bit_width:
                return None
            word |= int(number or 0) << fields[field].bit_offset
        return word

    def fields(self, name: str) -> list[tuple[int, str]]:
        """Return the fields of a register, as first bit and what the file says of each."""
        if name not in self.registers:
            return []
        return [(each.bit_offset, each.description or "") for each in self.registers[name][1].fields]
