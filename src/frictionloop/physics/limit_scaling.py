"""What scales the friction limit of a finger: load, speed, moisture under the finger, and place.

    F_max = f0 (N/N0)^n ((v^2 + vs^2)/(v0^2 + vs^2))^(p/2) (1 + (M - 1) w) (1 + n(x)) 2^(-y^2 (1 - l w))

w in [0, 1] is how far occlusion has come since landing, y = a / halving_amplitude_um as in physics/friction.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.parameters.plant import FingerFriction
from frictionloop.quantities.compile_cache import keep_compiled
from frictionloop.quantities.scalar_math import exp2, fma, log2, step

LEAST_SHARE = 1e-30
"""Least N/N0 whose logarithm is taken: far below any load, and without load the limit is 0."""


class LimitCoefficients(NamedTuple):
    """Coefficients of `limit_step`."""

    per_reference_load: float
    load_exponent: float
    slow2: float
    """vs^2 in m^2/s^2."""
    per_reference_speed2: float
    """1 / (v0^2 + vs^2)."""
    half_slope: float
    """p / 2."""
    occlusion_gain: float
    """M - 1."""


class OcclusionCoefficients(NamedTuple):
    """e^(-dt/T) in contact and while lifted."""

    decay_contact: float
    decay_lifted: float


@step
def occlusion_step(occluded: float, load_n: float, coefficients: OcclusionCoefficients) -> float:
    """dw/dt = (1 - w)/T in contact, -w/T_dry while lifted (N = 0): exact over a period."""
    decay_contact, decay_lifted = coefficients
    target = 1.0 if load_n > 0.0 else 0.0
    decay = decay_contact if load_n > 0.0 else decay_lifted
    return fma(occluded - target, decay, target)


@step
def limit_step(
    load_n: float, speed_m_s: float, occluded: float, roughness: float, coefficients: LimitCoefficients
) -> float:
    """Factor on f0 from load, speed, occlusion and place; never negative, and exactly 0 without load."""
    per_load, load_exponent, slow2, per_speed2, half_slope, gain = coefficients
    load = load_exponent * log2(max(load_n * per_load, LEAST_SHARE))
    octaves = fma(half_slope, log2(fma(speed_m_s, speed_m_s, slow2) * per_speed2), load)
    factor = exp2(octaves) * fma(gain, occluded, 1.0) * max(1.0 + roughness, 0.0)
    return factor if load_n > 0.0 else 0.0


keep_compiled(limit_step, "limit")


class AgeingCoefficients(NamedTuple):
    """Coefficients of `ageing_step` and `aged_step`."""

    gain: float
    """(r - 1)/log2(1 + 1 s/t1); 0 is no ageing."""
    per_static_s: float
    """1/t1."""
    per_static_m: float
    """1/D."""


@step
def ageing_step(age_s: float, slip_m_s: float, limit_n: float, dt: float, coefficients: AgeingCoefficients) -> float:
    """dA/dt = 1 - |v| A/D (Baumberger and Caroli 2006): age of the contact after dt, by Euler backwards; lifted 0."""
    return (age_s + dt) / fma(abs(slip_m_s) * coefficients.per_static_m, dt, 1.0) if limit_n > 0.0 else 0.0


@step
def aged_step(age_s: float, coefficients: AgeingCoefficients) -> float:
    """1 + (r - 1) ln(1 + A/t1)/ln(1 + 1 s/t1): factor on the limit of a contact of age A."""
    return fma(coefficients.gain, log2(fma(age_s, coefficients.per_static_s, 1.0)), 1.0)


keep_compiled(aged_step, "aged")


def limit_coefficients(friction: FingerFriction) -> LimitCoefficients:
    """Return the coefficients of `limit_step`."""
    slow2 = (1e-3 * friction.slow_mm_s) ** 2
    return LimitCoefficients(
        per_reference_load=1.0 / friction.reference_load_n,
        load_exponent=friction.load_exponent,
        slow2=slow2,
        per_reference_speed2=1.0 / ((1e-3 * friction.reference_speed_mm_s) ** 2 + slow2),
        half_slope=0.5 * friction.speed_slope,
        occlusion_gain=friction.occlusion_ratio - 1.0,
    )


def ageing_coefficients(friction: FingerFriction) -> AgeingCoefficients:
    """Return the coefficients of `ageing_step` and `aged_step`."""
    gain = (friction.static_ratio - 1.0) / math.log2(1.0 + 1.0 / friction.static_s)
    return AgeingCoefficients(gain, 1.0 / friction.static_s, 1e6 / friction.static_um)


def occlusion_coefficients(friction: FingerFriction, dt: float) -> OcclusionCoefficients:
    """Return the coefficients of `occlusion_step` for a control period in s."""
    return OcclusionCoefficients(math.exp(-dt / friction.occlusion_s), math.exp(-dt / friction.drying_s))
