"""A step as a function of C, statement by statement."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Sequence
from typing import Any

from frictionloop.firmware.c_expressions import KNOWN_TESTS, Expressions, Within
from frictionloop.firmware.c_types import INT, REAL, VOID, Kind, Pointer, Struct, Value, bare, identifier, no_c


class FunctionInC(Expressions):
    """The C of a function for arguments of these kinds: ``result`` and ``text``."""

    result: Kind | None = None

    def __init__(self, within: Within, function: Any, kinds: Sequence[Kind]) -> None:
        try:
            tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
        except (OSError, TypeError, SyntaxError):
            raise no_c(f"{function!r}: no source") from None
        if not isinstance(tree, ast.FunctionDef) or tree.args.kwarg:
            raise no_c(f"{function.__name__}: no plain function")
        arguments = [each.arg for each in (*tree.args.posonlyargs, *tree.args.args, *tree.args.kwonlyargs)]
        self.rest = tree.args.vararg.arg if tree.args.vararg else ""
        self.beyond = [f"{self.rest}{i}" for i in range(len(kinds) - len(arguments))] if self.rest else []
        arguments += self.beyond
        self.arguments = dict(zip(arguments, kinds, strict=True))
        super().__init__(within, function, dict(self.arguments))
        self.read = {name for name, _ in _names(tree, ast.Load)}
        self.read |= {
            each.target.id
            for each in ast.walk(tree)
            if isinstance(each, ast.AugAssign) and isinstance(each.target, ast.Name)
        }
        self.above = [f"(void){identifier(each)};" for each in arguments if each not in self.read and not self.rest]
        self.declared, self.lines, self.depth = set(arguments), list[str](), 0
        if not self.block(tree.body) and (self.result or not any(isinstance(kind, Pointer) for kind in kinds)):
            self.refuse(tree.body[-1], "may end without a value")

    def text(self, name: str) -> str:
        """Return the function, below the first line of what it says of itself."""
        said = (inspect.getdoc(self.function) or "").partition("\n")[0].replace("*/", "* /")
        head = ", ".join(f"{kind} {identifier(each)}" for each, kind in self.arguments.items())
        body = [f"    {line}" for line in [*self.above, *self.lines]]
        return "\n".join(
            [f"/* {said} */"] * bool(said) + [f"static inline {self.result or VOID} {name}({head}) {{", *body, "}\n"]
        )

    def say(self, line: str) -> None:
        """Add a line."""
        self.lines.append("    " * self.depth + line)

    def block(self, body: Sequence[ast.stmt]) -> bool:
        """Translate statements up to one that returns; tell whether one does."""
        return any(self.visit(statement) for statement in body)

    def inner(self, body: Sequence[ast.stmt]) -> bool:
        """Translate statements one level down."""
        self.depth += 1
        returns = self.block(body)
        self.depth -= 1
        return returns

    def visit_Expr(self, node: ast.Expr) -> bool:
        """A docstring, or a call that returns nothing."""
        if isinstance(node.value, ast.Call):
            value: Value = self.visit(node.value)
            if value.kind != VOID:
                self.refuse(node, "leaves out what is returned")
            self.say(f"{value.code};")
        elif not isinstance(node.value, ast.Constant):
            self.refuse(node, "no C")
        return False

    def unpacked(self, node: ast.expr) -> list[Value]:
        """Return an argument, the parts of one that is unpacked, or all that the function has beyond its names."""
        match node:
            case ast.Starred(ast.Name(name)) if self.rest and name == self.rest:
                return [Value(each, self.arguments[each]) for each in self.beyond]
        return super().unpacked(node)

    def visit_Pass(self, _node: ast.Pass) -> bool:
        """Nothing."""
        return False

    def visit_Return(self, node: ast.Return) -> bool:
        """A result; all of a function's are numbers, or one kind of tuple."""
        if node.value is None:
            if not any(isinstance(kind, Pointer) for kind in self.arguments.values()):
                self.refuse(node, "returns nothing")
            self.say("return;")
            return True
        value: Value = self.visit(node.value)
        self.result = value.kind if self.result is None else self.common(self.result, value.kind, node)
        self.say(f"return {bare(value.code)};")
        return True

    def visit_If(self, node: ast.If) -> bool:
        """If and else, or what a known test leaves of them."""
        test = bare(self.number(node.test).code)
        if test in KNOWN_TESTS:
            return self.block(node.body if KNOWN_TESTS[test] else node.orelse)
        self.say(f"if ({test}) {{")
        returns = self.inner(node.body)
        if node.orelse:
            self.say("} else {")
            returns = self.inner(node.orelse) and returns
        self.say("}")
        return bool(node.orelse) and returns

    def visit_For(self, node: ast.For) -> bool:
        """A loop over a range, whose ends are evaluated once."""
        match node:
            case ast.For(ast.Name(name), ast.Call(ast.Name("range"), [*ends], []), body, []) if 1 <= len(ends) <= 2:
                values = [self.number(end) for end in ends]
            case _:
                self.refuse(node, "no loop but over range(n) or range(m, n)")
        if any(each.kind == REAL for each in values):
            self.refuse(node, "range takes whole numbers")
        count, stop, start = self.fresh(), self.fresh(), values[0].code if len(values) == 2 else "0"
        self.say(f"for (int64_t {count} = {start}, {stop} = {values[-1].code}; {count} < {stop}; {count}++) {{")
        self.depth += 1
        self.store(ast.copy_location(ast.Name(name, ast.Store()), node), Value(count, INT))
        self.depth -= 1
        self.inner(body)
        self.say("}")
        return False

    def visit_Assign(self, node: ast.Assign) -> bool:
        """One or several targets."""
        for target in node.targets:
            self.assign(target, node.value)
        return False

    def visit_AnnAssign(self, node: ast.AnnAssign) -> bool:
        """A target with a type, which Numba does not look at either."""
        if node.value is not None:
            self.assign(node.target, node.value)
        return False

    def visit_AugAssign(self, node: ast.AugAssign) -> bool:
        """``x += 1``."""
        before: ast.expr
        match node.target:
            case ast.Name(name):
                before = ast.copy_location(ast.Name(name, ast.Load()), node)
            case ast.Subscript(whole, place):
                before = ast.copy_location(ast.Subscript(whole, place, ast.Load()), node)
            case _:
                self.refuse(node, "no C")
        self.assign(node.target, ast.copy_location(ast.BinOp(before, node.op, node.value), node))
        return False

    def assign(self, target: ast.expr, value: ast.expr) -> None:
        """Assign a value, or values one by one: none is overwritten before it is used."""
        if not (isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)):
            self.store(target, self.visit(value))
            return
        if len(target.elts) != len(value.elts):
            self.refuse(value, f"{len(target.elts)} names for {len(value.elts)} values")
        found = [self.visit(each) for each in value.elts]
        later = [{name for each in value.elts[i + 1 :] for name, _ in _names(each)} for i in range(len(found))]
        if any({name for name, _ in _names(each)} & after for each, after in zip(target.elts, later, strict=True)):
            found = [self.evaluated(each) for each in found]
        for each, part in zip(target.elts, found, strict=True):
            self.store(each, part)

    def store(self, target: ast.expr, value: Value) -> None:
        """Store a value under a name, or its parts under several."""
        if isinstance(target, ast.Tuple):
            parts = value.kind.parts if isinstance(value.kind, Struct) else ()
            if len(parts) != len(target.elts):
                self.refuse(target, "takes apart what has not as many parts")
            whole = value if value.code.isidentifier() else self.evaluated(value)
            for each, (name, kind) in zip(target.elts, parts, strict=True):
                self.store(each, Value(f"{whole.code}.{identifier(name)}", kind))
        elif isinstance(target, ast.Subscript) and isinstance(self.visit(target.value).kind, Pointer):
            self.say(f"{self.visit(target).code} = {bare(value.code)};")
        elif not isinstance(target, ast.Name):
            self.refuse(target, "assigns to")
        elif target.id in self.read:
            before = self.kinds.setdefault(target.id, value.kind)
            if before != value.kind:
                self.refuse(target, f"{before} before and {value.kind} here")
            self.say(f"{self.declaring(target.id, value.kind)}{identifier(target.id)} = {bare(value.code)};")

    def declaring(self, name: str, kind: Kind) -> str:
        """Return what declares a variable: here, or at the top if not all ways of the function come here."""
        new = name not in self.declared
        self.declared.add(name)
        if new and self.depth:
            self.above.append(f"{kind} {identifier(name)} = {{0}};")
        return f"{kind} " if new and not self.depth else ""

    def evaluated(self, value: Value) -> Value:
        """Return a value that is evaluated here, once."""
        name = self.fresh()
        self.say(f"{value.kind} {name} = {bare(value.code)};")
        return Value(name, value.kind)

    def fresh(self) -> str:
        """Return a name that the function has not."""
        number = 1
        while f"part{number}" in self.read | self.declared:
            number += 1
        self.declared.add(f"part{number}")
        return f"part{number}"


def _names(node: ast.AST, context: type = ast.expr_context) -> list[tuple[str, ast.Name]]:
    return [(each.id, each) for each in ast.walk(node) if isinstance(each, ast.Name) and isinstance(each.ctx, context)]
