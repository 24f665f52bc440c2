"""What an image must be before anyone may flash it."""

from __future__ import annotations

import re
from pathlib import Path

from frictionloop.firmware.image_files import elf_file, loaded
from frictionloop.quantities import FrictionloopError, must_be

FLASH_BYTES, RAM_BYTES = 256 * 1024, 64 * 1024
"""What the chip has."""
FLASH_LIMIT, RAM_LIMIT = 32 * 1024, 24 * 1024
"""What an image may take: the rest is for what a lab adds."""
CONFIGURATION_ADDRESS = 0x400
CONFIGURATION = bytes(12 * [0xFF] + [0xDE, 0xF9, 0xFF, 0xFF])
"""Key, protection, FSEC unsecured with mass erase, FOPT without NMI pin (K20P64M72SF1RM, flash
configuration field): other words can lock
the chip for good."""
_RAM = 0x1FFF0000
_FLOAT = re.compile(r"__aeabi_(c?[fd](?!2)|[a-z]+2[fd]$|f2|d2)|__\w+[sdt]f[0-9i]|sqrtf?$")
_HEAP = re.compile(r"_?(malloc|calloc|realloc|free|sbrk)(_r)?$")


def check(elf: Path, *, flash_configuration: bool, budget: bool = True) -> None:
    """Refuse an image that calculates in floating point, has a heap, would lock the chip, or is too large.

    Parameters
    ----------
    elf
        The image.
    flash_configuration
        Whether the board has the words at 0x400.
    budget
        Whether `FLASH_LIMIT` and `RAM_LIMIT` count.

    Raises
    ------
    FrictionloopError
        Naming what is wrong.
    """
    with elf.open("rb") as file:
        names = [symbol.name for symbol in elf_file(file).get_section_by_name(".symtab").iter_symbols()]
    for pattern, what in ((_FLOAT, "floating point"), (_HEAP, "a heap")):
        found = sorted({name for name in names if pattern.match(name)})
        if found:
            raise FrictionloopError(f"{elf.name}: must be without {what}: {', '.join(found)}", "BAD-IMAGE")
    for size, limit, name in zip(sizes(elf), (FLASH_LIMIT, RAM_LIMIT), ("flash", "RAM"), strict=True):
        if budget and size > limit:
            raise must_be(f"{elf.name}: {name}", size, f"at most {limit}", "bytes", "BAD-IMAGE")
    if flash_configuration:
        words = configuration_of(loaded(elf))
        if words != CONFIGURATION:
            raise must_be(f"{elf.name}: configuration", words.hex(), CONFIGURATION.hex(), code="BAD-IMAGE")


def sizes(elf: Path) -> tuple[int, int]:
    """Return the bytes of flash, from 0 to the end of what is loaded, and of RAM, stack and all."""
    flash = max(address + len(content) for address, content in loaded(elf))
    with elf.open("rb") as file:
        sections = [(part["sh_flags"], part["sh_addr"], part["sh_size"]) for part in elf_file(file).iter_sections()]
    allocated = 2  # SHF_ALLOC
    return flash, sum(size for flags, address, size in sections if flags & allocated and address >= _RAM)


def memory_map(elf: Path) -> Path:
    """Write address, size and name of every symbol that has a size beside the ELF file, largest first."""
    with elf.open("rb") as file:
        table = elf_file(file).get_section_by_name(".symtab")
        rows = [(symbol["st_size"], symbol["st_value"], symbol.name) for symbol in table.iter_symbols()]
    path = elf.with_suffix(".map")
    lines = [f"{address:08x} {size:6d} {name}\n" for size, address, name in sorted(rows, reverse=True) if size]
    path.write_text("".join(lines), encoding="utf-8")
    return path


def configuration_of(segments: list[tuple[int, bytes]]) -> bytes:
    """Return the 16 bytes of the flash configuration in what is loaded, (address, bytes); empty if not there."""
    count = len(CONFIGURATION)
    for start, content in segments:
        at = CONFIGURATION_ADDRESS - start
        if 0 <= at <= len(content) - count:
            return content[at : at + count]
    return b""


def check_teensy(name: str, segments: list[tuple[int, bytes]]) -> None:
    """Refuse what was not built for a Teensy 3.1: it lacks the words at 0x400 that keep the chip open."""
    if configuration_of(segments) != CONFIGURATION:
        raise FrictionloopError(f"{name}: is no image of a Teensy", "BAD-IMAGE")
