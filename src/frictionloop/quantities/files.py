"""Writing a file beside the old one and renaming it at the end, so that nothing is ever half-written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from frictionloop.quantities.units import FrictionloopError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a path beside ``path`` to write to; on success it takes the old file's place, on failure it goes."""
    target = Path(path)
    if not target.name:
        raise FrictionloopError(f"path = {str(path)!r}: must be the name of a file")
    beside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield beside
        beside.replace(target)
    except OSError as error:
        raise FrictionloopError(
            f"{target}: cannot be written ({error.strerror or error}); the old file is untouched"
        ) from None
    finally:
        with suppress(OSError):
            beside.unlink()
