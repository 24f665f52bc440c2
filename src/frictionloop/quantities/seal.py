"""A checksum of all that is in a file, at its end, where readers of HDF5 and of libraries do not look."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

MARK = b"\nfrictionloop sha256:"
SEAL_BYTES = len(MARK) + hashlib.sha256().digest_size


def seal_of(content: bytes) -> bytes:
    """Return what goes at the end of a file with this content."""
    return MARK + hashlib.sha256(content).digest()


def append_seal(path: str | os.PathLike[str]) -> None:
    """Seal a file that is there."""
    with open(path, "r+b") as file:
        digest = hashlib.file_digest(file, "sha256").digest()
        file.write(MARK + digest)


def is_whole(path: str | os.PathLike[str]) -> bool | None:
    """Return whether the content of a file is what was sealed, None for a file without a seal."""
    size = Path(path).stat().st_size - SEAL_BYTES
    with open(path, "rb") as file:
        if size < 0:
            return None
        file.seek(size)
        mark, told = file.read(len(MARK)), file.read()
        if mark != MARK:
            return None
        digest, left = hashlib.sha256(), size
        file.seek(0)
        while block := file.read(min(left, 1 << 20)):
            digest.update(block)
            left -= len(block)
    return digest.digest() == told
