"""What the translation of a step makes C of: kinds of numbers, structs, names, and the functions that C lacks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.scalar_math import bits, double, fma

BOOL, INT, REAL, WORD, VOID = "bool", "int64_t", "double", "uint64_t", "void"
NUMBERS = (BOOL, INT, REAL)
"""Kinds of numbers, each wider than the one before."""
RESERVED = frozenset(dir(math)) | {
    "auto", "bool", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "false", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short",
    "signed", "sizeof", "static", "struct", "switch", "true", "typedef", "union", "unsigned", "void", "volatile",
    "while", "abs", "cbrt", "exp2", "fabs", "fdim", "fma", "fmax", "fmin", "ilogb", "j0", "j1", "jn", "llrint",
    "llround", "log2", "logb", "lrint", "lround", "main", "nearbyint", "remquo", "rint", "round", "scalbn", "signbit",
    "signgam", "tgamma", "y0", "y1", "yn", "INFINITY", "NAN", "I",
}  # fmt: skip
"""Names of C, of its math.h too: a name of Python that is one of them gets a mark."""
HELPERS = {
    "least": "static inline double least(double a, double b) { return b < a ? b : a; }",
    "most": "static inline double most(double a, double b) { return b > a ? b : a; }",
    "least_int": "static inline int64_t least_int(int64_t a, int64_t b) { return b < a ? b : a; }",
    "most_int": "static inline int64_t most_int(int64_t a, int64_t b) { return b > a ? b : a; }",
    "bits_of": "static inline int64_t bits_of(double x) { union { double d; int64_t i; } u = {x}; return u.i; }",
    "double_of": "static inline double double_of(int64_t i) { union { int64_t i; double d; } x = {i}; return x.d; }",
    "modulo": "static inline int64_t modulo(int64_t a, int64_t b) { return a % b + (a % b < 0 ? b : 0); }",
    "wrapped": "static inline int64_t wrapped(uint64_t u) { union { uint64_t u; int64_t i; } x = {u}; return x.i; }",
}
"""Functions that C lacks."""
KNOWN: dict[Any, tuple[str, str, int]] = {
    fma: ("fma", REAL, 3), bits: ("bits_of", INT, 1), double: ("double_of", REAL, 1),
    math.sqrt: ("sqrt", REAL, 1), math.fabs: ("fabs", REAL, 1),
    math.floor: ("(int64_t)floor", INT, 1), math.ceil: ("(int64_t)ceil", INT, 1),
    np.floor: ("floor", REAL, 1), np.ceil: ("ceil", REAL, 1), np.sqrt: ("sqrt", REAL, 1), np.abs: ("fabs", REAL, 1),
    math.isnan: ("isnan", BOOL, 1), math.isinf: ("isinf", BOOL, 1), math.isfinite: ("isfinite", BOOL, 1),
    np.int64: ("(int64_t)", INT, 1), np.uint64: ("(uint64_t)", WORD, 1),
    float: ("(double)", REAL, 1), int: ("(int64_t)", INT, 1), bool: ("(bool)", BOOL, 1),
}  # fmt: skip
"""Functions of Python that C has, what each returns, and of how many."""


@dataclass(frozen=True)
class Struct:
    """A tuple's type: its name in C, and name and kind of each part."""

    name: str
    parts: tuple[tuple[str, Kind], ...]

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Pointer:
    """Where numbers lie, or a struct."""

    to: Kind

    def __str__(self) -> str:
        return f"{self.to} *"


Kind = str | Struct | Pointer


@dataclass(frozen=True)
class Value:
    """An expression of C and its kind."""

    code: str
    kind: Kind


def literal(value: float) -> str:
    """Return a double as C, to the last bit."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return repr(value) if math.copysign(1.0, value) > 0 else f"({value!r})"


def identifier(name: str) -> str:
    """Return a name of Python as C may have it."""
    return f"{name}_" if name in RESERVED or name in HELPERS else name


def numbered(name: str) -> Iterator[str]:
    """Yield a name, then with numbers, for the first that nothing has yet."""
    yield name
    yield from (f"{name}_{number}" for number in range(2, 1000))


def bare(code: str) -> str:
    """Return an expression without the brackets around all of it."""
    if not (code.startswith("(") and code.endswith(")")):
        return code
    depth = 0
    for index, sign in enumerate(code):
        depth += (sign == "(") - (sign == ")")
        if depth == 0:
            return code[1:-1] if index == len(code) - 1 else code
    return code


def no_c(said: str) -> FrictionloopError:
    """Return the refusal of what has no C."""
    return FrictionloopError(said, "NO-C")
