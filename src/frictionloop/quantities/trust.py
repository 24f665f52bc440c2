"""Whether what lies in a cache may be run: nobody else could have put it there, and it is whole."""

from __future__ import annotations

import os
import warnings
from contextlib import suppress
from pathlib import Path

from frictionloop.quantities.seal import is_whole


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
