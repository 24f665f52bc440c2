"""Which frictionloop this is: its version, and what its code computes."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Iterable
from functools import cache
from importlib.machinery import SourceFileLoader
from importlib.metadata import PackageNotFoundError, version
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType
from typing import Any

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite")
"""What decides the bits of a result besides our own code."""


@cache
def package_version() -> str:
    """Return the version of the installed package."""
    return version_of("frictionloop")


@cache
def code_version(*rooms: str) -> str:
    """Return a digest of the code in some folders of this package, and of the libraries that compute with it.

    Comments, docstrings and the places of lines do not count; files of C do as they are.
    """
    package = Path(__file__).parents[1]
    return sources_digest(package / room for room in rooms)


def sources_digest(folders: Iterable[Path]) -> str:
    """Return a digest of the Python and C sources in some folders, by what they compute."""
    digest = hashlib.sha256(repr([sys.version, *map(version_of, LIBRARIES)]).encode())
    for folder in folders:
        for path in sorted(each for each in folder.rglob("*") if each.suffix in (".py", ".c", ".h")):
            digest.update(f"{path.relative_to(folder)}\0".encode())
            if path.suffix == ".py":
                _add(digest, SourceFileLoader(path.stem, str(path)).get_code(path.stem))  # compiled before, mostly
            else:
                digest.update(path.read_bytes())
    return digest.hexdigest()[:20]


def _add(digest: Any, code: CodeType | None) -> None:
    assert code is not None  # a file of sources has code
    digest.update(code.co_code)
    digest.update(repr((code.co_names, code.co_varnames)).encode())
    docstring = _docstring(code)
    for each in code.co_consts:
        if isinstance(each, CodeType):
            _add(digest, each)
        elif each is not docstring:
            # The order of a set of constants differs from process to process.
            digest.update(repr(sorted(each, key=repr) if isinstance(each, frozenset) else each).encode())


def _docstring(code: CodeType) -> Any:
    """Return the constant that is the docstring: the first of a function or module, of a class that after its name."""
    if code.co_flags & CO_OPTIMIZED:
        return code.co_consts[0] if code.co_consts and isinstance(code.co_consts[0], str) else code
    texts = [each for each in code.co_consts if isinstance(each, str)]
    return texts["__qualname__" in code.co_names] if "__doc__" in code.co_names else code


@cache
def cited_version() -> str:
    """Return the version, and of a clone the commit after a plus: 0.2.0+g1a2b3c4d, with .modified if files differ."""
    clone = Path(__file__).parents[3]
    if not (clone / ".git").exists():
        return package_version()
    words = ("git", "-C", str(clone), "describe", "--always", "--abbrev=10", "--exclude=*", "--dirty=.modified")
    try:
        found = subprocess.run(words, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
    except (OSError, subprocess.SubprocessError):  # no git here, or not our repository to read
        return package_version()
    return f"{package_version()}+g{found}"


def version_of(name: str) -> str:
    """Return the version of an installed package, ``0+unknown`` of one that is not."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "0+unknown"
