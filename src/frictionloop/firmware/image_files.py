"""What image files hold (ELF by pyelftools, Intel hex by intelhex), and what one must be before it may be flashed."""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.optional_libraries import needed

END = ":00000001FF"
"""The record that ends a file (Intel, Hexadecimal Object File Format Specification, 1988)."""


def elf_file(file: IO[bytes]) -> Any:
    """Return pyelftools' ELFFile of an open file."""
    error = needed("elftools.common.exceptions", "pyelftools", "image").ELFError
    try:
        return needed("elftools.elf.elffile", "pyelftools", "image").ELFFile(file)
    except error as reason:
        raise FrictionloopError(f"{file.name}: no ELF file ({reason})", "BAD-IMAGE") from None


def symbol_bytes(path: Path, name: str) -> bytes:
    """Return what the image has at a symbol of that name, b"" without one; raises as `loaded`."""
    loaded(path)  # raises
    with path.open("rb") as file:
        elf = elf_file(file)
        table = elf.get_section_by_name(".symtab")
        for symbol in (table.get_symbol_by_name(name) or ()) if table else ():
            for part in elf.iter_segments():
                offset = symbol["st_value"] - part["p_vaddr"]
                if part["p_type"] == "PT_LOAD" and 0 <= offset < part["p_filesz"]:
                    return bytes(part.data()[offset : offset + symbol["st_size"]])
    return b""


def addresses(path: Path, names: Iterable[str]) -> dict[str, int]:
    """Return where an image has these symbols; without those that it has not."""
    with path.open("rb") as file:
        table = elf_file(file).get_section_by_name(".symtab")
        found = {name: table.get_symbol_by_name(name) for name in names}
    return {name: symbols[0]["st_value"] for name, symbols in found.items() if symbols}


def seal(path: Path, name: str) -> None:
    """Write into the word of that name the CRC-32 of all that is loaded before it, gaps as erased; if there is one."""
    with path.open("rb") as file:
        elf = elf_file(file)
        (symbol,) = elf.get_section_by_name(".symtab").get_symbol_by_name(name) or (None,)
        if symbol is None:
            return
        at = symbol["st_value"]
        parts = [part for part in elf.iter_segments() if part["p_type"] == "PT_LOAD" and part["p_filesz"]]
        first = min(part["p_paddr"] for part in parts)
        content = bytearray(b"\xff" * (at - first))
        for part in parts:
            content[part["p_paddr"] - first : part["p_paddr"] - first + part["p_filesz"]] = part.data()
        last = next(part for part in parts if 0 <= at - part["p_paddr"] < part["p_filesz"])
    with path.open("r+b") as file:
        file.seek(last["p_offset"] + at - last["p_paddr"])
        file.write(zlib.crc32(content[: at - first]).to_bytes(4, "little"))


def loaded(path: Path) -> list[tuple[int, bytes]]:
    """Return what a programmer writes to the chip: (address, bytes) of each segment, at its load address."""
    try:
        with path.open("rb") as file:
            segments = [part for part in elf_file(file).iter_segments() if part["p_type"] == "PT_LOAD"]
            return [(part["p_paddr"], part.data()) for part in segments if part["p_filesz"]]
    except OSError as error:
        raise FrictionloopError(f"{path}: cannot be read ({error.strerror or error})") from None


def read_hex(path: Path) -> list[tuple[int, bytes]]:
    """Return what an Intel hex file puts where: (address, bytes), without gaps and in the order of addresses."""
    library = needed("intelhex", "intelhex")
    content = library.IntelHex()
    try:
        content.loadhex(str(path))
        last = path.read_text(encoding="ascii").split()[-1:]
    except (OSError, ValueError, library.IntelHexError) as error:
        raise FrictionloopError(f"{path}: no Intel hex ({error})", "BAD-IMAGE") from None
    if [record.upper() for record in last] != [END]:
        raise FrictionloopError(f"{path}: cut off, no {END}", "BAD-IMAGE")
    return [(start, bytes(content.tobinarray(start=start, end=end - 1))) for start, end in content.segments()]


