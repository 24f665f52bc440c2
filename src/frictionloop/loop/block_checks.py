"""A block from outside, checked and tried once as it is registered, so that a mistake is told there."""

from __future__ import annotations

import dis
import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from pydantic import ValidationError

from frictionloop.control.law import Clamp, ForceCommand, Law
from frictionloop.loop.kernel.slab import law_rows
from frictionloop.loop.metric import RunMetric, Sample, StreamingMetric
from frictionloop.parameters import Signal
from frictionloop.parameters.block import kind_of
from frictionloop.physics.signal_values import sampler
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities import FrictionloopError, flat_tuples, must_be
from frictionloop.quantities.outside_errors import place, theirs
from frictionloop.quantities.scalar_math import is_compiled
from frictionloop.sensing.measurement import Measurement

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
    return all(_is(each, inner) for each, (_, inner) in zip(value, flat_tuples.parts(shape), strict=True))


MEASURED = Measurement(0.5, 0.01, 0.02, 0.5, 1.0)
SAMPLE = Sample(0.6, 0.5, 0.5, 0.6, 1.0, 0.1, 0.0, 0.01, 0.02, 0.5, 0.8, 0.1, 1.0, 1.0, 1.0)
SETPOINT_N, RATE_HZ, AMPLITUDES_UM = 0.6, 5000.0, (0.0, 0.5, 1.0, 1.5, 2.0, 2.5)
"""What a block is tried with: numbers as they occur in a run."""


def check_law(law: Law, parameters: Any) -> None:
    """Refuse a law that cannot run: its shapes, the names of its gains, and what its functions return."""
    what = f'law "{law.kind}"'
    check_shape(what, "state", law.state)
    check_shape(what, "gains", law.gains)
    fields: tuple[str, ...] = law.gains._fields  # type: ignore[attr-defined]
    if fields[-2:] != Clamp._fields:
        raise FrictionloopError(f"{what}: gains {', '.join(fields)} must end with low, high")
    law_rows(law)
    check_function(what, "step", law.step)
    if law.begin is not None:
        check_function(what, "begin", law.begin, compiled=True)
    for name in fields[:-2] if law.gains_of is None else ():
        if name not in parameters.model_fields and not hasattr(parameters, name):
            known = ", ".join(parameters.model_fields)
            raise FrictionloopError(f"{what}: gain {name!r}: accepted {known}, or gains_of")
    controller = default(parameters)
    if controller is not None:
        _try_law(what, law, controller)


def _try_law(what: str, law: Law, controller: Any) -> None:
    gains = tried(what, law.gains_of or law.gains, law.gains_for, controller)
    check_returned(what, "gains_of", law.gains_of, gains, law.gains)
    start = tried(what, law.start_of or law.state, law.start_for, controller)
    check_returned(what, "start_of", law.start_of, start, law.state)
    told = tried_step(what, law.step, start, MEASURED, SETPOINT_N, gains, 1.0 / RATE_HZ)
    if told is not UNTOLD:
        if not isinstance(told, tuple) or len(told) != 2:
            shown = "nothing" if told is None else f"{told!r:.80}"
            wanted = "state, fl.ForceCommand(u, saturated)"
            raise FrictionloopError(f"{what}: {place(law.step)}: step returned {shown}; must return {wanted}")
        check_returned(what, "step, as its state,", law.step, told[0], law.state)
        check_returned(what, "step, as its command,", law.step, told[1], ForceCommand)
    if law.begin is not None:
        told = tried_step(what, law.begin, start, SETPOINT_N, SETPOINT_N, gains)
        check_returned(what, "begin", law.begin, told, law.state)


def check_vibration(law: Vibration, parameters: Any) -> None:
    """Refuse a friction law that cannot run, or whose share does not fall from 1."""
    what = f'friction law "{law.kind}"'
    check_shape(what, "coefficients", law.coefficients)
    check_function(what, "step", law.step, compiled=True)
    check_function(what, "coefficients_of", law.coefficients_of)
    if law.inverse is not None:
        check_function(what, "inverse", law.inverse, compiled=True)
    friction = default(parameters)
    if friction is None:
        return
    given = tried(what, law.coefficients_of, law.coefficients_of, friction)
    check_returned(what, "coefficients_of", law.coefficients_of, given, law.coefficients)
    for occluded in (0.0, 1.0):
        _try_shares(what, law, given, occluded)


def _try_shares(what: str, law: Vibration, given: Any, occluded: float) -> None:
    shares = [tried_step(what, law.step, a, occluded, given) for a in AMPLITUDES_UM]
    if UNTOLD in shares:
        # Where Python stops at the root of a negative number, compiled code goes on.
        shares = [tried(what, law.step, law.step, a, occluded, given) for a in AMPLITUDES_UM]
    for share in shares:
        check_returned(what, "step", law.step, share, float)
    told = UNTOLD not in shares
    if told and not (abs(shares[0] - 1) < 1e-6 and all(0 <= b <= a for a, b in pairwise(shares))):
        found = ", ".join(f"{share:g} at {a:g} um" for a, share in zip(AMPLITUDES_UM, shares, strict=True))
        raise FrictionloopError(f"{what}: {place(law.step)}: step returned {found}; must fall from 1")


def check_metric(metric: StreamingMetric | RunMetric) -> None:
    """Refuse a metric that cannot run."""
    what = f'metric "{metric.name}"'
    if not str(metric.name).isidentifier():
        raise FrictionloopError(f"{what}: accepted letters, digits, _")
    check_function(what, "of", metric.of)
    if isinstance(metric, StreamingMetric):
        check_shape(what, "state", metric.state)
        check_function(what, "step", metric.step, compiled=True)
        start = flat_tuples.shaped(metric.state, [0.0] * flat_tuples.size(metric.state))
        told = tried_step(what, metric.step, start, SAMPLE, 1.0 / RATE_HZ)
        check_returned(what, "step", metric.step, told, metric.state)


def check_signal(signal: type[Signal]) -> None:
    """Refuse a signal without a function, or whose function does not return a force for each time."""
    if signal.force_n is Signal.force_n:
        raise FrictionloopError(f'signal "{kind_of(signal)}": {signal.__name__} needs force_n(self, time_s)')
    source = default(signal)
    take = None if source is None else sampler(source, RATE_HZ, 0, 0)
    if take is not None:
        take(0, 2)
