"""Scalar steps as C99: straight-line functions of numbers and named tuples, each specialised on its arguments' types.

What Numba compiles for the simulator is translated here for boards and pages, line by line, with the same names. Both
give the same bits in double (tests/firmware/test_translation). What has no C is refused by function, line and text.

=====================  ================================================================
Python                 C
=====================  ================================================================
bool, int, float       ``bool``, ``int64_t`` (wraps), ``double``
named tuple, tuple     ``struct``, passed by value; a call that returns one is evaluated once
``min``, ``max``       the later one only if it is less, or greater: as Numba with NaN
``*given``             its parts; an address of numbers is indexed, one of a struct has fields
``if`` of a constant   the part that it leaves
``math.floor``         ``int64_t``, as Numba's; ``np.floor`` a double
``x ** 2``             ``x * x``; no other power
``fma``                ``fma``, rounded once; nothing else is contracted
=====================  ================================================================
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from frictionloop.firmware.c_functions import FunctionInC
from frictionloop.firmware.c_types import HELPERS, INT, REAL, VOID, Kind, Struct, Value, identifier, no_c, numbered
from frictionloop.quantities import flat_tuples

INCLUDES = "#include <math.h>\n#include <stdbool.h>\n#include <stdint.h>\n\n"
"""What the text of a translation needs above it."""


@dataclass
class Translation:
    """C of functions, with the structs and helpers they need, in the order in which C wants them."""

    structs: dict[Any, Struct] = field(default_factory=dict)
    functions: list[str] = field(default_factory=list)
    helpers: set[str] = field(default_factory=set)
    own: Mapping[Any, Callable[[Any, ast.Call], Value]] = field(default_factory=dict)
    """Calls that have a C of their own."""
    _named: dict[Any, tuple[str, Kind] | None] = field(default_factory=dict)
    _taken: set[str] = field(default_factory=set)

    def struct(self, shape: type) -> Struct:
        """Return the struct of a named tuple class, its numbers all doubles."""
        if shape not in self.structs:
            inner = flat_tuples.parts(shape)
            parts = tuple((name, REAL if each is None else self.struct(each)) for name, each in inner)
            self.structs[shape] = Struct(self._free(shape.__name__), parts)
        return self.structs[shape]

    def plain(self, kinds: Sequence[Kind]) -> Struct:
        """Return the struct of a tuple without names."""
        key = tuple(kinds)
        if key not in self.structs:
            whole = "tuple_" + "_".join("int" if kind == INT else str(kind) for kind in kinds)
            self.structs[key] = Struct(self._free(whole), tuple((f"of{i}", kind) for i, kind in enumerate(kinds)))
        return self.structs[key]

    def function(self, function: Any, kinds: Sequence[Kind]) -> tuple[str, Kind]:
        """Return name and result of a function for arguments of these kinds, translated at its first call.

        Raises
        ------
        FrictionloopError
            For what has no C: NO-C, with function, line and text.
        """
        python = getattr(function, "py_func", function)
        key = python, tuple(kinds)
        if key not in self._named:
            name = self._free(identifier(python.__name__))
            self._named[key] = None
            body = FunctionInC(self, python, kinds)
            self.functions.append(body.text(name))
            self._named[key] = name, body.result or VOID
        found = self._named[key]
        if found is None:
            raise no_c(f"{python.__name__}: calls itself")
        return found

    def _free(self, name: str) -> str:
        free = next(each for each in numbered(name) if each not in self._taken)
        self._taken.add(free)
        return free

    def text(self) -> str:
        """Return all of it, without includes."""
        structs = []
        for each in self.structs.values():
            fields = "".join(f"    {kind} {identifier(name)};\n" for name, kind in each.parts)
            structs.append(f"typedef struct {{\n{fields}}} {each};\n")
        helpers = [each + "\n" for name, each in HELPERS.items() if name in self.helpers]
        return "\n".join(["".join(helpers), *structs, *self.functions])
