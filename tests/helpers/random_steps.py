"""Steps drawn at random from all that translates to C."""

from __future__ import annotations

import importlib.util
import random

HEAD = '''"""Drawn."""
import math
import numpy as np
from typing import NamedTuple
from frictionloop.quantities.scalar_math import bits, double, exp2, fma, log2, step

SCALE = 0.75
COUNT = 3


class State(NamedTuple):
    a: float
    b: float


@step
def pair(x, k=2):
    if k > 1:
        return x * 0.5, k + 1
    return -x, k


@step
def near(x):
    return min(max(x, -1e6), 1e6) if not math.isnan(x) else 1.0

'''


class Drawn:
    """One step's expressions: ``real``, ``whole`` and ``truth`` up to a depth."""

    def __init__(self, draw: random.Random) -> None:
        self.draw = draw
        self.reals, self.wholes, self.truths = (
            ["x", "y", "state.a", "state.b", "SCALE", "math.pi"],
            ["k", "COUNT"],
            ["on"],
        )

    def real(self, depth: int) -> str:
        draw, r, w, t = self.draw, self.real, self.whole, self.truth
        if depth <= 0:
            return draw.choice([*self.reals, repr(draw.choice([0.0, 1.0, -2.5, 1e-3, 3.0]))])
        d = depth - 1
        return draw.choice(
            [
                lambda: f"({r(d)} {draw.choice('+-*/')} {r(d)})",
                lambda: f"({r(d)} {draw.choice('+-*/')} {w(d)})",
                lambda: f"({w(d)} / {w(d)})",
                lambda: f"fma({r(d)}, {r(d)}, {r(d)})",
                lambda: f"{draw.choice(['min', 'max'])}({r(d)}, {r(d)}, {r(d)})",
                lambda: f"{draw.choice(['min', 'max'])}({r(d)}, {w(d)})",
                lambda: f"abs({r(d)})",
                lambda: f"math.sqrt(abs({r(d)}))",
                lambda: f"np.floor({r(d)})",
                lambda: f"({r(d)} if {t(d)} else {r(d)})",
                lambda: f"({r(d)} if {t(d)} else {w(d)})",
                lambda: f"float({w(d)})",
                lambda: f"exp2(near({r(d)}), 1e-4)",
                lambda: f"log2(max(abs(near({r(d)})), 1e-3))",
                lambda: f"double(bits(near({r(d)})) ^ (k << {draw.randrange(20)}))",
                lambda: f"-{r(d)}",
                lambda: f"pair({r(d)}, {w(d)})[0]",
                lambda: f"State({r(d)}, {r(d)}).b",
            ]
        )()

    def whole(self, depth: int) -> str:
        draw, r, w, t = self.draw, self.real, self.whole, self.truth
        if depth <= 0:
            return draw.choice([*self.wholes, str(draw.randrange(-9, 9))])
        d = depth - 1
        return draw.choice(
            [
                lambda: f"({w(d)} {draw.choice('+-*&|^')} {w(d)})",
                lambda: f"({w(d)} {draw.choice(['<<', '>>'])} {draw.randrange(64)})",
                lambda: f"int(near({r(d)}))",
                lambda: f"math.{draw.choice(['floor', 'ceil'])}(near({r(d)}))",
                lambda: f"(bits(near({r(d)})) >> 40)",
                lambda: f"({w(d)} if {t(d)} else {w(d)})",
                lambda: f"abs({w(d)})",
                lambda: f"-{w(d)}",
                lambda: f"{draw.choice(['min', 'max'])}({w(d)}, {w(d)})",
                lambda: f"pair({r(d)}, k=k)[1]",
            ]
        )()

    def truth(self, depth: int) -> str:
        draw, r, w, t = self.draw, self.real, self.whole, self.truth
        if depth <= 0:
            return draw.choice([*self.truths, "True"])
        d, sign = depth - 1, lambda: draw.choice(["<", "<=", ">", ">=", "==", "!="])
        return draw.choice(
            [
                lambda: f"({r(d)} {sign()} {r(d)})",
                lambda: f"({w(d)} {sign()} {w(d)} {sign()} {w(d)})",
                lambda: f"({t(d)} {draw.choice(['and', 'or'])} {t(d)})",
                lambda: f"({t(d)} {draw.choice('&|^')} {t(d)})",
                lambda: f"(not {t(d)})",
                lambda: f"math.isfinite({r(d)})",
            ]
        )()


def source(name: str, draw: random.Random) -> str:
    """Return one step: ``(state, x, y, k, on) -> State, number``."""
    drawn, lines = Drawn(draw), []
    for number in range(draw.randrange(2, 5)):
        r, w, n = f"r{number}", f"w{number}", number
        depth = draw.randrange(1, 4)
        lines += draw.choice(
            [
                [f"{r} = {drawn.real(depth)}", f"{w} = {drawn.whole(depth)}"],
                [f"{r}, {w} = pair({drawn.real(1)}, {drawn.whole(1)})", f"{r} += {drawn.real(1)}"],
                [f"{r}, {w} = {drawn.real(depth)}, {drawn.whole(depth)}", f"x, y, {r} = {r}, x, y"],
                [
                    f"{w} = {drawn.whole(1)}",
                    f"if {drawn.truth(2)}:",
                    f"    {r} = {drawn.real(depth)}",
                    f"    {w} -= 1",
                    "else:",
                    f"    {r} = {drawn.real(depth)}",
                ],
                [
                    f"{r} = {drawn.real(1)}",
                    f"{w} = 0",
                    f"for i{n} in range({draw.choice(['COUNT', '4', '1, 5'])}):",
                    f"    {r} = fma({r}, 0.5, {drawn.real(1)})",
                    f"    {w} += i{n}",
                ],
                [f"a{n}, b{n} = state", f"state = State(b{n}, b=a{n})", f"{r} = a{n}", f"{w} = {drawn.whole(1)}"],
            ]
        )
        drawn.reals.append(r)
        drawn.wholes.append(w)
        if draw.random() < 0.5:
            lines.append(f"t{n} = {drawn.truth(depth)}")
            drawn.truths.append(f"t{n}")
    if draw.random() < 0.3:
        lines += [
            f"if {drawn.truth(1)}:",
            f"    return State(1.0 * {drawn.real(1)}, b=1.0 * {drawn.real(1)}), {drawn.real(1)} * 1.0",
        ]
    lines.append(f"return State(1.0 * {drawn.real(2)}, 1.0 * {drawn.real(1)}), 1.0 * {drawn.real(3)}")
    body = "\n".join(f"    {line}" for line in lines)
    return f"@step\ndef {name}(state, x, y, k, on):\n{body}\n\n"


def module_of(folder, seed: int, count: int):
    """Return a module with so many steps in ``STEPS``, written into a folder: their source is read again."""
    draw, names = random.Random(seed), [f"drawn_{seed}_{k}" for k in range(count)]
    path = folder / f"drawn_{seed}.py"
    path.write_text(HEAD + "\n".join(source(name, draw) for name in names) + f"STEPS = [{', '.join(names)}]\n")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
