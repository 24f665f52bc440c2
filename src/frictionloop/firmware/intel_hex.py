"""Intel hex files, as a loader reads them."""

from __future__ import annotations

from pathlib import Path

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.extra import needed

END = ":00000001FF"
"""The record that ends a file (Intel, Hexadecimal Object File Format Specification, 1988)."""


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
        raise FrictionloopError(f"{path}: cannot be read as Intel hex ({error})") from None
    if [record.upper() for record in last] != [END]:
        raise FrictionloopError(f"{path}: does not end as Intel hex does; it is cut off")
    return [(start, bytes(content.tobinarray(start=start, end=end - 1))) for start, end in content.segments()]
