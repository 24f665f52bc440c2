"""Registers, fields and interrupts of an SVD file (CMSIS System View Description)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from frictionloop.quantities import FrictionloopError

PREFIXES = {"PDB0_": "PDB_", "NVIC_NVICISER": "NVIC_ISER", "NVIC_NVICIP": "NVIC_IPR"}
"""Where this project's names are shorter than the vendor's."""


class Entry(NamedTuple):
    """A register: address, bytes, value after reset and which of its bits have one, (place, width) of each field."""

    address: int
    width: int
    reset: int
    known: int
    fields: dict[str, tuple[int, int]]


class Svd:
    """What an SVD file says, by the names of registers.h."""

    def __init__(self, path: Path) -> None:
        try:
            root = ElementTree.parse(path).getroot()
        except (OSError, ElementTree.ParseError) as error:
            raise FrictionloopError(f"{path}: must be an SVD file: {error}") from None
        self.registers: dict[str, Entry] = {}
        self.interrupts: dict[str, int] = {}
        for peripheral in root.iter("peripheral"):
            for interrupt in peripheral.iter("interrupt"):
                self.interrupts[_text(interrupt, "name")] = _number(interrupt, "value")
            prefix = peripheral.findtext("prependToName") or f"{_text(peripheral, 'name')}_"
            for register in peripheral.iter("register"):
                self._take(prefix, _number(peripheral, "baseAddress"), register)

    def compare(self, name: str, address: int, width: int, reset: int | None = None) -> list[str]:
        """Return what is not as the file says, one line each."""
        entry = self.registers.get(name)
        if entry is None:
            return [f"{name} is not in the SVD file"]
        lines = []
        if address != entry.address:
            lines.append(f"{name} is at {entry.address:#x}, not {address:#x}")
        if width != entry.width:
            lines.append(f"{name} has {entry.width} bytes, not {width}")
        if reset is not None and (reset ^ entry.reset) & entry.known:
            lines.append(f"{name} is {entry.reset:#x} after reset, not {reset:#x}")
        return lines

    def value(self, name: str, settings: list[str]) -> int | None:
        """Return the register's value with fields set as `FIELD=number`; None where there is no such field."""
        word, entry = 0, self.registers.get(name)
        if entry is None:
            return None
        for setting in settings:
            field, _, number = setting.partition("=")
            place, width = entry.fields.get(field, (0, 0))
            if int(number or 0) >> width:
                return None
            word |= int(number or 0) << place
        return word

    def _take(self, prefix: str, base: int, register: ElementTree.Element) -> None:
        fields = {_text(part, "name"): (_number(part, "bitOffset"), _number(part, "bitWidth"))
                  for part in register.iter("field")}  # fmt: skip
        indices = [part for part in (register.findtext("dimIndex") or "").split(",") if part] or [""]
        for place, index in enumerate(indices):
            name = prefix + _text(register, "name").replace("%s", index)
            for long, short in PREFIXES.items():
                name = re.sub(f"^{long}", short, name)
            step = _number(register, "dimIncrement") if index else 0
            self.registers[name] = Entry(
                base + _number(register, "addressOffset") + place * step,
                _number(register, "size") // 8,
                _number(register, "resetValue"),
                _number(register, "resetMask"),
                fields,
            )


def _text(element: ElementTree.Element, name: str) -> str:
    return element.findtext(name) or ""


def _number(element: ElementTree.Element, name: str) -> int:
    return int(_text(element, name), 0)
