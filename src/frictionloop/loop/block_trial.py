"""The parts of a trial of a block from outside: what its functions are, what they return, and how it is told."""

from __future__ import annotations

import dis
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from pydantic import ValidationError

from frictionloop.quantities import FrictionloopError, must_be, trees
from frictionloop.quantities.arithmetic import is_compiled
from frictionloop.quantities.blame import place, theirs

UNTOLD: Any = object()
"""Result of a trial that says nothing."""


def default(parameters: Any) -> Any:
    """Return parameters as they are if nothing is given, None where something must be given."""
    try:
        return parameters()
    except (FrictionloopError, ValidationError):
        return None


def tried(what: str, whose: Any, function: Callable[..., Any], *given: Any) -> Any:
    """Return what a function returns; `UNTOLD` where Python stops and compiled code, or other numbers, would not."""
    try:
        with np.errstate(all="ignore"):
            return function(*given)
    except (ArithmeticError, NotImplementedError):
        return UNTOLD  # division by zero; parts of compiled code that Python cannot call
    except Exception as error:
        if "math domain error" in str(error):
            return UNTOLD
        raise theirs(what, whose, error) from error


def tried_step(what: str, step: Any, *given: Any) -> Any:
    """Return what a step returns in Python, compiled or not: nothing is compiled, and its errors have lines."""
    return tried(what, step, getattr(step, "py_func", step), *given)


def check_shape(what: str, name: str, shape: Any) -> None:
    """Refuse what is not a class of named tuples."""
    if not (isinstance(shape, type) and hasattr(shape, "_fields")):
        raise must_be(f"{what}: {name}", shape, "a NamedTuple class of numbers")


def check_function(what: str, name: str, function: Any, compiled: bool = False) -> None:
    """Refuse what cannot be called, is not compiled where it must be, or raises where nobody can be told."""
    if not callable(function):
        raise must_be(f"{what}: {name}", function, "a function")
    if compiled and not is_compiled(function):
        raise FrictionloopError(f"{what}: {place(function)}: {name} needs @fl.step")
    if is_compiled(function):
        code = function.py_func.__code__
        raised = [each.offset for each in dis.get_instructions(code) if each.opname == "RAISE_VARARGS"]
        if raised:
            line = next(line for start, end, line in code.co_lines() if start <= raised[0] < end)
            raise FrictionloopError(f"{what}: {code.co_filename}, line {line}: compiled code cannot raise")


def check_returned(what: str, name: str, function: Any, value: Any, shape: Any) -> None:
    """Refuse a value that is not a number (``shape`` float) or a named tuple of numbers of this shape."""
    if value is not UNTOLD and not _is(value, shape):
        wanted = "a number" if shape is float else f"{shape.__name__} with numbers"
        shown = "nothing" if value is None else f"{value!r:.80}"
        raise FrictionloopError(f"{what}: {place(function)}: {name} returned {shown}; must return {wanted}")


def _is(value: Any, shape: Any) -> bool:
    if shape in (float, None):
        return isinstance(value, (int, float, np.number, np.bool_)) and not math.isnan(value)
    if not isinstance(value, tuple) or len(value) != len(shape._fields):
        return False
    return all(_is(each, inner) for each, (_, inner) in zip(value, trees.parts(shape), strict=True))
