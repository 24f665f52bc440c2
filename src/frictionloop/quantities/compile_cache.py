"""Compiled functions kept on disk between processes, each under the digest of what it computes."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

from llvmlite.binding import get_host_cpu_name
from numba.core import config
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.ccallback import CFunc

from frictionloop.quantities.code_version import code_digest
from frictionloop.quantities.compile_events import tell_compiling
from frictionloop.quantities.file_integrity import is_usable, seal_of, why_untrusted


class SealedFiles(IndexDataCacheFile):
    """Numba's two files of a function, each with a checksum: a damaged one is as if it were not there."""

    def _load_index(self) -> Any:
        if not is_usable(Path(self._index_path)):
            return {}
        try:
            return super()._load_index()
        except (ImportError, AttributeError):  # it names a class of an older version
            return {}

    def _load_data(self, name: str) -> Any:
        if not is_usable(Path(self._data_path(name))):
            raise FileNotFoundError(name)
        return super()._load_data(name)

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[BytesIO]:
        content = BytesIO()
        yield content
        with super()._open_for_write(filepath) as file:
            file.write(content.getvalue() + seal_of(content.getvalue()))


class DigestCache(FunctionCache):
    """Numba's on-disk cache with one file per function, digest and processor.

    Numba keys closures by their contents, which differ from process to process, and lets processes that compile at
    the same time number their files alike, so that one may load the other's function. A file name that says what is in
    it avoids both, and a change of a docstring or of another function in the file compiles nothing anew.
    """

    def __init__(self, function: Any, name: str, digest: str) -> None:
        super().__init__(function)
        asked = config.CACHE_DIR
        if asked and not Path(self._cache_path).is_relative_to(asked):
            _warn_of_another_place(asked, str(Path(self._cache_path)))
        named = f"{name}-{digest}-{get_host_cpu_name()}-sealed"
        self._cache_file = SealedFiles(self._cache_path, named, ())
        files = (Path(self._cache_path) / f"{named}{ending}" for ending in (".nbi", ".1.nbc"))
        if why := next(filter(None, map(why_untrusted, files)), ""):
            warnings.warn(f"{why}: not used; chmod go-w it", stacklevel=2)
            self.disable()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what the disk has, None where it was compiled from somebody's module that is not here any more."""
        try:
            found = super().load_overload(sig, target_context)
        except ImportError:
            found = None
        if found is None:
            tell_compiling(True)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            _warn_of_no_cache(f"{self._cache_path}: the cache of compiled code cannot be written ({error.strerror})")
        tell_compiling(False)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return (sig, codegen.magic_tuple())


@cache
def _warn_of_another_place(asked: str, place: str) -> None:
    """Say once of each folder that Numba went on to another one than it was told."""
    warnings.warn(f"NUMBA_CACHE_DIR = {asked}: cannot be written; compiled code is kept in {place}", stacklevel=2)


def _warn_of_no_cache(why: str) -> None:
    warnings.warn(f"{why}; compiled code is lost: set NUMBA_CACHE_DIR", stacklevel=2)


def keep_compiled(function: Any, name: str) -> None:
    """Keep on the disk what calls of a `step` from Python compile, which compiled code has no use for.

    Parameters
    ----------
    function
        The step.
    name
        What its file is called, besides the digest.
    """
    if (found := _cache_of(function.py_func, name, code_digest(function))) is not None:
        function._cache = found


def compile_c(signature: Any, function: Any, name: str) -> Any:
    """Return the C function of a Python function: ``.address``, ``.ctypes``; from the disk if it is there.

    Parameters
    ----------
    signature
        Numba's signature of the C function.
    function
        What to compile, with the functions that it calls.
    name
        What its file is called, besides the digest.
    """
    digest = code_digest(function)
    # Functions from the disk that have one name would be one function to the linker.
    function.__qualname__ = f"{name}_{digest}".replace("-", "_")
    compiled: Any = CFunc(function, (signature.args, signature.return_type), {}, {"error_model": "numpy"})
    if (found := _cache_of(function, name, digest)) is not None:
        compiled._cache = found
    compiled.compile()
    return compiled


def _cache_of(function: Any, name: str, digest: str) -> DigestCache | None:
    """Return where compiled code is kept, None where no folder can be written."""
    try:
        return DigestCache(function, name, digest)
    except RuntimeError:  # Numba found no folder
        folder = Path(function.__code__.co_filename).parent / "__pycache__"
        asked = f"NUMBA_CACHE_DIR = {config.CACHE_DIR}, " if config.CACHE_DIR else ""
        _warn_of_no_cache(f"no cache of compiled code: {asked}{folder} cannot be written")
        return None
