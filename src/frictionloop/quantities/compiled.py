"""Keeping compiled functions on disk between processes."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from llvmlite.binding import get_host_cpu_name
from numba.core.caching import FunctionCache, IndexDataCacheFile

ROOMS = ("quantities", "physics", "sensing", "control", "perception", "loop")
"""Where compiled steps live."""


def source_digest() -> str:
    """Return a digest of all compiled source: Numba's cache checks one file, but a kernel is built from many."""
    digest = hashlib.sha256()
    package = Path(__file__).parents[1]
    for path in sorted(package.rglob("*.py")):
        if path.relative_to(package).parts[0] in ROOMS:
            digest.update(path.read_bytes())
    return digest.hexdigest()


SOURCE_DIGEST = source_digest()
"""Taken on import, together with the code that it stands for."""


class SourceCache(FunctionCache):
    """Numba's on-disk cache with one file per function, source and processor.

    Numba keys closures by their contents, which differ from process to process, and lets processes that compile at
    the same time number their files alike, so that one may load the other's kernel. A file name that says what is in
    it avoids both.
    """

    def __init__(self, function: Any, what: str) -> None:
        super().__init__(function)
        name = f"{self._impl.filename_base}-{what}-{SOURCE_DIGEST[:16]}-{get_host_cpu_name()}"
        self._cache_file = IndexDataCacheFile(self._cache_path, name, self._impl.locator.get_source_stamp())

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return (sig, codegen.magic_tuple())
