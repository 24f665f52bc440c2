"""A friction law of rough contact: what asperities carry falls exponentially with the gap that vibration opens."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from frictionloop.parameters.plant import FingerFriction
from frictionloop.physics.vibration import LEAST_N, Vibration
from frictionloop.quantities.scalar_math import exp2, log2, step


class RoughContactFriction(FingerFriction):
    """Limit of a finger on a rough contact: e^(-sqrt(tau) a) of it is left, where equation (1) has e^(-tau a^2).

    Asperities of exponentially distributed heights carry a load that falls as e^(-u/s) with the gap u (Greenwood and
    Williamson 1966); that the gap opens in proportion to the amplitude is assumed. Both laws leave 1/e at the amplitude
    1/sqrt(tau).
    """

    kind: Literal["rough_contact"] = "rough_contact"  # type: ignore[assignment]


class RoughContactCoefficients(NamedTuple):
    """Of e^(-sqrt(tau (1 - l w)) a) = 2^(-sqrt(1 - l w) a/h)."""

    per_halving: float
    """1/h, 1/um: h is the amplitude that halves friction where it is dry."""
    moist_loss: float
    """Share l of tau that full moisture takes away."""


@step
def rough_contact_step(amplitude_um: float, occluded: float, coefficients: RoughContactCoefficients) -> float:
    """Return the share of friction that is left."""
    effect = math.sqrt(1.0 - coefficients.moist_loss * occluded)
    return exp2(-amplitude_um * coefficients.per_halving, effect)


@step
def rough_contact_inverse(
    limit_n: float, wanted_n: float, occluded: float, coefficients: RoughContactCoefficients
) -> float:
    """Return the amplitude in um that leaves a force, at least 0."""
    octaves = log2(max(limit_n, LEAST_N)) - log2(max(wanted_n, LEAST_N))
    effect = math.sqrt(1.0 - coefficients.moist_loss * occluded)
    return max(octaves, 0.0) / (coefficients.per_halving * effect)


def rough_contact_coefficients(friction: RoughContactFriction) -> RoughContactCoefficients:
    """Return the coefficients of `rough_contact_step`."""
    per_halving = math.sqrt(friction.susceptibility_per_um2) / math.log(2.0)
    return RoughContactCoefficients(per_halving, friction.moist_loss)


VIBRATION = Vibration(
    "rough_contact",
    rough_contact_step,
    RoughContactCoefficients,
    rough_contact_coefficients,
    rough_contact_inverse,
)
