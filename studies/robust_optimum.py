"""The least residual of any linear controller that also keeps the peak of |S| on other plants, bounded from below.

Other plants are the reading's response times a ratio r: a resonance that is off, a finger of another gain. With S that
of the own plant theirs is S/(r + (1 - r) S), so |S_r| <= M says

    |S|^2 - M^2 |r + (1 - r) S|^2 <= 0,

at each frequency the inside of a disc for S or, where |1 - r| M > 1, its outside: around the resonance the problem is
not convex. An augmented Lagrangian (Hestenes; Powell, 1969) finds a controller and multipliers; for any multipliers of
0 or more Lagrange's dual, one problem of Wiener and Hopf, is below what any controller that keeps the peaks leaves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from frictionloop.analysis.state_space import Array, Complex
from studies.wiener_hopf import Spectra, causal_factor, least_power, squared

ROUNDS, STEPS = 10, 100
"""Updates of the multipliers at most, and steps of each descent between them."""
PENALTY = 0.3
"""First weight of a peak that is not kept, over the mean density of the disturbance; it doubles each round."""
CLOSE = 2e-3
"""Gap between controller and bound, and excess over the peaks, at which it ends, relative."""
HALVINGS = 5
"""Steps of the search for the price of the command."""
LEAST_LEFT = 0.1
"""Least share of the weight of |S|^2 that plants with a negative one leave in the dual."""


class RobustOptimum(NamedTuple):
    """The bound, and the controller it was found with."""

    bound_rms_n: float
    """No linear controller that keeps the peaks, and the drive if asked, leaves less, N."""
    residual_rms_n: float
    """What the last controller found leaves, N; it may go over peaks and drive a little, and so be below the bound."""
    excess: float
    """By what factor it goes over the peaks: 1 keeps them all."""
    drive_rms_n: float
    """Rms of its command, N."""
    stable: bool
    """Whether it stabilises the other plants too, which a small |S| does not tell; if not, the bound may be low."""
    sensitivity: Complex
    """Its S."""


def robust_optimum(spectra: Spectra, ratios: Complex, peaks: Array, largest_drive_n: float = math.inf) -> RobustOptimum:
    """Return the bound and the best controller found.

    Parameters
    ----------
    spectra
        Disturbance, noise and own plant, of `wiener_hopf.bins`.
    ratios
        r over ``(plant, bin)``; 1 is the plant itself.
    peaks
        Largest |S| of each plant, above 1.
    largest_drive_n
        Largest rms of the command, N, above 0.
    """
    found = _priced(spectra, ratios, peaks)
    bound = found[0]
    if _drive(spectra, found[1]) > largest_drive_n**2:
        # Whatever the price of the command is, its dual less the price of what is allowed is a bound too.
        low, high = 0.0, float(spectra.width_hz @ spectra.disturbance) / largest_drive_n**2
        price = high / 30.0
        for _ in range(HALVINGS):
            tried = spectra._replace(price=price)
            found = _priced(tried, ratios, peaks)
            bound = max(bound, found[0] - price * largest_drive_n**2)
            low, high = (price, high) if _drive(spectra, found[1]) > largest_drive_n**2 else (low, price)
            price = math.sqrt(low * high) if low else high / 8.0
    correction = found[1]
    S = 1.0 - spectra.reading * correction
    left = spectra.width_hz @ (squared(S) * spectra.disturbance + squared(correction) * spectra.heard())
    others = ratios + (1.0 - ratios) * S
    return RobustOptimum(
        bound_rms_n=math.sqrt(max(bound, 0.0)),
        residual_rms_n=math.sqrt(float(left)),
        excess=float(np.sqrt(np.max(squared(S) / (np.square(peaks)[:, None] * squared(others))))),
        drive_rms_n=math.sqrt(_drive(spectra, correction)),
        stable=all(_turns(each) == 0 for each in others),
        sensitivity=S,
    )


def _drive(spectra: Spectra, correction: Complex) -> float:
    return float(spectra.width_hz @ (squared(correction) * spectra.drive))


def _turns(response: Complex) -> int:
    """Return how often a response goes around 0 on the unit circle: minus its unstable zeros, with stable poles."""
    return round(float(np.sum(np.angle(response[1:] / response[:-1]))) / math.pi)


def _priced(spectra: Spectra, ratios: Complex, peaks: Array) -> tuple[float, Complex]:
    """Return the dual's value, N^2, with the price of the command in it, and the X found."""
    width, size = spectra.width_hz, spectra.width_hz.size - 1
    total = float(width @ spectra.disturbance)
    disturbance, paid, reading = spectra.disturbance / total, spectra.paid() / total, spectra.reading
    mean, square = 1.0 / float(np.sum(width)), np.square(peaks)[:, None]
    # Steps are taken in M X, in which the part of the cost that is a square of X is one of its samples.
    factor = causal_factor((disturbance + 0.1 * mean) * squared(reading) + paid)
    ends = np.r_[2.0, np.ones(size - 1), 2.0]
    multipliers, penalty = np.zeros(ratios.shape), PENALTY * mean

    def met(samples: Array) -> tuple[Complex, Complex, Complex, Array, float]:
        correction = np.fft.rfft(samples, 2 * size) / factor
        S = 1.0 - reading * correction
        others = ratios + (1.0 - ratios) * S
        cost = float(width @ (disturbance * squared(S) + paid * squared(correction)))
        return correction, S, others, squared(S) - square * squared(others), cost

    def augmented(samples: Array) -> tuple[float, Array]:
        correction, S, others, over, cost = met(samples)
        push = np.maximum(multipliers + penalty * over, 0.0)
        value = cost + float(width @ np.sum(push**2 - multipliers**2, axis=0)) / (2.0 * penalty)
        by_s = width * 2.0 * (disturbance * S + np.sum(push * (S - square * np.conj(1.0 - ratios) * others), axis=0))
        by_x = width * 2.0 * paid * correction - np.conj(reading) * by_s
        return value, np.fft.irfft(by_x / np.conj(factor) * ends, 2 * size)[:size] * size

    samples = 0.3 * np.fft.irfft(disturbance * np.conj(reading / factor), 2 * size)[:size]
    bound = 0.0
    for _ in range(ROUNDS):
        options = {"maxiter": STEPS, "maxcor": 20, "maxfun": 3 * STEPS, "ftol": 1e-9, "gtol": 1e-9}
        samples = minimize(augmented, samples, jac=True, method="L-BFGS-B", options=options).x
        correction, S, others, over, cost = met(samples)
        multipliers = np.maximum(multipliers + penalty * over, 0.0)
        bound = max(bound, total * _dual(spectra, ratios, square, multipliers, total))
        worst = float(np.max(squared(S) / (square * squared(others))))
        if worst <= (1.0 + CLOSE) ** 2 and total * cost <= (1.0 + CLOSE) ** 2 * bound:
            break
        penalty *= 2.0
    return bound, correction


