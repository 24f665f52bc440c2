"""Expressions of a step as C, each with the kind of number or struct that it is."""

from __future__ import annotations

import ast
import builtins
import inspect
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, NoReturn, Protocol

import numpy as np

from frictionloop.firmware.c_types import (
    BOOL,
    HELPERS,
    INT,
    KNOWN,
    NUMBERS,
    REAL,
    WORD,
    Kind,
    Pointer,
    Struct,
    Value,
    bare,
    identifier,
    literal,
    no_c,
)

KNOWN_TESTS = {"true": True, "false": False}
COMPARED: dict[type, str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
ARITHMETIC: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*"}
BITWISE: dict[type, str] = {ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^"}


class Within(Protocol):
    """What a function needs of the translation that it is part of."""

    helpers: set[str]
    own: Mapping[Any, Callable[[Any, ast.Call], Value]]

    def struct(self, shape: type) -> Struct:
        """Return the struct of a named tuple class."""

    def plain(self, kinds: Sequence[Kind]) -> Struct:
        """Return the struct of a tuple without names."""

    def function(self, function: Any, kinds: Sequence[Kind]) -> tuple[str, Kind]:
        """Return name and result of another function."""


class Expressions(ast.NodeVisitor):
    """``visit`` of an expression gives its `Value`; the variables known so far are in ``kinds``."""

    def __init__(self, within: Within, function: Any, kinds: dict[str, Kind]) -> None:
        cells = (cell.cell_contents for cell in function.__closure__ or ())
        self.within, self.function, self.kinds = within, function, kinds
        self.scope = {**function.__globals__, **dict(zip(function.__code__.co_freevars, cells, strict=True))}

    def refuse(self, node: Any, why: str) -> NoReturn:
        """Refuse what has no C."""
        line = self.function.__code__.co_firstlineno + node.lineno - 1
        raise no_c(f"{self.function.__name__}, line {line}: {why}: {ast.unparse(node).splitlines()[0][:60]}")

    def generic_visit(self, node: ast.AST) -> NoReturn:
        """Refuse all that has no method here."""
        self.refuse(node, "no C")

    def number(self, node: ast.expr) -> Value:
        """Return an expression that is a number."""
        value: Value = self.visit(node)
        if not isinstance(value.kind, str):
            self.refuse(node, "a tuple where a number belongs")
        return value

    def evaluated(self, value: Value) -> Value:
        """Return a value that is evaluated before the statement, once."""
        raise NotImplementedError

    def unpacked(self, node: ast.expr) -> list[Value]:
        """Return an argument, or the parts of one that is unpacked."""
        if not isinstance(node, ast.Starred):
            return [self.visit(node)]
        value: Value = self.visit(node.value)
        if not isinstance(value.kind, Struct):
            self.refuse(node, "unpacks no tuple")
        whole = value if value.code.isidentifier() else self.evaluated(value)
        return [Value(f"{whole.code}.{identifier(name)}", kind) for name, kind in value.kind.parts]

    def visit_Constant(self, node: ast.Constant) -> Value:
        """A number."""
        return self.constant(node.value, node)

    def visit_Name(self, node: ast.Name) -> Value:
        """A variable, or a constant from outside of the function."""
        kind = self.kinds.get(node.id)
        return Value(identifier(node.id), kind) if kind else self.constant(self.resolved(node), node)

    def visit_Tuple(self, node: ast.Tuple) -> Value:
        """Several values in one."""
        values = [self.visit(part) for part in node.elts]
        return filled(self.within.plain([each.kind for each in values]), [each.code for each in values])

    def visit_IfExp(self, node: ast.IfExp) -> Value:
        """``a if test else b``, or the one that a known test leaves."""
        test = self.number(node.test).code
        if test in KNOWN_TESTS:
            chosen: Value = self.visit(node.body if KNOWN_TESTS[test] else node.orelse)
            return chosen
        left, right = self.visit(node.body), self.visit(node.orelse)
        kind = self.common(left.kind, right.kind, node)
        return Value(f"({test} ? {left.code} : {right.code})", kind)

    def visit_BoolOp(self, node: ast.BoolOp) -> Value:
        """``and``, ``or`` of comparisons: in Python those of numbers are one of the numbers."""
        values, decides = [], "false" if isinstance(node.op, ast.And) else "true"
        for part in node.values:
            values.append(self.number(part))
            if values[-1].kind != BOOL:
                self.refuse(node, "and, or of numbers")
            if values[-1].code == decides:
                return values[-1]
        sign = " && " if isinstance(node.op, ast.And) else " || "
        return Value(f"({sign.join(each.code for each in values)})", BOOL)

    def visit_Compare(self, node: ast.Compare) -> Value:
        """A comparison, or a chain of them."""
        found = [self.number(part) for part in (node.left, *node.comparators)]
        values, kinds = [each.code for each in found], {each.kind for each in found}
        if any(type(op) not in COMPARED for op in node.ops) or (WORD in kinds and len(kinds) > 1):
            self.refuse(node, "no C")
        pairs = [f"({a} {COMPARED[type(op)]} {b})" for a, op, b in zip(values, node.ops, values[1:], strict=False)]
        return Value(pairs[0] if len(pairs) == 1 else f"({' && '.join(pairs)})", BOOL)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> Value:
        """``not`` and minus."""
        value = self.number(node.operand)
        if isinstance(node.op, ast.Not):
            return Value(f"(!{value.code})", BOOL)
        if not isinstance(node.op, ast.USub) or value.kind == WORD:
            self.refuse(node, "no C")
        return Value(f"(-{value.code})", REAL) if value.kind == REAL else self.whole(f"0u - (uint64_t){value.code}")

    def visit_BinOp(self, node: ast.BinOp) -> Value:
        """Arithmetic: whole numbers wrap at 64 bits, a division gives doubles."""
        if isinstance(node.op, ast.Pow | ast.LShift | ast.RShift):
            return self.by_constant(node)
        a, b = self.number(node.left), self.number(node.right)
        kind = self.common(a.kind, b.kind, node)
        if isinstance(node.op, ast.Div):
            over, under = (each.code if each.kind == REAL else f"(double){each.code}" for each in (a, b))
            return Value(f"({over} / {under})", REAL)
        if type(node.op) in BITWISE and kind != REAL and a.kind == b.kind:
            return Value(f"({a.code} {BITWISE[type(node.op)]} {b.code})", kind)
        if isinstance(node.op, ast.Mod) and (a.kind, b.kind) == (INT, INT) and self.is_whole(node.right):
            self.within.helpers.add("modulo")
            return Value(f"modulo({bare(a.code)}, {bare(b.code)})", INT)
        if type(node.op) not in ARITHMETIC:
            self.refuse(node, "no C")
        sign = ARITHMETIC[type(node.op)]
        if kind in (REAL, WORD):
            return Value(f"({a.code} {sign} {b.code})", kind)
        return self.whole(f"(uint64_t){a.code} {sign} (uint64_t){b.code}")

    def is_whole(self, node: ast.expr) -> bool:
        """Tell whether something is a whole number above 0 from outside of the function."""
        found = self.resolved(node) if isinstance(node, ast.Name) and node.id not in self.kinds else None
        return type(found) is int and found > 0

    def by_constant(self, node: ast.BinOp) -> Value:
        """Squares of variables, and shifts of whole numbers."""
        value, by = self.number(node.left), getattr(node.right, "value", None)
        if isinstance(node.op, ast.Pow):
            if by != 2 or value.kind != REAL or not isinstance(node.left, ast.Name):
                self.refuse(node, "no power but the square of a variable")
            return Value(f"({value.code} * {value.code})", REAL)
        if value.kind == WORD and isinstance(node.op, ast.RShift):
            return Value(f"({value.code} >> {self.number(node.right).code})", WORD)
        if value.kind != INT or not isinstance(by, int) or not 0 <= by < 64:
            self.refuse(node, "no shift but of an int by 0 to 63")
        if isinstance(node.op, ast.LShift):
            return self.whole(f"(uint64_t){value.code} << {by}")
        return Value(f"({value.code} >> {by})", INT)

    def visit_Attribute(self, node: ast.Attribute) -> Value:
        """A field, or a constant of a module."""
        root = node.value
        while isinstance(root, ast.Attribute):
            root = root.value
        if isinstance(root, ast.Name) and root.id not in self.kinds:
            return self.constant(self.resolved(node), node)
        return self.part(node, self.visit(node.value), node.attr)

    def visit_Subscript(self, node: ast.Subscript) -> Value:
        """A part of a tuple by its number, or of what lies at an address."""
        value: Value = self.visit(node.value)
        if isinstance(value.kind, Pointer):
            return Value(f"{value.code}[{bare(self.number(node.slice).code)}]", value.kind.to)
        return self.part(node, value, getattr(node.slice, "value", None))

    def part(self, node: ast.expr, value: Value, which: Any) -> Value:
        """Return a part of a tuple by name or number."""
        shape, sign = (value.kind.to, "->") if isinstance(value.kind, Pointer) else (value.kind, ".")
        parts = shape.parts if isinstance(shape, Struct) else ()
        for k, (name, kind) in enumerate(parts):
            if which == name or (which == k and type(which) is int):
                return Value(f"{value.code}{sign}{identifier(name)}", kind)
        self.refuse(node, "no such part")

    def visit_Call(self, node: ast.Call) -> Value:
        """A call."""
        if any(each.arg is None for each in node.keywords):
            self.refuse(node, "no C for arguments that are unpacked")
        called = self.resolved(node.func)
        if isinstance(called, Hashable) and called in self.within.own:
            return self.within.own[called](self, node)
        values = [value for each in node.args for value in self.unpacked(each)]
        named = {str(each.arg): self.visit(each.value) for each in node.keywords}
        if isinstance(called, type) and hasattr(called, "_fields"):
            return self.tuple_of(called, values, named, node)
        python = getattr(called, "py_func", called)
        if inspect.isfunction(python):
            taken = inspect.signature(python).parameters
            defaults = {k: p.default for k, p in taken.items()}
            several = any(each.kind is inspect.Parameter.VAR_POSITIONAL for each in taken.values())
            given = values if several else self.bound(defaults, values, named, node)
            name, kind = self.within.function(called, [each.kind for each in given])
            return Value(f"{name}({', '.join(bare(each.code) for each in given)})", kind)
        return self.known(called, values, node)

    def known(self, called: Any, values: Sequence[Value], node: ast.Call) -> Value:
        """A function that C has too."""
        if node.keywords or not values or any(not isinstance(each.kind, str) for each in values):
            self.refuse(node, "calls what has no C")
        if called in (min, max, abs) and any(each.kind == WORD for each in values):
            self.refuse(node, "calls what has no C")
        if called in (min, max) and len(values) > 1:
            return self.extreme(called, values, node)
        if called is abs:
            return self.absolute(values[0])
        try:
            name, kind, count = KNOWN[called]
        except (KeyError, TypeError):
            self.refuse(node, "calls what has no C")
        if len(values) != count or (called is bool and values[0].kind == REAL):
            self.refuse(node, "arguments do not fit")
        self.within.helpers |= {name} & HELPERS.keys()
        if name.startswith("("):
            return Value(f"({name}({bare(values[0].code)}))", kind)
        if kind == BOOL:  # a macro, which takes the commas of a struct for its own
            return Value(f"{name}(({bare(values[0].code)}))", kind)
        return Value(f"{name}({', '.join(bare(each.code) for each in values)})", kind)

    def tuple_of(self, shape: Any, values: Sequence[Value], named: Mapping[str, Value], node: ast.Call) -> Value:
        """A named tuple."""
        struct = self.within.struct(shape)
        defaults = {name: shape._field_defaults.get(name, inspect.Parameter.empty) for name in shape._fields}
        given = self.bound(defaults, values, named, node)
        for each, (name, kind) in zip(given, struct.parts, strict=True):
            if isinstance(kind, Struct) and each.kind != kind:
                self.refuse(node, f"{name} is no {kind}")
            if not isinstance(kind, Struct) and isinstance(each.kind, Struct):
                self.refuse(node, f"{name} is no number")
        return filled(struct, [each.code for each in given])

    def bound(
        self, defaults: Mapping[str, Any], values: Sequence[Value], named: Mapping[str, Value], node: ast.Call
    ) -> list[Value]:
        """Return one value for each parameter, its default where none is given."""
        found = dict(zip(defaults, values, strict=False)) | dict(named)
        lacking = [
            name for name, default in defaults.items() if name not in found and default is inspect.Parameter.empty
        ]
        if len(values) > len(defaults) or lacking or found.keys() - defaults.keys():
            self.refuse(node, "arguments do not fit")
        return [found[name] if name in found else self.constant(defaults[name], node) for name in defaults]

    def extreme(self, called: Callable[..., Any], values: Sequence[Value], node: ast.expr) -> Value:
        """``min`` and ``max``, argument by argument as Numba does."""
        kind: Kind = values[0].kind
        for each in values[1:]:
            kind = self.common(kind, each.kind, node)
        name = ("least" if called is min else "most") + ("" if kind == REAL else "_int")
        self.within.helpers.add(name)
        code = values[0].code
        for each in values[1:]:
            code = f"{name}({bare(code)}, {bare(each.code)})"
        return Value(code, kind if kind == REAL else INT)

    def absolute(self, value: Value) -> Value:
        """``abs``."""
        if value.kind == REAL:
            return Value(f"fabs({bare(value.code)})", REAL)
        self.within.helpers.add("most_int")
        return Value(f"most_int({value.code}, {self.whole(f'0u - (uint64_t){value.code}').code})", INT)

    def whole(self, code: str) -> Value:
        """Return an unsigned expression as the whole number that it wraps to."""
        self.within.helpers.add("wrapped")
        return Value(f"wrapped({code})", INT)

    def constant(self, value: Any, node: ast.expr) -> Value:
        """Return a number that does not change."""
        if isinstance(value, bool):
            return Value("true" if value else "false", BOOL)
        if isinstance(value, int) and -(2**63) < value < 2**63:
            return Value(f"INT64_C({value})" if value >= 0 else f"(-INT64_C({-value}))", INT)
        if isinstance(value, float):
            return Value(literal(value), REAL)
        if isinstance(value, np.uint64):
            return Value(f"UINT64_C({value})", WORD)
        self.refuse(node, "neither a number nor a variable")

    def common(self, a: Kind, b: Kind, node: Any) -> Kind:
        """Return the kind that holds both."""
        if a == b:
            return a
        if a not in NUMBERS or b not in NUMBERS:
            self.refuse(node, f"{a} or {b}")
        return max(a, b, key=NUMBERS.index)

    def resolved(self, node: ast.expr) -> Any:
        """Return what a name outside of the function stands for."""
        if isinstance(node, ast.Name) and node.id not in self.kinds:
            if node.id in self.scope:
                return self.scope[node.id]
            if hasattr(builtins, node.id):
                return getattr(builtins, node.id)
        if isinstance(node, ast.Attribute):
            whole = self.resolved(node.value)
            if hasattr(whole, node.attr):
                return getattr(whole, node.attr)
        self.refuse(node, "not known here")


def filled(struct: Struct, codes: Sequence[str]) -> Value:
    """Return a struct of these parts."""
    return Value(f"({struct}){{{', '.join(bare(each) for each in codes)}}}", struct)
