"""Whether a file is whole, and whether what lies in a cache may be run.

The checksum is at the end, where readers of HDF5 and of libraries do not look.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from contextlib import suppress
from pathlib import Path

MARK = b"\nfrictionloop sha256:"
LEAST_OF_MARK = 4
"""Bytes of a mark at the end of a file by which a seal is known that was cut off."""
SEAL_BYTES = len(MARK) + hashlib.sha256().digest_size


def seal_of(content: bytes) -> bytes:
    """Return what goes at the end of a file with this content."""
    return MARK + hashlib.sha256(content).digest()


def append_seal(path: str | os.PathLike[str]) -> None:
    """Seal a file that is there."""
    with open(path, "r+b") as file:
        digest = hashlib.file_digest(file, "sha256").digest()
        file.write(MARK + digest)


def is_sealed(path: str | os.PathLike[str]) -> bool:
    """Return whether a file ends in a seal, whole or not."""
    with open(path, "rb") as file:
        file.seek(max(Path(path).stat().st_size - SEAL_BYTES, 0))
        return file.read(len(MARK)) == MARK


def is_whole(path: str | os.PathLike[str]) -> bool | None:
    """Return whether the content of a file is what was sealed, None for a file without a seal; cut in it, it is not."""
    size = Path(path).stat().st_size - SEAL_BYTES
    with open(path, "rb") as file:
        file.seek(max(size, 0))
        end = file.read()
        if not end.startswith(MARK):
            is_cut = MARK in end or any(end.endswith(MARK[:k]) for k in range(LEAST_OF_MARK, len(MARK)))
            return False if is_cut else None
        told = end[len(MARK) :]
        digest, left = hashlib.sha256(), size
        file.seek(0)
        while block := file.read(min(left, 1 << 20)):
            digest.update(block)
            left -= len(block)
    return digest.digest() == told


def why_untrusted(path: Path) -> str:
    """Return who else could have put a file where it is, empty if nobody: whoever may change our own code is trusted.

    A file that is not there yet counts by its folder alone.
    """
    if not hasattr(os, "getuid"):
        return ""
    ours = Path(__file__)
    owners = {os.getuid(), 0, ours.stat().st_uid}
    others = 0o022 & ~ours.parent.stat().st_mode
    for each in (path.parent, path):
        if not os.path.lexists(each):
            continue
        told = each.lstat()
        if told.st_uid not in owners:
            return f"{each} belongs to another user"
        if told.st_mode & others and not each.is_symlink():
            return f"others may write to {each}"
    return ""


def is_usable(path: Path) -> bool:
    """Return whether a file of a cache is there and whole; a damaged one goes, which is said, to be made anew."""
    if not path.exists():
        return False
    if is_whole(path):
        return True
    warnings.warn(f"{path}: is damaged; it is made anew", stacklevel=2)
    with suppress(OSError):
        path.unlink()
    return False