def _dual(spectra: Spectra, ratios: Complex, square: Array, multipliers: Array, total: float) -> float:
    """Return the least of cost + multipliers on the peaks over all X, over ``total``: a bound for multipliers >= 0.

    Where a plant's share in the weight of |S|^2 is negative it is cut back so that a tenth of the weight is left: with
    less than none there is no least.
    """
    curved = 1.0 - square * squared(1.0 - ratios)
    disturbance = spectra.disturbance / total
    up = disturbance + np.sum(multipliers * np.maximum(curved, 0.0), axis=0)
    down = np.sum(multipliers * np.maximum(-curved, 0.0), axis=0)
    kept = np.minimum(1.0, (1.0 - LEAST_LEFT) * up / np.maximum(down, np.finfo(float).tiny))
    multipliers = np.where(curved < 0.0, kept * multipliers, multipliers)
    whole = disturbance + np.sum(multipliers * curved, axis=0)
    # whole |S - centre|^2 is what is quadratic in S, and what is linear.
    centre = np.sum(multipliers * square * ratios * np.conj(1.0 - ratios), axis=0) / whole
    least, _ = least_power(spectra, total * (whole - disturbance), 1.0 - centre)
    constant = whole * squared(centre) + np.sum(multipliers * square * squared(ratios), axis=0)
    return least / total - float(spectra.width_hz @ constant)
