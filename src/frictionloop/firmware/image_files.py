"""What image files hold: ELF by pyelftools, Intel hex by intelhex."""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import IO, Any

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.extra import needed

END = ":00000001FF"
"""The record that ends a file (Intel, Hexadecimal Object File Format Specification, 1988)."""


def elf_file(file: IO[bytes]) -> Any:
    """Return pyelftools' ELFFile of an open file.

    Raises
    ------
    FrictionloopError
        Without pyelftools, and for a file of another kind.
    """
    error = needed("elftools.common.exceptions", "pyelftools", "image").ELFError
    try:
        return needed("elftools.elf.elffile", "pyelftools", "image").ELFFile(file)
    except error as reason:
        raise FrictionloopError(f"{file.name}: no ELF file ({reason})", "BAD-IMAGE") from None


def symbol_bytes(path: Path, name: str) -> bytes:
    """Return what the image has at a symbol of that name, b"" without one; raises as `loaded`."""
    segments = loaded(path)
    with path.open("rb") as file:
        table = elf_file(file).get_section_by_name(".symtab")
        symbol = next(iter(table.get_symbol_by_name(name) or ()), None) if table else None
    for start, content in segments:
        if symbol is not None and start <= symbol["st_value"] < start + len(content):
            offset = symbol["st_value"] - start
            return content[offset : offset + symbol["st_size"]]
    return b""


def seal(path: Path, name: str) -> None:
    """Write into the word of that name the CRC-32 of all that is loaded before it, gaps as erased; if there is one."""
    with path.open("rb") as file:
        elf = elf_file(file)
        (symbol,) = elf.get_section_by_name(".symtab").get_symbol_by_name(name) or (None,)
        if symbol is None:
            return
        at = symbol["st_value"]
        parts = [part for part in elf.iter_segments() if part["p_type"] == "PT_LOAD" and part["p_filesz"]]
        content = bytearray(b"\xff" * at)
        for part in parts:
            content[part["p_paddr"] : part["p_paddr"] + part["p_filesz"]] = part.data()
        last = next(part for part in parts if 0 <= at - part["p_paddr"] < part["p_filesz"])
    with path.open("r+b") as file:
        file.seek(last["p_offset"] + at - last["p_paddr"])
        file.write(zlib.crc32(content[:at]).to_bytes(4, "little"))


def loaded(path: Path) -> list[tuple[int, bytes]]:
    """Return what a programmer writes to the chip: (address, bytes) of each segment, at its load address.

    Raises
    ------
    FrictionloopError
        As `elf_file`, and when the file cannot be read.
    """
    try:
        with path.open("rb") as file:
            segments = [part for part in elf_file(file).iter_segments() if part["p_type"] == "PT_LOAD"]
            return [(part["p_paddr"], part.data()) for part in segments if part["p_filesz"]]
    except OSError as error:
        raise FrictionloopError(f"{path}: cannot be read ({error.strerror or error})") from None


def read_hex(path: Path) -> list[tuple[int, bytes]]:
    """Return what an Intel hex file puts where: (address, bytes), without gaps and in the order of addresses.

    Raises
    ------
    FrictionloopError
        Without intelhex, and for a file that cannot be read, that is no such file, or has a wrong check sum.
    """
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
