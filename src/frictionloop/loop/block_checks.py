"""A block from outside, checked and tried once as it is registered, so that a mistake is told there."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from frictionloop.control.law import Clamp, ForceCommand, Law
from frictionloop.loop.block_trial import (
    UNTOLD,
    check_function,
    check_returned,
    check_shape,
    default,
    tried,
    tried_step,
)
from frictionloop.loop.kernel.slab import law_rows
from frictionloop.loop.metric import RunMetric, Sample, StreamingMetric
from frictionloop.parameters import Signal
from frictionloop.parameters.block import kind_of
from frictionloop.physics.sources import sampler
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities import FrictionloopError, trees
from frictionloop.quantities.blame import place
from frictionloop.sensing.measurement import Measurement

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
        start = trees.shaped(metric.state, [0.0] * trees.size(metric.state))
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
