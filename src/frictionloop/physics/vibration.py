"""Friction laws: which share of the friction limit is left under ultrasonic vibration of an amplitude."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any, NamedTuple, cast

from frictionloop.parameters.plant import FingerFriction, FrictionLaw
from frictionloop.quantities.class_help import brief
from frictionloop.quantities.compile_cache import keep_compiled
from frictionloop.quantities.scalar_math import exp2, fma, log2, step

LEAST_N = 1e-9
"""Least force whose logarithm is taken: below any that can be asked for."""


@brief
class Vibration(NamedTuple):
    """A friction law: ``step(amplitude_um, occluded, coefficients) -> share``, from 1 at rest down towards 0."""

    kind: str
    """Kind of the parameters that it belongs to."""
    step: Any
    """Share of the limit that is left, falling with the amplitude (um, at least 0); ``occluded`` is the moisture under
    the finger, 0 to 1. Of a law from outside: under the finger of 0.38 um^-2 (`per_finger`)."""
    coefficients: type
    """Named tuple of numbers that the step takes."""
    coefficients_of: Callable[[Any], Any]
    """Friction parameters -> coefficients."""
    inverse: Any = None
    """``inverse(limit_n, wanted_n, occluded, coefficients) -> amplitude_um``; where it is None, it is searched for."""


REFERENCE_PER_UM2: float = FrictionLaw.model_fields["susceptibility_per_um2"].default
"""Susceptibility of the finger for which a law from outside is written (paper, Sec. 2.1)."""


class GaussianCoefficients(NamedTuple):
    """Of equation (1) under a finger that grows moist."""

    halving_um: float
    """sqrt(ln 2 / tau): the amplitude that halves friction."""
    per_halving: float
    moist_loss: float
    """Share of tau that full moisture takes away."""


@step
def vibrated_step(y: float, occluded: float, moist_loss: float) -> float:
    """e^(-tau(t) a^2) = 2^(-y^2 (1 - l w)): what vibration leaves; moisture takes away from its effect."""
    return exp2(-y * fma(-moist_loss, occluded, 1.0), y)


keep_compiled(vibrated_step, "vibrated")


@step
def gaussian_step(amplitude_um: float, occluded: float, coefficients: GaussianCoefficients) -> float:
    """e^(-tau a^2), equation (1), for y = a / halving_um."""
    return vibrated_step(amplitude_um * coefficients.per_halving, occluded, coefficients.moist_loss)


def inverse_of(vibration: Vibration) -> Any:
    """Return ``inverse(limit_n, wanted_n, occluded, most_um, coefficients)``: the law's own, or a bisection."""
    own, remaining = vibration.inverse, vibration.step
    if own is not None:

        @step
        def inverse(limit_n, wanted_n, occluded, most_um, coefficients):  # type: ignore[no-untyped-def]
            return own(limit_n, wanted_n, occluded, coefficients)

        return inverse

    @step
    def bisected(limit_n, wanted_n, occluded, most_um, coefficients):  # type: ignore[no-untyped-def]
        low, high = 0.0, most_um
        for _halving in range(40):  # to a 1e-12th of the range
            middle = 0.5 * (low + high)
            above = limit_n * remaining(middle, occluded, coefficients) > wanted_n
            low, high = (middle if above else low), (high if above else middle)
        return 0.5 * (low + high)

    return bisected


@step
def gaussian_inverse(limit_n: float, wanted_n: float, occluded: float, coefficients: GaussianCoefficients) -> float:
    """sqrt(log2(F_max/f) / (1 - l w)), at least 0, times the halving amplitude: what leaves f."""
    effect = fma(-coefficients.moist_loss, occluded, 1.0)
    octaves = log2(max(limit_n, LEAST_N)) - log2(max(wanted_n, LEAST_N))
    return math.sqrt(max(octaves, 0.0) / effect) * coefficients.halving_um


def gaussian_coefficients(friction: Any) -> GaussianCoefficients:
    """Return the coefficients of `gaussian_step`."""
    unit = float(math.sqrt(math.log(2.0) / friction.susceptibility_per_um2))
    loss = friction.moist_loss if isinstance(friction, FingerFriction) else 0.0
    return GaussianCoefficients(unit, 1.0 / unit, loss)


def per_finger(law: Vibration) -> Vibration:
    """Return a law from outside under fingers of any susceptibility and moisture.

    Its share at ``a`` is that of the reference finger at a sqrt(tau (1 - l w) / 0.38 um^-2): equation (1) and
    `rough_contact` depend on tau in this way; that others do is assumed.
    """
    share, own_inverse = law.step, law.inverse
    fields: list[tuple[str, type]] = [("square", float), ("moist_loss", float), ("own", law.coefficients)]
    felt_coefficients = cast(Any, NamedTuple("Felt", fields))

    @step
    def sensitivity(occluded, given):  # type: ignore[no-untyped-def]
        return math.sqrt(given.square * fma(-given.moist_loss, occluded, 1.0))

    @step
    def felt(amplitude_um, occluded, given):  # type: ignore[no-untyped-def]
        return share(amplitude_um * sensitivity(occluded, given), occluded, given.own)

    @step
    def inverse(limit_n, wanted_n, occluded, given):  # type: ignore[no-untyped-def]
        return own_inverse(limit_n, wanted_n, occluded, given.own) / sensitivity(occluded, given)

    felt.py_func.stands_for = getattr(share, "py_func", share)

    def coefficients_of(friction: Any) -> Any:
        square = friction.susceptibility_per_um2 / REFERENCE_PER_UM2
        return felt_coefficients(square, getattr(friction, "moist_loss", 0.0), law.coefficients_of(friction))

    return law._replace(
        step=felt,
        coefficients=felt_coefficients,
        coefficients_of=coefficients_of,
        inverse=None if own_inverse is None else inverse,
    )


GAUSSIAN = Vibration("gaussian", gaussian_step, GaussianCoefficients, gaussian_coefficients, gaussian_inverse)
VIBRATIONS: dict[str, Vibration] = {"gaussian": GAUSSIAN, "finger": GAUSSIAN}
"""By the kind of ``friction``; a law that stands in the file of its parameters is added when it is used."""


def vibration_of(friction: Any) -> Vibration:
    """Return the friction law that friction parameters are for."""
    if friction.kind not in VIBRATIONS:
        VIBRATIONS[friction.kind] = sys.modules[type(friction).__module__].VIBRATION
    return VIBRATIONS[friction.kind]
