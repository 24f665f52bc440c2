"""Writing a file beside the old one and renaming it at the end, so that nothing is ever half-written."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from frictionloop.quantities.units import FrictionloopError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a path beside ``path`` to write to; on success it takes the old file's place, on failure it goes.

    Raises
    ------
    FrictionloopError
        For a path that cannot be written, or that is a device, a pipe or a socket.
    """
    target = Path(path)
    if not target.name:
        raise FrictionloopError(f"path = {str(path)!r}: must be the name of a file")
    # What is renamed onto a device takes its place: root would lose /dev/null.
    if target.exists() and not (target.is_file() or target.is_dir()):
        raise FrictionloopError(f"{target}: cannot be written (it is a device or a pipe, not a file)")
    beside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield beside
        beside.replace(target)
    except OSError as error:
        kept = "; the old file is untouched" if os.path.isfile(target) else ""
        raise FrictionloopError(f"{target}: cannot be written ({error.strerror or error}){kept}") from None
    finally:
        with suppress(OSError):
            beside.unlink()


def why_unwritable(folder: str | os.PathLike[str]) -> str:
    """Return why no file can be made in a folder, empty if one can; nothing is left there."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            return ""
    except OSError as error:
        return error.strerror or str(error)
