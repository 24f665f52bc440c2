"""What an image is of: the package's version, and the checksum of the C sources."""

from __future__ import annotations

import zlib
from functools import cache
from pathlib import Path

from frictionloop.firmware.image_files import symbol_bytes
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.code_version import package_version
from frictionloop.quantities.protocol_schema import firmware_folder

REVISION_BYTES = 16
"""Of ``identity.revision``."""
SYMBOL = "fl_built_revision"
"""Where an image has it (firmware/boards/built.h)."""


@cache
def revision_here() -> str:
    """Return ``version+checksum`` of the sources here, at most 16 characters: ``0.2.0+5f1c03aa``.

    The checksum is the CRC-32 of names and contents of all C files of core and boards, whatever ends their lines.
    """
    crc, folder = 0, firmware_folder()
    for path in sorted(folder.rglob("*.[ch]"), key=lambda path: path.relative_to(folder).as_posix()):
        name = path.relative_to(folder).as_posix().encode()
        crc = zlib.crc32(name + b"\0" + path.read_bytes().replace(b"\r\n", b"\n") + b"\0", crc)
    checksum = f"+{crc:08x}"
    return package_version()[: REVISION_BYTES - len(checksum)] + checksum


def revision_of(image: Path) -> str | None:
    """Return the revision of a built image, None for a file that has none."""
    try:
        found = symbol_bytes(image, SYMBOL)
    except FrictionloopError:
        return None
    return found.rstrip(b"\0").decode("ascii", "replace") if found else None


def other_sources(image: Path) -> str:
    """Return what to add to an error about an image that was not built from the sources here, "" about one that was."""
    built = revision_of(image)
    if built is None or built == revision_here():
        return ""
    return f"; {image.name} is of {built}, here {revision_here()}: build anew"
