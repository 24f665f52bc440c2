"""The least residual that any linear controller leaves of a disturbance: Bode's integral as a convex problem."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.quantities import Array, Complex, FrictionloopError, must_be

ROUNDS, CLOSE, ENOUGH, FALL = 500, 1e-7, 1e-3, 0.2
"""Newton steps at most, the gap to the least power at which they end, the gap at which rounding may end them, and how
fast it is narrowed."""


class Waterbed(NamedTuple):
    """The least residual, and the sensitivity that has it."""

    residual_rms_n: float
    """Root of the integral of |S|^2 Phi, N."""
    sensitivity: Array
    """|S| at the frequencies of the spectrum."""
    zero_db_hz: float
    """Lowest frequency at which this |S| is 1 or more; NaN if nowhere."""


def waterbed_bound(
    frequency_hz: ArrayLike,
    psd: ArrayLike,
    sensitivity_peak: float,
    nyquist_hz: float,
    *,
    delay_periods: int = 1,
    zeros: Sequence[complex] = (),
) -> Waterbed:
    """Return the least residual of a disturbance under any linear sampled controller with a given largest Ms.

    Minimise the integral of |S|^2 Phi over 0 to the Nyquist frequency, subject to |S| <= Ms and to what a loop cannot
    choose, linear in ln|S|: integral of ln|S| = 0 (Bode), integral of ln|S| cos(n w Ts) = 0 for n below the periods of
    delay, as ln S = s_d z^-d + ..., and ln S = 0 at zeros of the plant outside the unit circle (Poisson's integral).
    Lagrange: |S|^2 = min(Ms^2, p/Phi), with p a constant for Bode's integral alone; delay and zeros add their kernels
    to p. Without the limit on Ms it is the error of the best prediction of the disturbance over the delay.

    It bounds every time-invariant linear feedback from the measured force around this plant, stable law or not (poles
    outside the unit circle raise the integrals). It does not bound a law that knows more of the disturbance (a
    measured load or speed), that is not linear or changes in time, nor the residual of the set-point, which
    feed-forward removes. Residual means S times the disturbance at the sampling instants. Robustness is in it as Ms
    of the nominal loop alone; noise, saturation and what the plant does not do as modelled make the real optimum
    worse.

    Parameters
    ----------
    frequency_hz
        Rising frequencies in Hz, shape (frequencies,), above 0 and up to ``nyquist_hz``. Each stands for the band up to
        half way to its neighbours, the first from 0, the last to ``nyquist_hz``.
    psd
        One-sided density of the disturbance, N^2/Hz, same shape, not negative and somewhere positive.
    sensitivity_peak
        Largest |S|, above 1.
    nyquist_hz
        Half the control rate.
    delay_periods
        Periods from a measured force to the first that answers to it, at least 1 (`stubborn`).
    zeros
        Zeros of the sampled plant outside the unit circle, conjugates included (`stubborn`). None: left out.

    Raises
    ------
    FrictionloopError
        For an argument out of its range.

    References
    ----------
    C. Mohtadi, "Bode's integral theorem for discrete-time systems", IEE Proc. D 137 (1990); J. Freudenberg, D. Looze,
    "Right half plane poles and zeros and design tradeoffs in feedback systems", IEEE Trans. Autom. Control 30 (1985).
    """
    frequency, power = np.asarray(frequency_hz, dtype=float), np.asarray(psd, dtype=float)
    check_spectrum(frequency, power, sensitivity_peak, nyquist_hz)
    _check_plant(delay_periods, zeros)
    edges = np.concatenate([[0.0], (frequency[1:] + frequency[:-1]) / 2, [nyquist_hz]]) * (math.pi / nyquist_hz)
    kernels = _kernels(edges, delay_periods, zeros)
    scale = float(np.max(power))
    least = _flat if len(kernels) == 1 else _least
    log_s = least(np.diff(edges), kernels, power / scale, math.log(sensitivity_peak))
    S, width_hz = np.exp(log_s), np.diff(edges) * (nyquist_hz / math.pi)
    above = frequency[S >= 1.0]
    return Waterbed(math.sqrt(float(width_hz @ (S**2 * power))), S, float(above[0]) if above.size else math.nan)


def _kernels(edges: Array, delay_periods: int, zeros: Sequence[complex]) -> Array:
    """Return the functions of w Ts over which ln|S| integrates to 0, averaged per band, (constraints, frequencies)."""
    rows = [np.ones(edges.size - 1)]
    rows += [np.diff(np.sin(n * edges)) / (n * np.diff(edges)) for n in range(1, delay_periods)]
    for zero in zeros:
        if np.imag(zero) < 0:  # its conjugate says the same
            continue
        # Poisson's (z + e^jw)/(z - e^jw), its mean at w and -w: a sharp peak where a zero is near the circle.
        ahead, behind = _poisson(zero, edges), _poisson(zero, -edges)
        both = (np.diff(ahead) - np.diff(behind)) / (2.0 * np.diff(edges))
        rows += [both.real] + ([both.imag] if np.imag(zero) > 0 else [])
    return np.array(rows)


def _poisson(zero: complex, angle: Array) -> Complex:
    """Return the antiderivative of (z + e^jw)/(z - e^jw) over w."""
    return np.asarray(angle + 2j * np.log(1.0 - np.exp(1j * angle) / zero))


def _flat(width: Array, kernels: Array, power: Array, ceiling: float) -> Array:
    """Return ln|S| = min(ln(p/Phi)/2, ln Ms) of Bode's integral alone: exact, from the loudest band on."""
    loud = power > 0
    level = np.full(power.size, math.inf)
    level[loud] = -0.5 * np.log(power[loud])
    order = np.argsort(level)[: np.count_nonzero(loud)]
    free, total = np.cumsum(width[order]), float(np.sum(width))
    # With the k loudest bands below the ceiling: sum of width (level + shift) = -ceiling (total - free).
    shift = -(ceiling * (total - free) + np.cumsum(width[order] * level[order])) / free
    fits = level[order] + shift <= ceiling
    return np.minimum(level + float(shift[np.flatnonzero(fits)[-1]]), ceiling)


def _least(width: Array, kernels: Array, power: Array, ceiling: float) -> Array:
    """Return ln|S| = L: minimise sum width Phi e^2L subject to kernels width L = 0 and L <= ceiling.

    Newton with a logarithmic barrier of weight m at the ceiling, whose optimum is within m times the width of the
    least power (Boyd & Vandenberghe, Convex Optimization, ch. 11): the second derivative is a diagonal.
    """
    level, rows, total = np.zeros(width.size), kernels * width, float(np.sum(width))
    barrier = float(width @ power) / total

    def objective(L: Array) -> float:
        if not np.max(L) < ceiling:
            return math.inf
        return float(width @ (power * np.exp(2.0 * L) - barrier * np.log(ceiling - L)))

    for _ in range(ROUNDS):
        loud, room = power * np.exp(2.0 * level), ceiling - level
        slope, bend = 2.0 * loud + barrier / room, 4.0 * loud + barrier / room**2
        root = np.sqrt(width / bend)
        q, r = np.linalg.qr((kernels * root).T)
        price = np.linalg.solve(r, q.T @ (root * slope) - np.linalg.solve(r.T, rows @ level))
        move = -(slope - price @ kernels) / bend
        gain = float(width @ (bend * move**2))
        if gain <= 0.1 * barrier * total:
            if barrier * total <= CLOSE * float(width @ loud):
                return level
            barrier *= FALL
            continue
        share, here = 1.0, objective(level)
        while objective(level + share * move) > here - 0.1 * share * gain:
            share /= 2.0
            if share < 1e-9 and barrier * total <= ENOUGH * float(width @ loud):
                return level
        level = level + share * move
    raise FrictionloopError("waterbed_bound: did not converge")


def check_spectrum(frequency: Array, power: Array, peak: float, nyquist_hz: float) -> None:
    """Refuse bands, a density or a largest |S| that `waterbed_bound` does not take."""
    if not (math.isfinite(peak) and peak > 1):
        raise must_be("sensitivity_peak", peak, "above 1, e.g. 1.7")
    if frequency.ndim != 1 or frequency.shape != power.shape or frequency.size < 1:
        raise FrictionloopError(f"frequency_hz, psd: have shapes {frequency.shape} and {power.shape}; must be alike")
    if not (np.all(np.diff(frequency) > 0) and frequency[0] > 0 and frequency[-1] <= nyquist_hz):
        raise FrictionloopError(f"frequency_hz: rising to {nyquist_hz:g} Hz")
    if not (np.all(np.isfinite(power)) and np.all(power >= 0) and np.any(power > 0)):
        raise FrictionloopError("psd: finite, not negative, not 0")


def _check_plant(delay_periods: int, zeros: Sequence[complex]) -> None:
    if delay_periods < 1:
        raise must_be("delay_periods", delay_periods, "at least 1")
    if len(zeros) and not float(np.min(np.abs(np.asarray(zeros)))) > 1:
        raise FrictionloopError("zeros: outside the unit circle")
