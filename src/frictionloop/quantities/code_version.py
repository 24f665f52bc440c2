"""Which code this is: its version, and digests of what decides a result."""

from __future__ import annotations

import dataclasses
import hashlib
import subprocess
import sys
from collections.abc import Iterable
from functools import cache
from importlib.machinery import SourceFileLoader
from importlib.metadata import PackageNotFoundError, version
from inspect import CO_OPTIMIZED
from opcode import opmap
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

EXTENDED_ARG, LOAD_GLOBAL = opmap["EXTENDED_ARG"], opmap["LOAD_GLOBAL"]


def code_digest(*things: Any) -> str:
    """Return a digest of functions and values, equal in every process for the same code.

    A function counts by its byte code, its constants and defaults, how it is compiled, and in the same way by every
    function, number and named tuple that it takes from its closure or its module. So a change elsewhere in a file
    changes nothing.
    """
    walk = _Walk()
    walk.update(sys.version)
    for thing in things:
        walk.add(thing)
    return walk.digest.hexdigest()[:20]


class _Walk:
    """One pass over what is reachable; what was met before counts by its place."""

    def __init__(self) -> None:
        self.digest, self.met = hashlib.sha256(), {}  # type: ignore[var-annotated]

    def update(self, text: str) -> None:
        self.digest.update(text.encode() + b"\0")

    def add(self, thing: Any) -> None:
        """Add a value by what it is."""
        if isinstance(thing, (int, float, complex, str, bytes, type(None), type(Ellipsis))):
            self.update(f"{type(thing).__name__} {thing!r}")
            return
        if id(thing) in self.met:
            self.update(f"met {self.met[id(thing)][0]}")
            return
        self.met[id(thing)] = len(self.met), thing  # kept alive, so that no other thing gets its id
        inner = getattr(thing, "py_func", None) or getattr(thing, "_defn", None)
        if inner is not None:
            self.update(f"compiled {sorted(getattr(thing, 'targetoptions', {}).items())}")
            self.add(inner)
        elif isinstance(thing, FunctionType):
            self._function(thing)
        elif isinstance(thing, (tuple, list, frozenset)):
            self.add(type(thing))  # of a named tuple also the order of its fields
            for each in sorted(thing, key=repr) if isinstance(thing, frozenset) else thing:
                self.add(each)
        elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
            self.update(f"record {type(thing).__name__}")
            for field in dataclasses.fields(thing):
                self.add(getattr(thing, field.name))
        elif isinstance(thing, type):
            fields = getattr(thing, "_fields", ""), getattr(thing, "_field_defaults", "")
            self.update(f"class {thing.__name__} {fields}")
        elif isinstance(thing, ModuleType):
            self.update(f"module {thing.__name__}")
        elif isinstance(thing, BuiltinFunctionType):
            self.update(f"built-in {thing.__module__}.{thing.__name__}")
        else:
            self.update(f"value {type(thing).__qualname__} {_text(thing)}")

    def _function(self, function: FunctionType) -> None:
        self._code(function.__code__, function)
        self.add(function.__defaults__)
        for cell in function.__closure__ or ():
            self.add(cell.cell_contents)

    def _code(self, code: CodeType, function: FunctionType) -> None:
        self.update(f"code {code.co_code.hex()} {code.co_names} {code.co_varnames}")
        for each in code.co_consts:
            if isinstance(each, CodeType):
                self._code(each, function)
            elif each is not function.__doc__:
                self.add(each)
        space = function.__globals__
        self._named({name: space[name] for name in _globals(code) if name in space}, code.co_names)

    def _named(self, space: dict[str, Any], names: tuple[str, ...], within: tuple[ModuleType, ...] = ()) -> None:
        """Add what names stand for; of a module also what is compiled, a number or a module under one of them."""
        for name in names:
            if name in space:
                thing = space[name]
                self.add(thing)
                if isinstance(thing, ModuleType) and thing not in within:
                    own = vars(thing)
                    self._named({each: own[each] for each in names if _counts(own.get(each))}, names, (*within, thing))


def _globals(code: CodeType) -> tuple[str, ...]:
    """Return the names that code takes from its module, without those of fields: ``gains.kp`` is no global ``kp``."""
    operations, numbers = code.co_code[::2], code.co_code[1::2]
    if EXTENDED_ARG in operations:  # more names than one byte can count, or long jumps: all that may be meant
        return code.co_names
    return tuple(code.co_names[k >> 1] for each, k in zip(operations, numbers, strict=True) if each == LOAD_GLOBAL)


def _counts(thing: Any) -> bool:
    """Tell what compiled code takes from a module: other functions are the library's own, known by their names."""
    return hasattr(thing, "py_func") or isinstance(thing, (int, float, complex, tuple, ModuleType))


def _text(thing: Any) -> str:
    """Return what tells a value from others of its type, and is the same in every process."""
    if hasattr(thing, "tobytes"):
        return f"{getattr(thing, 'dtype', '')} {getattr(thing, 'shape', '')} {thing.tobytes().hex()}"
    text = repr(thing)
    return "" if " at 0x" in text else text


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
