"""Intel hex files, as a loader reads them."""

from __future__ import annotations

from pathlib import Path

from frictionloop.quantities import FrictionloopError

DATA, END, SEGMENT, START_SEGMENT, LINEAR, START_LINEAR = range(6)
"""Types of a record (Intel, Hexadecimal Object File Format Specification, 1988)."""


def read_hex(path: Path) -> list[tuple[int, bytes]]:
    """Return what an Intel hex file puts where: (address, bytes), without gaps and in the order of addresses.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, that is no such file, or has a wrong check sum.
    """
    memory: dict[int, int] = {}
    base, ended = 0, False
    try:
        lines = path.read_text(encoding="ascii").split()
    except (OSError, UnicodeDecodeError) as error:
        raise FrictionloopError(f"{path}: cannot be read as Intel hex ({error})") from None
    for number, line in enumerate(lines, 1):
        kind, address, content = _record(f"{path}, line {number}", line)
        if kind == DATA:
            memory |= {base + address + k: byte for k, byte in enumerate(content)}
        elif kind in (SEGMENT, LINEAR):
            base = int.from_bytes(content, "big") << (4 if kind == SEGMENT else 16)
        ended = kind == END
    if not ended:
        raise FrictionloopError(f"{path}: does not end as Intel hex does; it is cut off")
    return _stretches(memory)


def _record(where: str, line: str) -> tuple[int, int, bytes]:
    try:
        raw = bytes.fromhex(line.removeprefix(":"))
    except ValueError:
        raw = b""
    if not line.startswith(":") or len(raw) < 5 or len(raw) != raw[0] + 5 or sum(raw) % 256:
        raise FrictionloopError(f"{where}: is no record of Intel hex, or its check sum is wrong")
    return raw[3], int.from_bytes(raw[1:3], "big"), raw[4:-1]


def _stretches(memory: dict[int, int]) -> list[tuple[int, bytes]]:
    found: list[tuple[int, bytearray]] = []
    for address in sorted(memory):
        if not found or address != found[-1][0] + len(found[-1][1]):
            found.append((address, bytearray()))
        found[-1][1].append(memory[address])
    return [(start, bytes(content)) for start, content in found]
