"""Expressions of a step as C, each with the kind of number or struct that it is."""

from __future__ import annotations

import ast
import builtins
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn, Protocol

from frictionloop.firmware.c_source import (
    BOOL,
    HELPERS,
    INT,
    KNOWN,
    NUMBERS,
    REAL,
    Kind,
    Struct,
    Value,
    bare,
    identifier,
    literal,
    no_c,
)

COMPARED: dict[type, str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
ARITHMETIC: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*"}
BITWISE: dict[type, str] = {ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^"}


class Within(Protocol):
    """What a function needs of the translation that it is part of."""

    helpers: set[str]

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
        if isinstance(value.kind, Struct):
            self.refuse(node, "a tuple where a number belongs")
        return value

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
        """``a if test else b``."""
        left, right = self.visit(node.body), self.visit(node.orelse)
        kind = self.common(left.kind, right.kind, node)
        return Value(f"({self.number(node.test).code} ? {left.code} : {right.code})", kind)

    def visit_BoolOp(self, node: ast.BoolOp) -> Value:
        """``and``, ``or`` of comparisons: in Python those of numbers are one of the numbers."""
        values = [self.number(part) for part in node.values]
        if any(each.kind != BOOL for each in values):
            self.refuse(node, "and, or of numbers")
        sign = " && " if isinstance(node.op, ast.And) else " || "
        return Value(f"({sign.join(each.code for each in values)})", BOOL)

    def visit_Compare(self, node: ast.Compare) -> Value:
        """A comparison, or a chain of them."""
        values = [self.number(part).code for part in (node.left, *node.comparators)]
        if any(type(op) not in COMPARED for op in node.ops):
            self.refuse(node, "no C")
        pairs = [f"({a} {COMPARED[type(op)]} {b})" for a, op, b in zip(values, node.ops, values[1:], strict=False)]
        return Value(pairs[0] if len(pairs) == 1 else f"({' && '.join(pairs)})", BOOL)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> Value:
        """``not`` and minus."""
        value = self.number(node.operand)
        if isinstance(node.op, ast.Not):
            return Value(f"(!{value.code})", BOOL)
        if not isinstance(node.op, ast.USub):
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
        if type(node.op) not in ARITHMETIC:
            self.refuse(node, "no C")
        sign = ARITHMETIC[type(node.op)]
        if kind == REAL:
            return Value(f"({a.code} {sign} {b.code})", REAL)
        return self.whole(f"(uint64_t){a.code} {sign} (uint64_t){b.code}")

    def by_constant(self, node: ast.BinOp) -> Value:
        """Squares of variables, and shifts of whole numbers."""
        value, by = self.number(node.left), getattr(node.right, "value", None)
        if isinstance(node.op, ast.Pow):
            if by != 2 or value.kind != REAL or not isinstance(node.left, ast.Name):
                self.refuse(node, "no power but the square of a variable")
            return Value(f"({value.code} * {value.code})", REAL)
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
        return self.part(node, node.value, node.attr)

    def visit_Subscript(self, node: ast.Subscript) -> Value:
        """A part of a tuple by its number."""
        return self.part(node, node.value, getattr(node.slice, "value", None))

    def part(self, node: ast.expr, whole: ast.expr, which: Any) -> Value:
        """Return a part of a tuple by name or number."""
        value: Value = self.visit(whole)
        parts = value.kind.parts if isinstance(value.kind, Struct) else ()
        for k, (name, kind) in enumerate(parts):
            if which == name or (which == k and type(which) is int):
                return Value(f"{value.code}.{identifier(name)}", kind)
        self.refuse(node, "no such part")

    def visit_Call(self, node: ast.Call) -> Value:
        """A call."""
        if any(isinstance(each, ast.Starred) for each in node.args) or any(each.arg is None for each in node.keywords):
            self.refuse(node, "no C for arguments that are unpacked")
        called = self.resolved(node.func)
        values = [self.visit(each) for each in node.args]
        named = {str(each.arg): self.visit(each.value) for each in node.keywords}
        if isinstance(called, type) and hasattr(called, "_fields"):
            return self.tuple_of(called, values, named, node)
        python = getattr(called, "py_func", called)
        if inspect.isfunction(python):
            defaults = {k: p.default for k, p in inspect.signature(python).parameters.items()}
            given = self.bound(defaults, values, named, node)
            name, kind = self.within.function(called, [each.kind for each in given])
            return Value(f"{name}({', '.join(bare(each.code) for each in given)})", kind)
        return self.known(called, values, node)

    def known(self, called: Any, values: Sequence[Value], node: ast.Call) -> Value:
        """A function that C has too."""
        if node.keywords or not values or any(isinstance(each.kind, Struct) for each in values):
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
        self.refuse(node, "neither a number nor a variable")

    def common(self, a: Kind, b: Kind, node: Any) -> Kind:
        """Return the kind that holds both."""
        if a == b:
            return a
        if isinstance(a, Struct) or isinstance(b, Struct):
            self.refuse(node, f"{a} or {b}")
        return NUMBERS[max(NUMBERS.index(a), NUMBERS.index(b))]

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
