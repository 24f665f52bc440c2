"""What a function computes, as a digest: its code and all that the code refers to, but no comment or docstring."""

from __future__ import annotations

import dataclasses
import hashlib
import sys
from opcode import opmap
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
