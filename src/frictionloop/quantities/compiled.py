"""Compiled functions kept on disk between processes, each under the digest of what it computes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite.binding import get_host_cpu_name
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.ccallback import CFunc

from frictionloop.quantities.digest import code_digest

on_compiling: list[Callable[[bool], None]] = []
"""Called with True before something is compiled that the disk does not have, and with False when it is done."""


class DigestCache(FunctionCache):
    """Numba's on-disk cache with one file per function, digest and processor.

    Numba keys closures by their contents, which differ from process to process, and lets processes that compile at
    the same time number their files alike, so that one may load the other's function. A file name that says what is in
    it avoids both, and a change of a docstring or of another function in the file compiles nothing anew.
    """

    def __init__(self, function: Any, name: str, digest: str) -> None:
        super().__init__(function)
        self._cache_file = IndexDataCacheFile(self._cache_path, f"{name}-{digest}-{get_host_cpu_name()}", ())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what the disk has, None where it was compiled from somebody's module that is not here any more."""
        try:
            found = super().load_overload(sig, target_context)
        except ImportError:
            found = None
        if found is None:
            _tell(True)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled."""
        super().save_overload(sig, data)
        _tell(False)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        return (sig, codegen.magic_tuple())


def _tell(compiling: bool) -> None:
    for listener in on_compiling:
        listener(compiling)


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
    compiled._cache = DigestCache(function, name, digest)
    compiled.compile()
    return compiled
