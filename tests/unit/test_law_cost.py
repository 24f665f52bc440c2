"""Operations that laws say they take, against their own Python functions run on numbers that count."""

from __future__ import annotations

import importlib
import math
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.cost import BUDGET_CYCLES, CYCLES_M4, cycles_m4
from frictionloop.control.law import Operations
from frictionloop.control.laws import LAWS
from frictionloop.quantities import biquad
from frictionloop.sensing.measurement import Measurement

DOCS = Path(__file__).parents[2] / "docs"
MODULES = (
    "control.expected", "control.filtered_pi", "control.force_observer", "control.disturbance_observer",
    "control.limit_observer", "control.open_loop", "control.overdrive", "control.pi", "control.super_twisting",
    "control.tracker", "quantities.biquad",
)  # fmt: skip
FEED_FORWARD = {
    "controller.feedforward": True, "controller.overdrive": True,
    "controller.sections": ((0.4, 0.2, 0.1, -0.3, 0.1),) * 6,
}  # fmt: skip
COUNTS: Counter[str] = Counter()


def counting(kind, of):
    def operate(*values):
        COUNTS[kind] += 1
        found = of(*map(float, values))
        return found if isinstance(found, bool) else Counted(found)

    return operate


class Counted(float):
    """A number that counts what is done to it."""

    def __neg__(self):
        return Counted(-float(self))

    def __abs__(self):
        COUNTS["comparisons"] += 1
        return Counted(abs(float(self)))


for name, kind in (
    ("mul", "multiplications"), ("rmul", "multiplications"), ("add", "additions"), ("radd", "additions"),
    ("sub", "additions"), ("rsub", "additions"), ("truediv", "divisions"), ("rtruediv", "divisions"),
):  # fmt: skip
    setattr(Counted, f"__{name}__", counting(kind, getattr(float, f"__{name}__")))
for name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Counted, f"__{name}__", counting("comparisons", getattr(float, f"__{name}__")))


def counted_fma(a, b, c):
    COUNTS.update(multiplications=1, additions=1)
    return Counted(float(a) * float(b) + float(c))


STUBS = {
    "fma": counted_fma,
    "exp2": counting("exponentials", lambda x: 2.0**x),
    "log2": counting("logarithms", math.log2),
    "math": SimpleNamespace(sqrt=counting("roots", math.sqrt)),
}


def operations_of(law, monkeypatch, changes):
    """Run the step's Python function, and those of its helpers, for some ticks: the most of each operation."""
    controller = fl.bench().evolve({"controller.kind": law.kind, **changes}).controller
    gains = (*law.gains_of(controller), controller.model.floor_n, controller.model.nominal_n)
    state = tuple(law.start_of(controller)) if law.start_of else (0.0,) * law.states
    for name in MODULES:
        module = importlib.import_module(f"frictionloop.{name}")
        for key, value in list(vars(module).items()):
            if key in STUBS:
                monkeypatch.setattr(module, key, STUBS[key])
            elif hasattr(value, "py_func"):
                monkeypatch.setattr(module, key, value.py_func)
    rng, found = np.random.default_rng(1), []
    for _ in range(30):
        y, v, n = rng.uniform(0.2, 1.0), rng.uniform(-0.05, 0.05), rng.uniform(0.2, 0.8)
        COUNTS.clear()
        seen = Measurement(*map(Counted, (y, 0.0, v, n, float(rng.integers(2)))))
        counted = tuple(map(Counted, gains))
        state, _ = law.step.py_func(tuple(map(Counted, state)), seen, Counted(0.6), counted, Counted(2e-4))
        found.append(Operations(**COUNTS))
    return Operations(*(max(each) for each in zip(*found, strict=True)))


CHANGES = {
    "filtered_pi": FEED_FORWARD, "observer": {"controller.overdrive": True},
    "super_twisting": {"controller.overdrive": True}
}  # fmt: skip


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_a_law_takes_the_operations_it_says(law, monkeypatch):
    """The lookup is not in the step; the tracker inverts the limit itself."""
    counted = operations_of(law, monkeypatch, CHANGES.get(law.kind, {}))
    assert law.operations == counted._replace(lookups=0 if law.kind == "tracker" else 1)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_texts_say_what_is_counted(law):
    """The page that says what a law costs, and the docstring of a step that says it in numbers of its own."""
    counts = [(name, count) for name, count in law.operations._asdict().items() if count and name != "lookups"]
    said = ", ".join(f"{count} {name[:-1] if count == 1 else name}" for name, count in counts)
    if law.kind != "tracker":  # its page speaks of no operations
        assert said in " ".join((DOCS / "controllers.md").read_text(encoding="utf-8").split())
    if law.kind in ("pi", "filtered_pi", "lookup"):
        assert said in " ".join(law.step.py_func.__doc__.split())


def test_a_section_takes_five_multiplications_and_four_additions(monkeypatch):
    """And a held one 1 and 1 more, that foresee the command."""
    monkeypatch.setattr(biquad, "fma", counted_fma)
    COUNTS.clear()
    biquad.biquad_step.py_func(*map(Counted, (0.1, 0.2, 0.3, 0.4, 0.2, 0.1, -0.3, 0.1)))
    assert dict(COUNTS) == {"multiplications": 5, "additions": 4}


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_cycles_add_up_and_fit_the_budget(law):
    """The sum by the names of the operations; budgets: a quarter of a tick for most, half a tick for the best law."""
    given, costs = law.operations._asdict(), CYCLES_M4._asdict()
    assert cycles_m4(law.operations) == sum(costs[name] * count for name, count in given.items())
    assert cycles_m4(law.operations) <= BUDGET_CYCLES // (2 if law.kind == "tracker" else 4)


def test_one_of_each():
    """4 + 2 + 3 + 30 + 60 + 45 + 45 + 115; a tick lasts 72 MHz / 5 kHz cycles."""
    assert cycles_m4(Operations(*[1] * 8)) == 304
    assert BUDGET_CYCLES == 72e6 / 5e3