FLASH, FLASH_BYTES, RAM_BYTES = 0x60000000, 7936 * 1024, 512 * 1024
"""Of a Teensy 4.1: where its flash is, what of it a program may have, and its tightly coupled memory."""
FLASH_LIMIT, RAM_LIMIT = 128 * 1024, 128 * 1024
"""What an image may take: the rest is for what a lab adds."""
_FLOAT = re.compile(r"__aeabi_(c?[fd](?!2u?lz$)|u?i2[fd]$)|__\w+[sdt]f[23]$|(fma|sqrt|floor|ceil|fabs)[fl]?$")
"""Arithmetic that is a call where it should be an instruction; those of 64-bit whole numbers to and from doubles have
none, and are exact."""
_HEAP = re.compile(r"_?(malloc|calloc|realloc|free|sbrk)(_r)?$")


def check(elf: Path, *, teensy: bool, budget: bool = True) -> None:
    """Refuse an image that calculates doubles in software, has a heap, would not start, or is too large.

    Parameters
    ----------
    elf
        The image.
    teensy
        Whether it is for a Teensy 4.1.
    budget
        Whether `FLASH_LIMIT` and `RAM_LIMIT` count.

    Raises
    ------
    FrictionloopError
        Naming what is wrong.
    """
    with elf.open("rb") as file:
        names = [symbol.name for symbol in elf_file(file).get_section_by_name(".symtab").iter_symbols()]
    for pattern, what in ((_FLOAT, "soft floating point"), (_HEAP, "a heap")):
        found = sorted({name for name in names if pattern.match(name)})
        if found:
            raise FrictionloopError(f"{elf.name}: must be without {what}: {', '.join(found)}", "BAD-IMAGE")
    for size, limit, name in zip(sizes(elf), (FLASH_LIMIT, RAM_LIMIT), ("flash", "RAM"), strict=True):
        if budget and size > limit:
            raise must_be(f"{elf.name}: {name}", size, f"at most {limit}", "bytes", "BAD-IMAGE")
    if teensy:
        check_teensy(elf.name, loaded(elf))


def sizes(elf: Path) -> tuple[int, int]:
    """Return the bytes of flash, from its begin to the end of what is loaded, and of RAM, stack and all."""
    parts = loaded(elf)
    first, last = min(at for at, _ in parts), max(at + len(content) for at, content in parts)
    with elf.open("rb") as file:
        sections = [(part["sh_flags"], part["sh_addr"], part["sh_size"]) for part in elf_file(file).iter_sections()]
    allocated = 2  # SHF_ALLOC
    return last - first, sum(size for flags, at, size in sections if flags & allocated and not first <= at < last)


def memory_map(elf: Path) -> Path:
    """Write address, size and name of every symbol that has a size beside the ELF file, largest first."""
    with elf.open("rb") as file:
        table = elf_file(file).get_section_by_name(".symtab")
        rows = [(symbol["st_size"], symbol["st_value"], symbol.name) for symbol in table.iter_symbols()]
    path = elf.with_suffix(".map")
    lines = [f"{address:08x} {size:6d} {name}\n" for size, address, name in sorted(rows, reverse=True) if size]
    path.write_text("".join(lines), encoding="utf-8")
    return path


FLASH_TAG, VECTORS_TAG, VECTORS_AT = b"FCFB", 0x432000D1, 0x1000
"""With what the FlexSPI configuration block and the image vector table begin, and where this is (i.MX RT1060 Reference
Manual, System Boot)."""


def entry_of(segments: list[tuple[int, bytes]]) -> int | None:
    """Return where the ROM of a Teensy 4.1 enters what is loaded, (address, bytes); None where it would not."""
    head = dict(segments).get(FLASH, b"")
    if not head.startswith(FLASH_TAG) or len(head) < VECTORS_AT + 32:
        return None
    tag, entry, *_, boot, itself, _, _ = struct.unpack_from("<8I", head, VECTORS_AT)
    (begin,) = struct.unpack_from("<I", head, boot - FLASH) if 0 <= boot - FLASH <= len(head) - 4 else (0,)
    starts = tag == VECTORS_TAG and itself == FLASH + VECTORS_AT and begin == FLASH
    return int(entry) if starts and 0 < entry - FLASH < len(head) else None


def check_teensy(name: str, segments: list[tuple[int, bytes]]) -> None:
    """Refuse what was not built for a Teensy 4.1: its ROM would not start it."""
    if entry_of(segments) is None:
        raise FrictionloopError(f"{name}: is no image of a Teensy 4.1", "BAD-IMAGE")
